"""From a Decomposition to what the user sees: one collection of result objects for each input.

The collection remembers its input object by an ID property, so that it is found again after
either of them was renamed. Result objects are children of the input with no transform of their
own: they stand in its place and scale and follow it.
"""

from __future__ import annotations

import json

import bpy
import numpy as np

from ..core.blocks.block_quality import block_quality
from . import attributes, kept_blocks, markers, palette, quality_colours
from .result_objects import (
    ROLE,
    block_object,
    boundary_object,
    curve_object,
    display_size,
    quad_object,
    singularity_empties,
    write_divisions,
)
from .wanted_divisions import WantedDivisions

# Identifier, label and description of each product that can be left out.
PRODUCTS = (
    ("QUADS", "Quads", "The quad mesh"),
    ("BOUNDARIES", "Boundaries", "The curves between the blocks"),
    ("SINGULARITIES", "Singularities", "An empty at each singularity"),
)
ALL_PRODUCTS = frozenset(product[0] for product in PRODUCTS)
_NOTHING_WANTED = WantedDivisions()
# Objects of these roles stay in a collection when results are replaced, and get new data.
_LASTING = "quads", "edges", "blocks", "lines"
_SOURCE = "crossfield_source"
_SENTENCE = "crossfield_sentence"
_NOTES = "crossfield_notes"
_QUALITY = "crossfield_summary"
# Blocks whose quality the panel names: the worst ones.
_NAMED_BLOCKS = 5


def write_results(
    scene, source, arrays, decomposition, keep_lines=False, products=ALL_PRODUCTS, computed=None,
    wanted=_NOTHING_WANTED,
) -> list[str]:
    """Replace the results of an object by those of a decomposition.

    arrays    the MeshArrays that were decomposed
    computed  the decomposition before it was divided as wanted, None where nothing was wanted

    Returns the notes for the user: warnings of the core, and a sentence when the attributes could
    not be written. Objects that were there before stay and get new contents.
    """
    notes = list(decomposition.warnings)
    obstacle = _obstacle(source, arrays)
    if obstacle:
        notes.append(obstacle)
    else:
        values = attributes.attribute_values(computed or decomposition, len(arrays.points))
        attributes.write_attributes(source, values)
    collection = _collection(scene, source)
    _remove_objects(o for o in collection.objects if o.get(ROLE) == "singularity")
    fresh = _result_objects(source, decomposition, keep_lines, products, wanted)
    for result in fresh:
        if result[ROLE] == "blocks":
            kept_blocks.keep(result.data, computed or decomposition, wanted)
    shown = _put_in_place(collection, source, fresh)
    for result in shown:
        if result[ROLE] == "blocks":
            _hide(result)
    _tell(collection, decomposition, notes)
    return notes


def update_divisions(collection, source, decomposition, wanted: WantedDivisions) -> None:
    """Show the blocks of a result as they are divided anew; the block mesh keeps its place."""
    blocks = find_object(collection, "blocks")
    name = source.name if source is not None else collection.name
    write_divisions(blocks.data, decomposition.quads, decomposition.blocks, wanted.locks)
    kept_blocks.keep_wanted(blocks.data, wanted)
    fresh = [quad_object(f"{name} quads", decomposition)]
    if find_object(collection, "edges") is not None:
        fresh.append(_boundaries(name, decomposition, wanted))
    _put_in_place(collection, source, fresh, keep_others=True)
    _tell(collection, decomposition, decomposition.warnings)


def _tell(collection, decomposition, notes):
    collection[_SENTENCE] = decomposition.sentence()
    collection[_NOTES] = "\n".join(notes)
    collection[_QUALITY] = json.dumps(_quality_rows(decomposition))
    quads = find_object(collection, "quads")
    if quads is not None:
        quality_colours.paint_again(collection, quads)


def _obstacle(source, arrays) -> str:
    """Why the mesh cannot take attributes, or ""; ours from an earlier run are removed then."""
    if not source.data.is_editable:
        return "The mesh is linked from another file, so no attributes were written onto it."
    if arrays.on_object:
        return ""
    attributes.remove_attributes(source)
    return (
        "Modifiers change the faces of this mesh, so no attributes were written onto it; "
        "apply the modifiers to have them."
    )


def remove_results(source) -> bool:
    """Remove the results and attributes of an object; True when there were any."""
    removed = source.data.is_editable and attributes.remove_attributes(source)
    collection = find_collection(source)
    if collection is None:
        return removed
    _remove_objects(o for o in collection.objects if o.get(ROLE) == "singularity")
    _remove_objects(_lasting_objects(collection).values())
    for key in [key for key in collection.keys() if key.startswith("crossfield_")]:
        del collection[key]
    if not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)
    markers.remove_unused()
    palette.remove_unused()
    return True


def find_collection(shown):
    """The collection with the results of an object, or with that object as one of them, or None."""
    if shown is None:
        return None
    for collection in bpy.data.collections:
        if _SOURCE in collection and collection[_SOURCE] == shown:
            return collection
    if ROLE in shown:
        for collection in shown.users_collection:
            if _SOURCE in collection:
                return collection
    return None


def source_of(collection):
    """The object that was decomposed, or None when it was deleted."""
    return collection[_SOURCE]


