"""What operators have in common: polls with a reason, and one sentence instead of a traceback."""

from __future__ import annotations

import traceback
from contextlib import contextmanager
from pathlib import Path

import bpy

from ..core.errors import CrossfieldError, InputError
from . import results


class ReportingOperator:
    """Turns every failure of `run` into a report of one sentence and CANCELLED.

    `run(context)` does the work, computing before it writes, so that a failure changes nothing.
    """

    def execute(self, context):
        try:
            return self.run(context)
        except CrossfieldError as error:
            sentence = str(error)
        except MemoryError:
            sentence = "The memory does not suffice for this mesh; use a coarser one."
        except OSError as error:
            sentence = f"{error.filename or 'A file'}: {error.strerror or error}."
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{Path(place.filename).name}, line {place.lineno}"
            sentence = f"Crossfield failed here ({error!r} in {where}); please report it."
        self.report({"ERROR"}, " ".join(sentence.split()))
        return {"CANCELLED"}


def poll_blocks(operator, context) -> bool:
    """Does the active object have, or belong to, a result with blocks? Says why not."""
    shown = context.object
    if shown is None:
        operator.poll_message_set("There is no active object; select a mesh with blocks.")
        return False
    collection = results.find_collection(shown)
    if collection is None:
        operator.poll_message_set(
            f"{shown.name!r} has no blocks; run Decompose into Blocks on a mesh first."
        )
        return False
    if shown.mode not in {"OBJECT", "EDIT"}:
        operator.poll_message_set("Crossfield runs in object mode and in edit mode only.")
        return False
    if results.find_object(collection, "blocks") is None:
        operator.poll_message_set(
            "These results have no block mesh; run Decompose into Blocks again."
        )
        return False
    return True


def result_of(context):
    """The collection with the results of the active object; raises InputError without blocks."""
    collection = results.find_collection(context.object)
    if collection is None or results.find_object(collection, "blocks") is None:
        raise InputError("There are no blocks here; run Decompose into Blocks on a mesh first.")
    return collection


def result_name(context) -> str:
    """Name of the object that was decomposed to what the active object belongs to."""
    collection = result_of(context)
    source = results.source_of(collection)
    return collection.name if source is None else source.name


@contextmanager
def results_in_object_mode(shown):
    """Leave edit mode while result objects are read or changed, if any of them is being edited."""
    editing = any(result.mode == "EDIT" and results.ROLE in result for result in shown)
    if editing:
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if editing:
            bpy.ops.object.mode_set(mode="EDIT")
