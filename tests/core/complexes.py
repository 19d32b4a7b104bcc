"""Cell complexes written down by hand or cut from rectangles, without a surface below them."""

import numpy as np

from core.cells.cells import CellComplex, NodeKind
from core.quads.lengths import SHORTEST_WISH, side_lengths


def build_complex(ends, cells, valence, kind, position=None):
    """A complex from names.

    ends      dict arc name -> (node, node), nodes numbered from 0
    cells     list of cells, each four lists of arc names, "-name" when walked backwards
    valence   (N,) quads at each node; kind (N,) NodeKind
    """
    number = {name: k for k, name in enumerate(ends)}
    sides = [
        [2 * number[name.lstrip("-")] + name.startswith("-") for name in side]
        for cell in cells
        for side in cell
    ]
    halfarc = np.array([h for side in sides for h in side], np.int64)
    arc_node = np.array(list(ends.values()), np.int64)
    used = np.bincount(halfarc // 2, minlength=len(arc_node))
    loop = _loops(arc_node, used == 1)
    # Arcs of a loop keep the surface on their left.
    backwards = np.zeros(len(arc_node), bool)
    backwards[halfarc[halfarc % 2 == 1] // 2] = True
    turned = backwards & (used == 1)
    arc_node[turned] = arc_node[turned][:, ::-1]
    halfarc = halfarc ^ turned[halfarc // 2]
    on_boundary = np.zeros(len(valence), bool)
    on_boundary[arc_node[loop >= 0]] = True
    position = np.zeros((len(valence), 3)) if position is None else np.asarray(position, float)
    return CellComplex(
        position, np.asarray(kind, np.int64), np.asarray(valence, np.int64), on_boundary,
        np.zeros(len(valence), np.int64), arc_node, loop, np.zeros(len(arc_node)),
        2 * np.arange(len(arc_node) + 1), position[arc_node].reshape(-1, 3),
        np.zeros(2 * len(arc_node), np.int64),
        np.concatenate([[0], np.cumsum([len(s) for s in sides])]), halfarc,
    )


def _loops(arc_node, on_boundary):
    """Boundary loop of each arc, -1 inside."""
    loop = np.full(len(arc_node), -1, np.int64)
    rest, count = set(np.flatnonzero(on_boundary).tolist()), 0
    while rest:
        nodes, grown = set(arc_node[min(rest)].tolist()), True
        while grown:
            inside = {a for a in rest if nodes & set(arc_node[a].tolist())}
            grown = bool(inside)
            for a in inside:
                nodes |= set(arc_node[a].tolist())
                loop[a] = count
            rest -= inside
        count += 1
    return loop


def from_rectangles(rectangles, period=None):
    """Cells that are rectangles (x0, y0, x1, y1) with integer corners, T-junctions allowed.

    period  x is taken modulo this: a ring
    """
    wrap = (lambda x: x % period) if period else (lambda x: x)
    corners = {(wrap(x), y) for a, b, c, d in rectangles for x in (a, c) for y in (b, d)}
    node = {p: k for k, p in enumerate(sorted(corners))}
    ends, cells = {}, []
    for a, b, c, d in rectangles:
        path = [[(x, b) for x in range(a, c + 1)], [(c, y) for y in range(b, d + 1)]]
        path += [[(x, d) for x in range(c, a - 1, -1)], [(a, y) for y in range(d, b - 1, -1)]]
        cells.append([_side(side, wrap, node, ends) for side in path])
    quarters = _quarters(rectangles, node, wrap)
    valence = np.array([quarters[p] for p in sorted(corners)])
    arm = np.bincount(np.array(list(ends.values())).ravel(), minlength=len(node))
    inner = np.where(arm == 3, NodeKind.JUNCTION, NodeKind.CROSSING)
    kind = np.where(valence == 4, inner, np.where(valence == 2, NodeKind.WALL, NodeKind.CORNER))
    position = [(*p, 0.0) for p in sorted(corners)]
    return build_complex(ends, cells, valence, kind, position)


def _side(path, wrap, node, ends):
    """Arc names along a straight path of lattice points, cut at every node."""
    names, begin = [], 0
    for k in range(1, len(path)):
        if (wrap(path[k][0]), path[k][1]) not in node:
            continue
        low, high = sorted([path[begin], path[k]])
        name = f"{wrap(low[0])},{low[1]},{high[0] - low[0]},{high[1] - low[1]}"
        ends.setdefault(name, tuple(node[wrap(p[0]), p[1]] for p in (low, high)))
        names.append(name if path[begin] == low else "-" + name)
        begin = k
    return names


def _quarters(rectangles, node, wrap):
    count = dict.fromkeys(node, 0)
    for a, b, c, d in rectangles:
        for x in range(a, c + 1):
            for y in range(b, d + 1):
                if (wrap(x), y) in count:
                    count[wrap(x), y] += (2 if a < x < c else 1) * (2 if b < y < d else 1)
    return count


def random_rectangles(generator, cells, size=64):
    """A square split at random, again and again, by whole lines: many T-junctions."""
    rectangles = [(0, 0, size, size)]
    while len(rectangles) < cells:
        size = [(c - a) * (d - b) for a, b, c, d in rectangles]
        a, b, c, d = rectangles.pop(int(np.argmax(size)))
        if c - a >= d - b:
            cut = int(generator.integers(a + (c - a) // 4 + 1, c - (c - a) // 4))
            rectangles += [(a, b, cut, d), (cut, b, c, d)]
        else:
            cut = int(generator.integers(b + (d - b) // 4 + 1, d - (d - b) // 4))
            rectangles += [(a, b, c, cut), (a, cut, c, d)]
    return rectangles


def lshape():
    """Three square cells round a reflex corner, lines of the corner drawn."""
    return from_rectangles([(0, 0, 4, 4), (4, 0, 8, 4), (0, 4, 4, 8)])


def disc():
    """Five cells: a square in the middle, its corners singular of valence 3, and four round it."""
    ends = {f"in{k}": (k, (k + 1) % 4) for k in range(4)}
    ends |= {f"out{k}": (4 + k, 4 + (k + 1) % 4) for k in range(4)}
    ends |= {f"spoke{k}": (k, 4 + k) for k in range(4)}
    cells = [[[f"in{k}"] for k in range(4)]]
    for k in range(4):
        n = (k + 1) % 4
        cells.append([[f"out{k}"], [f"-spoke{n}"], [f"-in{k}"], [f"spoke{k}"]])
    turn = np.exp(2j * np.pi * np.arange(4) / 4)
    xy = np.concatenate([turn, 3 * turn])
    kind = [NodeKind.SINGULARITY] * 4 + [NodeKind.WALL] * 4
    return build_complex(ends, cells, [3] * 4 + [2] * 4, kind, np.c_[xy.real, xy.imag, 0 * xy.real])


def forced_zero():
    """A ring of one cell that meets itself with an offset y: its walls are {x, y} and {x}.

    Nodes 1 and 2 are plain, so that they may become one.
    """
    ends = {"x": (0, 1), "y": (1, 2), "bottom": (0, 0), "top": (2, 1)}
    cells = [[["bottom"], ["x", "y"], ["top"], ["-x"]]]
    return build_complex(ends, cells, [2, 2, 2], [NodeKind.WALL] * 3)


def ring(cells):
    """An annulus of cells; with one cell it touches itself along its only cut."""
    return from_rectangles([(4 * k, 0, 4 * k + 4, 3) for k in range(cells)], period=4 * cells)


def torus(columns, rows):
    """A closed torus of square cells."""
    def name(kind, i, j):
        return f"{kind}{i % columns}.{j % rows}"

    ends, cells = {}, []
    for i in range(columns):
        for j in range(rows):
            here = i + columns * j
            ends[name("h", i, j)] = (here, (i + 1) % columns + columns * j)
            ends[name("v", i, j)] = (here, i + columns * ((j + 1) % rows))
            cells.append([
                [name("h", i, j)], [name("v", i + 1, j)],
                ["-" + name("h", i, j + 1)], ["-" + name("v", i, j)],
            ])
    count = columns * rows
    return build_complex(ends, cells, [4] * count, [NodeKind.REGULAR] * count)


def random_gluing(generator, cells):
    """Cells whose sides of one to three slots are glued at random: balances and nothing else."""
    sizes = generator.integers(1, 4, 4 * cells)
    slots = generator.permutation(int(sizes.sum()))
    pairs = int(len(slots) * 0.4)
    arc = np.empty(len(slots), np.int64)
    arc[slots[:pairs]] = arc[slots[pairs : 2 * pairs]] = np.arange(pairs)
    arc[slots[2 * pairs :]] = np.arange(pairs, len(slots) - pairs)
    name, seen, sides = [f"a{a}" for a in arc], set(), []
    for begin, size in zip(np.cumsum(sizes) - sizes, sizes):
        side = []
        for label in name[begin : begin + size]:
            side.append("-" + label if label in seen else label)
            seen.add(label)
        sides.append(side)
    count = len(slots) - pairs
    ends = {f"a{k}": (2 * k, 2 * k + 1) for k in range(count)}
    kind = np.full(2 * count, NodeKind.JUNCTION)
    cells = [sides[4 * k : 4 * k + 4] for k in range(cells)]
    return build_complex(ends, cells, [4] * 2 * count, kind)


def balance_matrix(complex):
    """(2 C, A) float64: the two balances of each cell."""
    side, arc = complex.slot_side, complex.side_halfarc // 2
    matrix = np.zeros((2 * complex.cell_count, complex.arc_count))
    np.add.at(matrix, (2 * (side // 4) + side % 2, arc), np.where(side % 4 < 2, 1.0, -1.0))
    return matrix


def balanced(complex, length):
    sides = side_lengths(complex, length)
    return bool((sides[:, :2] == sides[:, 2:]).all())


def cost(target, length):
    return float(((length - target) ** 2 / np.maximum(target, SHORTEST_WISH)).sum())
