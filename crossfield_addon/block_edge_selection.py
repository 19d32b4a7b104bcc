"""Which block edges the user has selected: on the block mesh, or on the curve of the boundaries."""

from __future__ import annotations

import numpy as np

from ..core.errors import InputError
from .result_objects import ROLE, read_numbers


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


def select_edges(active, edges) -> None:
    """Select block edges on a curve that was made anew; a block mesh keeps its selection."""
    if active is not None and active.get(ROLE) == "edges":
        for edge in edges:
            for point in active.data.splines[edge].points:
                point.select = True
