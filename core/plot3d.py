"""PLOT3D grids: multi-block, three-dimensional, whole format; and their neutral map file.

Block b has i along its first direction, j along its second and k through the extrusion; i runs
fastest. The neutral map file names the boundary of each block: faces k min, k max, i min, i max,
j min, j max are 1 to 6, ranges are given in cyclic order (i, j), (j, k), (k, i).
"""

from __future__ import annotations

import numpy as np

from .blocks import Blocks
from .boundary_patches import Patches
from .chords import forward_sides
from .regridding import block_grid

FORMS = ("ascii", "binary", "unformatted")
# Faces of sides corner0-corner1 (j min), 1-2 (i max), 2-3 (j max), 3-0 (i min).
_SIDE_FACE = (5, 4, 6, 3)


def plot3d_grid(points, blocks: Blocks, form: str = "ascii", back=None) -> bytes:
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


def neutral_map(blocks: Blocks, patches: Patches, extruded: bool) -> bytes:
    """The neutral map file of a grid: how blocks join, and the patch of each free side."""
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
    forward = forward_sides(blocks)
    seen = {}
    for block, side in np.ndindex(blocks.count, 4):
        edge = int(blocks.block_edge[block, side])
        if blocks.edge_on_boundary[edge]:
            name = patches.name[patches.edge_patch[edge]]
            lines.append(f"{name} {_face_range(blocks, block, side, depth, False)}")
        elif edge in seen:
            first, there = seen[edge]
            # A side and its edge run alike in rising grid index where both agree with the other.
            alike = forward[block, side] == (side < 2)
            backwards = alike != (forward[first, there] == (there < 2))
            swap = "TRUE" if there % 2 != side % 2 else "FALSE"
            lines.append(
                f"ONE_TO_ONE {_face_range(blocks, first, there, depth, False)} "
                f"{_face_range(blocks, block, side, depth, backwards)} {swap}"
            )
        else:
            seen[edge] = block, side
    return ("\n".join(lines) + "\n").encode("ascii")


def _face_range(blocks, block, side, depth, backwards):
    """Block, face, and both ranges of a side, the one along the edge turned if `backwards`."""
    count = int(blocks.shape[block][side % 2]) + 1
    along = f"{count} 1" if backwards else f"1 {count}"
    through = f"1 {depth}"
    # Ranges come in cyclic order: (k, i) on j faces, (j, k) on i faces.
    pair = f"{through} {along}" if side % 2 == 0 else f"{along} {through}"
    return f"{block + 1} {_SIDE_FACE[side]} {pair}"
