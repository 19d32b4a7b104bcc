"""OpenFOAM's blockMeshDict of a block layout, extruded by one cell along the normals.

A hexahedron has the corners of a block in front and their images behind; its cells lie in the cell
zone block_0000 and so on. blockMesh refuses blocks whose corners alone are inside out: these are cut
in parts, all in the zone of their block. Curved edges are polyLines through the vertices of the quad
mesh, graded so that blockMesh puts its points onto these. Inside a block or part blockMesh
interpolates by itself.
"""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import forward_sides
from ..divisions.regridding import edge_chain
from .boundary_patches import Patches
from .plain_hexahedra import cut_to_plain_hexahedra

_SAME_RATIO = 1e-9
_UNIFORM = 1e-8
_HEADER = """\
/* Multi-block decomposition by Crossfield */
FoamFile
{
    version     2.0;
    format      ascii;
    class       dictionary;
    object      blockMeshDict;
}

convertToMeters 1;
"""


def block_mesh_dict(
    points, back, quads, blocks: Blocks, patches: Patches, planar: bool
) -> bytes:
    """The content of a blockMeshDict.

    points   (P, 3) float64, the vertices of the quad mesh: the patch "front"
    back     (P, 3) float64, the same moved along the normals: the patch "back"
    quads    (Q, 4) int64
    patches  Patches of the edges of the blocks
    planar   True makes front and back of type empty, for flow in the plane
    """
    parts, owner = cut_to_plain_hexahedra(points, back, quads, blocks)
    patch = _patches_of_parts(blocks, parts, patches.edge_patch, len(points))
    return _content(points, back, parts, owner, Patches(patches.name, patch), planar)


def _patches_of_parts(blocks: Blocks, parts: Blocks, edge_patch, count):
    """(E',) int64, the patch of each edge of the parts, found by its first two vertices."""
    first, second = blocks.edge_vertex[:-1], blocks.edge_vertex[1:]
    key = np.minimum(first, second) * np.int64(count) + np.maximum(first, second)
    whole = np.repeat(np.arange(len(edge_patch)), np.diff(blocks.edge_offset))[:-1]
    key[blocks.edge_offset[1:-1] - 1] = -1  # from one chain to the next
    order = np.argsort(key)
    start = parts.edge_offset[:-1]
    ends = np.sort(np.stack([parts.edge_vertex[start], parts.edge_vertex[start + 1]]), axis=0)
    wanted = ends[0] * np.int64(count) + ends[1]
    place = order[np.minimum(np.searchsorted(key[order], wanted), len(order) - 1)]
    return np.where(key[place] == wanted, edge_patch[whole[place]], -1)


def _content(points, back, blocks: Blocks, zone, patches: Patches, planar) -> bytes:
    vertex, number = np.unique(blocks.corner, return_inverse=True)
    corner = number.reshape(-1, 4)
    label = np.full(len(points), -1)
    label[vertex] = np.arange(len(vertex))
    behind = corner + len(vertex)
    lines = [_HEADER, "vertices", "("]
    lines += [f"    {_point(p)}" for sheet in (points, back) for p in sheet[vertex].tolist()]
    lines += [");", "", "blocks", "("]
    gradings = [_edge_gradings(sheet, blocks) for sheet in (points, back)]
    forward = forward_sides(blocks)
    for block, (m, n) in enumerate(blocks.shape.tolist()):
        joined = " ".join(map(str, [*corner[block].tolist(), *behind[block].tolist()]))
        lines.append(f"    hex ({joined}) block_{zone[block]:04d} ({m} {n} 1)")
        lines.append(f"    edgeGrading ({_grading(blocks, block, forward[block], gradings)})")
    lines += [");", "", "edges", "("]
    for sheet, shift in ((points, 0), (back, len(vertex))):
        for edge in np.flatnonzero(np.diff(blocks.edge_offset) > 2):
            lines += _poly_line(sheet, edge_chain(blocks, edge), label, shift)
    lines += [");", "", "boundary", "("]
    lines += _patch("front", corner[:, [0, 3, 2, 1]], "empty" if planar else "patch")
    lines += _patch("back", behind, "empty" if planar else "patch")
    for number, name in enumerate(patches.name):
        block, side = np.nonzero(patches.edge_patch[blocks.block_edge] == number)
        after = (side + 1) % 4
        faces = np.stack([
            corner[block, side], corner[block, after], behind[block, after], behind[block, side]
        ], axis=1)
        lines += _patch(name, faces, "patch")
    lines += [");", "", "mergePatchPairs", "(", ");", ""]
    return "\n".join(lines).encode("ascii")


def _point(point):
    x, y, z = point
    return f"({x!r} {y!r} {z!r})"


def _poly_line(sheet, chain, label, shift):
    start, end = label[chain[0]] + shift, label[chain[-1]] + shift
    return [
        f"    polyLine {start} {end}", "    (",
        *(f"        {_point(p)}" for p in sheet[chain[1:-1]].tolist()), "    )",
    ]


def _patch(name, faces, kind):
    lines = [f"    {name}", "    {", f"        type {kind};", "        faces", "        ("]
    lines += [f"            ({a} {b} {c} {d})" for a, b, c, d in faces.tolist()]
    return [*lines, "        );", "    }"]


def _edge_gradings(sheet, blocks):
    """List of E pairs: the grading along the edge as it is stored, and reversed."""
    result = []
    for edge in range(len(blocks.edge_offset) - 1):
        cell = np.linalg.norm(np.diff(sheet[edge_chain(blocks, edge)], axis=0), axis=1)
        result.append((_sections(cell), _sections(cell[::-1])))
    return result


def _sections(cell) -> str:
    """Multi-grading of cells of given lengths: runs of one growth ratio are one section each."""
    if np.ptp(cell) <= _SAME_RATIO * cell.mean():
        return "1"
    share = cell / cell.sum()
    ratio = share[1:] / share[:-1]
    sections, first = [], 0
    while first < len(share):
        last = first + 1
        while last < len(share) and abs(ratio[last - 1] / ratio[first] - 1) <= _SAME_RATIO:
            last += 1
        # A run of two cells has a ratio by chance; it is left to the run that follows.
        last = first + 1 if last == first + 2 else last
        length, growth = share[first:last].sum(), share[last - 1] / share[first]
        # blockMesh divides by the growth less 1 wherever it is not exactly 1.
        growth = 1.0 if abs(growth - 1) <= _UNIFORM else growth
        sections.append(f"({float(length)!r} {last - first} {float(growth)!r})")
        first = last
    return "(" + " ".join(sections) + ")"


def _grading(blocks, block, forward, gradings):
    """Twelve gradings in blockMesh's order: four edges along the first direction, the second, k."""
    front, back = (
        [sheet[edge][0 if ahead else 1] for edge, ahead in zip(blocks.block_edge[block], forward)]
        for sheet in gradings
    )
    # Sides 2 and 3 run against the directions that blockMesh grades along.
    front_turned, back_turned = (
        [sheet[edge][1 if ahead else 0] for edge, ahead in zip(blocks.block_edge[block], forward)]
        for sheet in gradings
    )
    return " ".join([
        front[0], front_turned[2], back_turned[2], back[0],
        front_turned[3], front[1], back[1], back_turned[3], "1", "1", "1", "1",
    ])
