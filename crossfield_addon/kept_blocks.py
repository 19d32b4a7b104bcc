"""What the block mesh object of a result knows: the blocks as computed, locks, and other wishes.

The decomposition as it was computed is kept as custom properties of the block mesh, exactly, so
that after saving and loading the blocks can be divided anew and exported. Locks are the edge attribute
`lock` of the block mesh: the wanted number of quads, 0 where there is none.
"""

from __future__ import annotations

import json

import numpy as np

from ..core.errors import InputError
from ..core.kept_result import from_arrays, to_arrays
from .result_objects import read_numbers
from .wanted_divisions import WantedDivisions, from_text

_KEPT = "crossfield_kept"
_WANTED = "crossfield_wanted"
_LOST = "The block mesh was changed so that its numbers are lost; decompose the mesh again."


def keep(mesh, decomposition, wanted: WantedDivisions) -> None:
    """Store a decomposition, not divided anew yet, and what it is to be divided into."""
    mesh[_KEPT] = {}
    kept = mesh[_KEPT]
    for name, value in to_arrays(decomposition).items():
        kept[name] = value
    keep_wanted(mesh, wanted)


def keep_wanted(mesh, wanted: WantedDivisions) -> None:
    """Store what the blocks are divided into; locks are attributes, not written here."""
    mesh[_WANTED] = wanted.text()


def kept_decomposition(mesh):
    """The decomposition that was stored; raises InputError where it is missing or damaged."""
    kept = mesh.get(_KEPT)
    if kept is None:
        raise InputError(_LOST)
    return from_arrays({
        name: value if isinstance(value, str) else np.asarray(memoryview(value))
        for name, value in kept.items()
    })


def wanted_divisions(mesh) -> WantedDivisions:
    """What the blocks are divided into, locks included; the mesh must not be in edit mode."""
    try:
        edge, lock = read_numbers(mesh, "EDGE", "block_edge"), read_numbers(mesh, "EDGE", "lock")
        pairs = np.unique(np.stack([edge, lock], axis=1)[lock > 0], axis=0)
        return from_text(mesh[_WANTED], tuple(map(tuple, pairs.tolist())))
    except (KeyError, TypeError, json.JSONDecodeError):
        raise InputError(_LOST) from None
