"""Which block edges the user has selected: on the block mesh, or on the curve of the boundaries."""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import numpy as np

from ..core.errors import InputError
from .result_objects import FOLLOWS, FREE, LOCKED, ROLE, read_numbers


def selected_edges(active, blocks) -> np.ndarray:
    """(n,) int64, ascending numbers of the selected block edges; nothing may be in edit mode.

    active  the active object: on the curve of the block boundaries, a block edge is selected where
            any of its points is; on all other objects the edges of the block mesh count
    blocks  the block mesh object

    Raises InputError for curves between blocks with T-junctions, which are no block edges.
    """
    number = read_numbers(blocks.data, "EDGE", "block_edge")
    if active is not None and active.get(ROLE) == "edges":
        if len(active.data.splines) != number.max(initial=-1) + 1:
            raise InputError(
                "These curves are not the block edges one by one; select edges of the block mesh."
            )
        chosen = [
            any(point.select for point in spline.points) for spline in active.data.splines
        ]
        return np.flatnonzero(chosen)
    select = np.zeros(len(blocks.data.edges), bool)
    blocks.data.edges.foreach_get("select", select)
    return np.unique(number[select])


@dataclass(frozen=True)
class BlockEdge:
    """Number, divisions and lock_state of a block edge."""

    number: int
    divisions: int
    state: int

    def sentence(self) -> str:
        """For the panel."""
        state = {FREE: "", FOLLOWS: ", follows a lock", LOCKED: ", locked"}[self.state]
        return f"Edge {self.number}: {self.divisions} quads{state}"


def active_block_edge(active) -> BlockEdge | None:
    """The block edge that was selected last in edit mode of a block mesh, or None.

    Where none was selected alone, the first one of those that are selected.
    """
    if active is None or active.get(ROLE) != "blocks" or active.mode != "EDIT":
        return None
    edited = bmesh.from_edit_mesh(active.data)
    edge = edited.select_history.active
    if not isinstance(edge, bmesh.types.BMEdge):
        edge = next((e for e in edited.edges if e.select), None)
    layers = edited.edges.layers.int
    names = "block_edge", "divisions", "lock_state"
    if edge is None or not all(name in layers for name in names):
        return None
    return BlockEdge(*(edge[layers[name]] for name in names))


def present_divisions(active) -> int:
    """Divisions of a block edge that is selected in edit mode, or 0; as a number to start from."""
    if active is not None and active.get(ROLE) == "edges":
        counts = [
            len(spline.points) - 1
            for spline in active.data.splines
            if any(point.select for point in spline.points)
        ]
        return counts[0] if counts else 0
    edge = active_block_edge(active)
    return 0 if edge is None else edge.divisions


def select_edges(active, edges) -> None:
    """Select block edges on a curve that was made anew; a block mesh keeps its selection."""
    if active is not None and active.get(ROLE) == "edges":
        for edge in edges:
            for point in active.data.splines[edge].points:
                point.select = True
