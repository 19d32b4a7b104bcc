"""A grid patch cut into side-by-side cells: line graph, cell mesh and quad layout by hand."""

import itertools

import numpy as np

from core.cells.cells import CellComplex, CellMesh, NodeKind
from core.quads.quads import QuadLayout
from core.surface.boundary import build_loops
from tests.core.patches import grid_quads, patch


def strip(shape, m, n, cuts, jitter=0.0, seed=0):
    """(surface, complex, cell_mesh) of a patch of m x n grid squares cut at columns cuts.

    Arcs: bottom ones, top ones (right to left), left wall (down), right wall (up), inner cuts (up).
    """
    surface = patch(shape, m, n, jitter=jitter, seed=seed)
    column = [0, *cuts, m]
    cells = len(column) - 1
    index = np.arange((m + 1) * (n + 1)).reshape(n + 1, m + 1)
    paths = [index[0, a : b + 1] for a, b in itertools.pairwise(column)]
    paths += [index[n, a : b + 1][::-1] for a, b in itertools.pairwise(column)]
    paths += [index[::-1, 0], index[:, m]] + [index[:, c] for c in cuts]
    bottom, top = np.arange(cells + 1), np.arange(cells + 1, 2 * cells + 2)
    ends = [(k, k + 1) for k in range(cells)] + [(top[k + 1], top[k]) for k in range(cells)]
    ends += [(top[0], 0), (cells, top[-1])] + [(k, top[k]) for k in range(1, cells)]
    complex = _complex(surface, index, column, paths, np.array(ends), bottom, top)
    return surface, complex, _cell_mesh(surface, complex, index, column, paths)


def _complex(surface, index, column, paths, ends, bottom, top):
    cells = len(column) - 1
    loops = build_loops(surface)
    on_loop = np.arange(len(ends)) < 2 * cells + 2
    position = {v: p for v, p in zip(surface.tail[loops.halfedge].tolist(), loops.position)}
    vertex = np.concatenate([index[0, column], index[-1, column]])
    kind = np.full(len(vertex), NodeKind.WALL)
    kind[[0, cells, cells + 1, -1]] = NodeKind.CORNER
    holder = {int(v): f for f, t in enumerate(surface.triangles) for v in t}
    ends_of_halfedge = zip(surface.tail.tolist(), surface.head.tolist())
    edge = {pair: h // 3 for h, pair in enumerate(ends_of_halfedge)}
    faces = [
        [edge.get((a, b), edge.get((b, a))) for a, b in zip(path[:-1].tolist(), path[1:].tolist())]
        for path in paths
    ]
    walls = [2 * (2 * cells) + 0] + [2 * (2 * cells + 2 + k) for k in range(cells - 1)]
    walls.append(2 * (2 * cells + 1))
    sides = []
    for k in range(cells):
        left = walls[0] if k == 0 else walls[k] + 1
        sides += [2 * k, walls[k + 1], 2 * (cells + k), left]
    return CellComplex(
        surface.points[vertex], kind.astype(np.int64), np.where(kind == NodeKind.CORNER, 1, 2),
        np.ones(len(vertex), bool), np.array([holder[int(v)] for v in vertex]), ends,
        np.where(on_loop, 0, -1),
        np.array([position[int(p[0])] if o else 0.0 for p, o in zip(paths, on_loop)]),
        np.concatenate([[0], np.cumsum([len(p) for p in paths])]),
        surface.points[np.concatenate(paths)],
        np.concatenate([f + f[-1:] for f in faces]),
        np.arange(4 * cells + 1), np.array(sides),
    )


def _cell_mesh(surface, complex, index, column, paths):
    point, triangle, cell, face, wall = [], [], [], [], []
    base = 0
    used_column = np.zeros(surface.vertex_count, np.int64)
    used_column[index] = np.arange(index.shape[1])
    for k, (a, b) in enumerate(itertools.pairwise(column)):
        vertices = index[:, a : b + 1].ravel()
        number = np.full(surface.vertex_count, -1)
        number[vertices] = base + np.arange(len(vertices))
        inside = np.flatnonzero((number[surface.triangles] >= 0).all(1))
        point.append(surface.points[vertices])
        triangle.append(number[surface.triangles[inside]])
        cell.append(np.full(len(inside), k))
        face.append(inside)
        base += len(vertices)
        for slot in range(4 * k, 4 * k + 4):
            halfarc = complex.side_halfarc[slot]
            path = paths[halfarc // 2][:: -1 if halfarc % 2 else 1]
            step = np.linalg.norm(np.diff(surface.points[path], axis=0), axis=1)
            distance = np.concatenate([[0.0], np.cumsum(step)])
            wall += [(number[v], slot, d) for v, d in zip(path[:-1], distance)]
    wall_point, wall_slot, wall_distance = zip(*wall)
    return CellMesh(
        np.concatenate(point), np.concatenate(triangle), np.concatenate(cell), np.concatenate(face),
        np.array(wall_point), np.array(wall_slot), np.array(wall_distance),
    )


def strip_layout(complex, widths, height):
    """(QuadLayout, length) of a strip with widths[k] quads across cell k; a width may be zero."""
    cells, total = len(widths), sum(widths)
    at = np.concatenate([[0], np.cumsum(widths)])
    grid = np.arange((total + 1) * (height + 1)).reshape(height + 1, total + 1)
    arcs = [grid[0, a : b + 1] for a, b in itertools.pairwise(at)]
    arcs += [grid[-1, a : b + 1][::-1] for a, b in itertools.pairwise(at)]
    arcs += [grid[::-1, 0], grid[:, -1]] + [grid[:, a] for a in at[1:-1]]
    length = np.array([len(a) - 1 for a in arcs])
    blocks = [grid[:, a : b + 1] for a, b in itertools.pairwise(at)]
    fixed = np.zeros(grid.size, bool)
    fixed[[grid[0, 0], grid[0, -1], grid[-1, 0], grid[-1, -1]]] = True
    loop = np.full(grid.shape, -1)
    loop[[0, -1]] = 0
    loop[:, [0, -1]] = 0
    layout = QuadLayout(
        grid_quads(total, height), np.repeat(np.arange(cells), widths).repeat(height), grid.size,
        np.concatenate([grid[0, at], grid[-1, at]]),
        np.concatenate([[0], np.cumsum([len(a) for a in arcs])]), np.concatenate(arcs),
        np.array([[w, height] for w in widths]),
        np.concatenate([[0], np.cumsum([b.size for b in blocks])]),
        np.concatenate([b.ravel() for b in blocks]), fixed, loop.ravel(),
    )
    return layout, length
