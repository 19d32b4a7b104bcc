"""Chords of a layout of cells: the rows of quads that run side to side through it.

Every arc of the line graph consists of *units*, and the units that face each other across the
cells form a *chord*. One integer for each chord, its division, keeps all cells balanced: an arc is
as long as the divisions of its units together. Division zero takes a whole row of quads out.
(method sections 8 and 9)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..blocks.blocks import Blocks
from ..cells.cells import CellComplex
from ..quads.quad_connectivity import connect_quads
from ..quads.quads import QuadLayout
from ..surface.projection import expand_ranges
from ..surface.surface import connected_components


@dataclass(frozen=True)
class LayoutChords:
    """Chords of a balanced layout. Build them with `find_layout_chords`.

    count        number of chords
    unit_arc     (U,) int64, arc of each unit; units in the order along their arcs
    unit_chord   (U,) int64
    axis_offset  (2 C + 1,) int64; cell c has along side 0 (k = 0) or along side 1 (k = 1) the units
    axis_chord   axis_chord[axis_offset[2 * c + k]:axis_offset[2 * c + k + 1]], chords of them
    """

    count: int
    unit_arc: np.ndarray
    unit_chord: np.ndarray
    axis_offset: np.ndarray
    axis_chord: np.ndarray

    def lengths(self, division, arc_count: int) -> np.ndarray:
        """(A,) lengths of all arcs when the chords are divided as division (count,) says.

        int64 for integer divisions, float64 for real ones (widths, say).
        """
        total = np.bincount(self.unit_arc, division[self.unit_chord], arc_count)
        return total.astype(np.asarray(division).dtype)

    def quad_chords(self, division) -> np.ndarray:
        """(Q, 2) int64: chord whose width edges 0 and 2, and edges 1 and 3, of each quad measure.

        Quads in the order of `quads.build_quads` for the lengths of this division.
        """
        chord = np.repeat(self.axis_chord, division[self.axis_chord])
        size = np.concatenate([[0], np.cumsum(division[self.axis_chord])])
        offset = size[self.axis_offset]
        m, n = np.diff(offset).reshape(-1, 2).T
        cell, place = expand_ranges(np.zeros_like(m), m * n)
        width = np.maximum(m, 1)[cell]
        column, row = place % width, place // width
        return np.stack(
            [chord[offset[2 * cell] + column], chord[offset[2 * cell + 1] + row]], axis=1
        )


def find_layout_chords(complex: CellComplex, length) -> LayoutChords:
    """The chords of a layout with one unit for each quad along an arc.

    length  (A,) int64, balanced
    """
    length = np.asarray(length, np.int64)
    first = np.cumsum(length) - length
    arc, backwards = complex.side_halfarc // 2, complex.side_halfarc % 2
    slot, step = expand_ranges(np.zeros_like(arc), length[arc])
    last = first[arc[slot]] + length[arc[slot]] - 1
    unit = np.where(backwards[slot], last - step, first[arc[slot]] + step)
    size = np.bincount(complex.slot_side[slot], minlength=4 * complex.cell_count)
    offset = np.concatenate([[0], np.cumsum(size)])
    along = size.reshape(-1, 4)[:, :2].ravel()
    axis, place = expand_ranges(np.zeros_like(along), along)
    side = 4 * (axis // 2) + axis % 2
    near, far = unit[offset[side] + place], unit[offset[side + 3] - 1 - place]
    chord = connected_components(int(length.sum()), near, far)
    return LayoutChords(
        int(chord.max(initial=-1)) + 1,
        np.repeat(np.arange(complex.arc_count), length),
        chord,
        np.concatenate([[0], np.cumsum(along)]),
        chord[near],
    )


def rows_of_blocks(layout: QuadLayout, quad_chord, count: int, blocks: Blocks) -> np.ndarray:
    """(count,) int64: chords with equal number run side by side through the same row of blocks.

    quad_chord  (Q, 2) int64, as of `LayoutChords.quad_chords`
    count       number of chords
    blocks      the blocks of the layout's quads
    """
    mesh = connect_quads(layout.quad, layout.vertex_count)
    edge_chord = np.empty(mesh.edge_count, np.int64)
    edge_chord[mesh.edge] = quad_chord[:, [0, 1, 0, 1]].ravel()
    key = np.sort(mesh.edge_vertex, axis=1) @ np.array([layout.vertex_count, 1])
    order = np.argsort(key)
    is_step = np.ones(len(blocks.edge_vertex), bool)
    is_step[blocks.edge_offset[1:] - 1] = False
    step = np.flatnonzero(is_step)
    ends = np.stack([blocks.edge_vertex[step], blocks.edge_vertex[step + 1]], axis=1)
    wanted = np.sort(ends, axis=1) @ np.array([layout.vertex_count, 1])
    chord = edge_chord[order[np.searchsorted(key[order], wanted)]]
    chain = np.searchsorted(blocks.edge_offset, step, side="right")
    same = np.flatnonzero(np.diff(chain) == 0)
    return connected_components(count, chord[same], chord[same + 1])