def source_for(shown):
    """The object to decompose when an object is active: that which a result was made from.

    An object that is no result, or whose mesh was deleted, stands for itself; None for None.
    """
    collection = find_collection(shown)
    source = None if collection is None else source_of(collection)
    return shown if source is None else source


def find_object(collection, role):
    """The object of a result that is the "quads", "edges" (boundaries) or "blocks", or None."""
    for shown in collection.objects:
        if shown.get(ROLE) == role:
            return shown
    return None


def _lasting_objects(collection) -> dict:
    """Role -> object; copies that the user has made of them are not among them."""
    found = {role: find_object(collection, role) for role in _LASTING}
    return {role: shown for role, shown in found.items() if shown is not None}


def result_text(shown) -> tuple[str, list[str]]:
    """The sentence on the results of an object and the notes, ("", []) without results."""
    collection = find_collection(shown)
    if collection is None:
        return "", []
    return collection.get(_SENTENCE, ""), collection.get(_NOTES, "").splitlines()


def quality_table(collection) -> list:
    """Rows of text on the grid quality of a result: what, worst, mean; the worst blocks at last."""
    return [] if collection is None else json.loads(collection.get(_QUALITY, "[]"))


def _quality_rows(decomposition):
    layout, quads = decomposition.layout, decomposition.quads
    if layout is None:
        return []
    quality = block_quality(quads.points, quads.quads, layout, quads.scaled_jacobian)
    rows = [
        (name, f"{worst(value):.3g}", f"{value.mean():.3g}")
        for name, value, worst in (
            ("Scaled Jacobian", quality.scaled_jacobian, np.min),
            ("Skewness", quality.skewness, np.max),
            ("Aspect Ratio", quality.aspect_ratio, np.max),
        )
    ]
    lowest, mean = quality.min_scaled_jacobian, quality.mean_scaled_jacobian
    for block in np.argsort(lowest, kind="stable")[:_NAMED_BLOCKS].tolist():
        m, n = layout.shape[block].tolist()
        rows.append((f"Block {block}: {m} x {n}", f"{lowest[block]:.3g}", f"{mean[block]:.3g}"))
    return rows


def _collection(scene, source):
    """The object's collection of results, linked to the scene."""
    collection = find_collection(source)
    if collection is None or source_of(collection) != source:
        collection = bpy.data.collections.new(f"Crossfield {source.name}")
        collection[_SOURCE] = source
    if collection not in scene.collection.children_recursive:
        scene.collection.children.link(collection)
    return collection


def _put_in_place(collection, source, fresh, keep_others=False):
    """Show fresh objects; one that is there already gets the data of the fresh one instead.

    Results that nothing replaces are removed, unless they are to be kept. Returns the objects that
    are new to the collection.
    """
    old = _lasting_objects(collection)
    replaced = {o[ROLE] for o in fresh} & old.keys()
    if not keep_others:
        _remove_objects(o for role, o in old.items() if role not in replaced)
    new = []
    for result in fresh:
        if result[ROLE] in replaced:
            _take_over(old[result[ROLE]], result)
            continue
        result.parent = source
        result.show_in_front = True
        collection.objects.link(result)
        new.append(result)
    return new


def _take_over(shown, fresh):
    """Give an object the data of a fresh one, which vanishes."""
    before, name = shown.data, shown.data.name
    shown.data = fresh.data
    bpy.data.objects.remove(fresh)
    _remove_data(before)
    shown.data.name = name


def _remove_objects(shown):
    """Remove objects and their data; anything else the user put into a collection stays."""
    for result in list(shown):
        data = result.data
        bpy.data.objects.remove(result)
        _remove_data(data)


def _remove_data(data):
    if data is not None and not data.users:
        pool = bpy.data.meshes if isinstance(data, bpy.types.Mesh) else bpy.data.curves
        pool.remove(data)


def _hide(shown):
    """Hide an object in the view layer of the context, as its eye in the outliner does."""
    bpy.context.view_layer.update()
    if shown.name in bpy.context.view_layer.objects:
        shown.hide_set(True)


def _result_objects(source, decomposition, keep_lines, products, wanted):
    """New, unlinked objects for all that was computed."""
    size, results = display_size(decomposition), []
    if "SINGULARITIES" in products:
        results = singularity_empties(source.name, *decomposition.singular_points(), 3 * size)
    complex_, blocks = decomposition.complex, decomposition.blocks
    if complex_ is not None and (keep_lines or blocks is None):
        lines = np.split(complex_.arc_point, complex_.arc_offset[1:-1])
        results.append(curve_object(f"{source.name} lines", lines, 0.4 * size, "lines"))
    if blocks is not None:
        if "BOUNDARIES" in products:
            results.append(_boundaries(source.name, decomposition, wanted))
        results.append(block_object(f"{source.name} blocks", decomposition, wanted.locks))
        if "QUADS" in products:
            results.append(quad_object(f"{source.name} quads", decomposition))
    return results


def _boundaries(name, decomposition, wanted):
    radius = 0.4 * display_size(decomposition)
    return boundary_object(f"{name} block boundaries", decomposition, radius, wanted.locks)
