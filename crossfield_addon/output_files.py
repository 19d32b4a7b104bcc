"""Output files that appear together, complete, or not at all."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from ..core.errors import InputError


class OutputFiles:
    """Files and folders that are written under temporary names beside their targets, then renamed.

    As a context manager: leaving it normally puts all of them in place; leaving it by any
    exception removes whatever was written and leaves the targets as they were.
    """

    def __init__(self):
        self._pending: list[tuple[Path, Path]] = []

    def __enter__(self):
        return self

    def temporary(self, target: Path) -> Path:
        """The name to write to now for a file that is to be named `target`."""
        name = f".{target.stem}-unfinished-{os.getpid()}{target.suffix}"
        temporary = target.with_name(name)
        self._pending.append((temporary, target))
        return temporary

    def __exit__(self, kind, error, trace):
        try:
            if kind is None:
                for temporary, target in self._pending:
                    if temporary.is_dir() and target.exists():
                        # A folder cannot be replaced by another one in a single step.
                        shutil.rmtree(target)
                    os.replace(temporary, target)
        finally:
            for temporary, _ in self._pending:
                if temporary.is_dir():
                    shutil.rmtree(temporary, ignore_errors=True)
                temporary.unlink(missing_ok=True)


def check_targets(targets: list[Path], source: Path) -> None:
    """Refuse, before any work, targets that cannot be written or that would destroy the input.

    Raises InputError.
    """
    seen = {source.resolve(): "the input"}
    for target in targets:
        place = target.resolve()
        if place in seen:
            raise InputError(f"{target} is {seen[place]} too; choose another name for the output.")
        seen[place] = "another output"
        if target.is_dir() and not _holds_blocks(target):
            raise InputError(f"{target} is a directory; name a file to write.")
        if not place.parent.is_dir():
            raise InputError(f"The directory {place.parent} does not exist; create it first.")
        if not os.access(place.parent, os.W_OK):
            raise InputError(f"The directory {place.parent} cannot be written to; choose another.")


def _holds_blocks(folder: Path) -> bool:
    """Is it a folder of VTK blocks that an earlier run has written, and nothing else?"""
    entries = list(folder.iterdir())
    return (
        folder.name.endswith("_vtm")
        and bool(entries)
        and all(entry.is_file() and entry.suffix == ".vts" for entry in entries)
    )
