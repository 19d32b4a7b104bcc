"""How blocks join: which part of which side lies along which part of another one."""

from __future__ import annotations

import numpy as np

from .blocks import Blocks
from .t_layout import TLayout


def interfaces(layout: Blocks | TLayout) -> list:
    """One dict for each edge, ready for JSON: how the sides of two blocks join.

    "edge": its number, "sides": for each of its one or two sides {"block", "side", "nodes"}. Sides
    0 to 3 run counter-clockwise; nodes are those of the side at which the edge begins and ends,
    counted from 0 at the side's first corner. The first node of one side is the first of the other.
    """
    size = np.diff(layout.edge_offset) - 1
    side = np.repeat(np.arange(4 * layout.count), np.diff(layout.side_offset))
    result = [{"edge": edge, "sides": []} for edge in range(len(size))]
    for owner, edge, start, forward in zip(
        side.tolist(), layout.side_edge.tolist(), layout.side_start.tolist(),
        layout.side_forward.tolist(),
    ):
        nodes = [start, start + int(size[edge])]
        result[edge]["sides"].append({
            "block": owner // 4, "side": owner % 4, "nodes": nodes if forward else nodes[::-1],
        })
    return result
