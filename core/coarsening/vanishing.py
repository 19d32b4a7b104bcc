"""Which arcs of length zero must not be: they join what must stay apart. (method section 8)

Arcs of length zero join their ends, and cells without width join the vertices on both sides. Taken
one after the other, the shortest first, as Kruskal's algorithm does, the joints make groups of
vertices. A joint that would put two things into one group that must stay apart is not made: an arc
is to blame for it. Everything that is not to blame may vanish together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells.cells import CellComplex, NodeKind
from ..quads.quads import RawVertices, joined_vertices, raw_vertices

# Nodes that must stay apart from each other.
KEPT_APART = (NodeKind.SINGULARITY, NodeKind.CORNER, NodeKind.KINK)


@dataclass
class _Groups:
    """Groups of vertices, and what each of them holds.

    parent  list, union-find
    kept    list of bool, a node that must stay apart from others of its kind
    loop    list of int, the boundary loop that the group touches, -1 for none
    inner   list of bool, a singularity that must not lie on the boundary
    """

    parent: list
    kept: list
    loop: list
    inner: list

    def find(self, vertex: int) -> int:
        parent = self.parent
        while parent[vertex] != vertex:
            parent[vertex] = parent[parent[vertex]]
            vertex = parent[vertex]
        return vertex

    def may_join(self, a: int, b: int) -> bool:
        if self.kept[a] and self.kept[b]:
            return False
        if self.loop[a] >= 0 and self.loop[b] >= 0 and self.loop[a] != self.loop[b]:
            return False
        return not (self.inner[a] and self.loop[b] >= 0 or self.inner[b] and self.loop[a] >= 0)

    def join(self, a: int, b: int):
        self.parent[b] = a
        self.kept[a] |= self.kept[b]
        self.inner[a] |= self.inner[b]
        self.loop[a] = max(self.loop[a], self.loop[b])


def arcs_to_blame(complex: CellComplex, length, free, on_chart: bool = False) -> np.ndarray:
    """(n,) int64, ascending: arcs of length zero that would join what must stay apart.

    length    (A,) int64, balanced
    free      (A,) bool, arcs that may be blamed; the others are joined first, whatever they join
    on_chart  the complex is that of charts: their boundary takes singularities with more than four
              quads, which make the angle there no flatter; on the boundary of a whole surface
              singularities keep off it
    """
    raw = raw_vertices(complex, length)
    first, second, flat = joined_vertices(complex, raw)
    blamed = _culprits(complex, raw, flat, free & (raw.length == 0))
    size = np.where(blamed >= 0, complex.arc_length[blamed], -1.0)
    order = np.argsort(size, kind="stable")
    groups = _single_vertices(complex, raw, on_chart)
    found = set()
    for a, b, arc in zip(*(each[order].tolist() for each in (first, second, blamed))):
        a, b = groups.find(a), groups.find(b)
        if a == b:
            continue
        if arc < 0 or groups.may_join(a, b):
            groups.join(a, b)
        else:
            found.add(arc)
    return np.array(sorted(found), np.int64)


def _single_vertices(complex, raw: RawVertices, on_chart) -> _Groups:
    """Every vertex as a group of its own."""
    kept, inner = np.zeros((2, raw.count), bool)
    kept[: complex.node_count] = np.isin(complex.node_kind, KEPT_APART)
    singular = (complex.node_kind == NodeKind.SINGULARITY) & ~complex.node_on_boundary
    inner[: complex.node_count] = singular & ((complex.node_valence < 4) | (not on_chart))
    along = np.repeat(complex.arc_loop, raw.length + 1)
    loop = np.full(raw.count, -1)
    loop[raw.arc_vertex[along >= 0]] = along[along >= 0]
    return _Groups(list(range(raw.count)), kept.tolist(), loop.tolist(), inner.tolist())


def _culprits(complex, raw: RawVertices, flat, free):
    """(n,) int64, for each joint the arc to blame: the longest one there that may be, else -1."""
    zero = np.flatnonzero(raw.length == 0)
    arc = complex.side_halfarc // 2
    size = np.where(free[arc], complex.arc_length[arc], -1.0)
    # Sides 0 and 2 of a cell share a direction, as do sides 1 and 3.
    direction = complex.slot_side // 4 * 2 + complex.slot_side % 2
    order = np.lexsort((size, direction))
    last = order[np.diff(direction[order], append=-1) != 0]
    longest = np.full(2 * complex.cell_count, -1)
    longest[direction[last]] = np.where(size[last] >= 0, arc[last], -1)
    culprit = longest[flat]
    culprit[: len(zero)] = np.where(free[zero], zero, -1)
    return culprit
