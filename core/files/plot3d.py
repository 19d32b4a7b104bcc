"""PLOT3D grids: multi-block, three-dimensional, whole format; and their neutral map file.

Block b has i along its first direction, j along its second and k through the extrusion; i runs
fastest. The neutral map file names the boundary of each block: faces k min, k max, i min, i max,
j min, j max are 1 to 6, ranges are given in cyclic order (i, j), (j, k), (k, i).
"""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.interfaces import interfaces
from ..blocks.t_layout import TLayout
from ..divisions.regridding import block_grid
from .boundary_patches import Patches

FORMS = ("ascii", "binary", "unformatted")
# Faces of sides corner0-corner1 (j min), 1-2 (i max), 2-3 (j max), 3-0 (i min).
_SIDE_FACE = (5, 4, 6, 3)


def plot3d_grid(points, blocks: Blocks | TLayout, form: str = "ascii", back=None) -> bytes:
    """The content of a PLOT3D grid file.

    points  (P, 3) float64
    form    "ascii"; "binary": 4-byte integers and 8-byte reals in a row, little-endian;
            "unformatted": the same as Fortran records
    back    (P, 3) float64 or None; the second k plane of extruded blocks
    """
    sheets = [points] if back is None else [points, back]
    sizes = np.array([(*(shape + 1), len(sheets)) for shape in blocks.shape], np.int32)
    values = (
        np.stack([sheet[block_grid(blocks, b)] for sheet in sheets]).reshape(-1, 3).T.ravel()
        for b in range(blocks.count)
    )
    if form == "ascii":
        lines = [str(blocks.count), *(" ".join(map(str, size)) for size in sizes.tolist())]
        for value in values:
            lines += [" ".join(map(repr, row)) for row in _rows(value.tolist(), 3)]
        return ("\n".join(lines) + "\n").encode("ascii")
    records = [np.array([blocks.count], "<i4"), sizes.astype("<i4")]
    records += [value.astype("<f8") for value in values]
    if form == "binary":
        return b"".join(record.tobytes() for record in records)
    marks = [np.array([record.nbytes], "<i4").tobytes() for record in records]
    return b"".join(m + record.tobytes() + m for m, record in zip(marks, records))


def _rows(values, size):
    return (values[k : k + size] for k in range(0, len(values), size))


def neutral_map(blocks: Blocks | TLayout, patches: Patches, extruded: bool) -> bytes:
    """The neutral map file of a grid: how blocks join, and the patch of each free side.

    Blocks with T-junctions join along parts of their sides.
    """
    depth = 2 if extruded else 1
    lines = ["# Neutral map file of a multi-block grid by Crossfield", "# Block IDIM JDIM KDIM"]
    lines.append(str(blocks.count))
    for block, (m, n) in enumerate(blocks.shape.tolist()):
        lines.append(f"{block + 1} {m + 1} {n + 1} {depth}")
    lines.append("# Type B1 F1 S1 E1 S2 E2 B2 F2 S1 E1 S2 E2 Swap")
    if extruded:
        for block, (m, n) in enumerate(blocks.shape.tolist()):
            for name, face in (("front", 1), ("back", 2)):
                lines.append(f"{name} {block + 1} {face} 1 {m + 1} 1 {n + 1}")
    joins, seen = interfaces(blocks), set()
    for edge in blocks.side_edge.tolist():
        sides = joins[edge]["sides"]
        ranges = " ".join(_face_ranges(blocks, sides, depth))
        if blocks.edge_on_boundary[edge]:
            lines.append(f"{patches.name[patches.edge_patch[edge]]} {ranges}")
        elif edge in seen:
            swap = "TRUE" if (sides[0]["side"] - sides[1]["side"]) % 2 else "FALSE"
            lines.append(f"ONE_TO_ONE {ranges} {swap}")
        seen.add(edge)
    return ("\n".join(lines) + "\n").encode("ascii")


def _face_ranges(blocks, sides, depth):
    """Block, face and both ranges for each of the sides of an edge; the first range rises."""
    result, turned = [], False
    for number, join in enumerate(sides):
        block, side, nodes = join["block"], join["side"], join["nodes"]
        if side >= 2:
            # These sides run against the grid.
            nodes = [int(blocks.shape[block][side % 2]) - node for node in nodes]
        turned = nodes[0] > nodes[1] if number == 0 else turned
        along = "{1} {0}" if turned else "{0} {1}"
        along = along.format(nodes[0] + 1, nodes[1] + 1)
        # Ranges come in cyclic order: (k, i) on j faces, (j, k) on i faces.
        pair = f"1 {depth} {along}" if side % 2 == 0 else f"{along} 1 {depth}"
        result.append(f"{block + 1} {_SIDE_FACE[side]} {pair}")
    return result
