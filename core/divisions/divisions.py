"""Dividing the blocks of a decomposition anew: locked counts, other sizes, grading to walls."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import (
    Chords,
    choose_counts,
    divisions,
    find_chords,
    locked_counts,
    mean_lengths,
)
from ..decomposition import Decomposition
from ..errors import LayoutError, SettingsError
from ..quads.quad_mesh import QuadMesh
from ..quads.quality import scaled_jacobian
from ..quads.smoothing import smooth
from ..quads.worst_quads import mend_worst_quads
from ..sentences import missed_count
from ..surface.boundary import build_loops
from ..surface.projection import surface_normal
from .edge_spacing import edge_indices, kinks_inside
from .regridding import Crease, Division, Regridded, edge_arcs, edge_chain, edge_directions, regrid
from .wall_bends import edge_bends
from .wall_spacing import Grading, edge_loops, measured_heights, space_edges, turned_grid

# New grids of more quads than this are refused: a lock may have a nought too many.
MOST_QUADS = 5_000_000
# Below this scaled Jacobian new divisions without grading are smoothed.
_WORST_SHAPE = 0.2
# Up to this one single quads of graded grids are mended.
_MENDED_SHAPE = 0.3
# Where a larger share of lines misses its first height, a finer and smoothed shape is graded.
_MOST_MISSED = 0.05
# Chords of fewer divisions are made four times as fine for a shape that can be graded, others twice.
_FINE_ENOUGH = 8
# Graded grids made one after the other, each with the wall distances of the one before, until all
# first heights are met.
_MOST_PASSES = 5


def redivide(
    decomposition: Decomposition,
    locks=(),
    grading: Grading | None = None,
    edge_length: float | None = None,
    quad_count: int | None = None,
) -> Decomposition:
    """The decomposition with the same blocks and other divisions.

    locks        pairs (block edge, divisions) or a dict; all edges of the same chord follow
    grading      Grading or None; its cells come on top of the wanted number of quads
    edge_length  wanted quad edge, object-space lengths; None keeps the divisions there are
    quad_count   wanted number of quads: counts of free chords are scaled to come within a tenth
                 of it; None takes that of the settings where these ask for a number

    Block, block edge and corner numbers stay. Raises SettingsError for locks that contradict each
    other, the grading or the kinks of the boundary and for more than MOST_QUADS, LayoutError where quads would fold.
    """
    blocks, placement, surface = decomposition.blocks, decomposition.placement, decomposition.whole
    if blocks is None:
        raise SettingsError("There are no blocks to divide; run all stages first.")
    chords = find_chords(blocks)
    arcs = edge_arcs(surface, placement, blocks)
    length = np.array([arc[-1] for arc in arcs])
    locked = locked_counts(chords, locks)
    least = _least_counts(chords, locked, kinks_inside(placement.fixed, blocks) + 1)
    wish, wanted = _wishes(decomposition, chords, length, edge_length, quad_count)
    count = choose_counts(blocks, chords, wish, locked, least, wanted)
    _demand_moderate(blocks, chords, count)
    regular = count
    if grading is not None and locked.any():
        free = choose_counts(blocks, chords, wish, np.zeros_like(locked), least, wanted)
        regular = np.where(locked, np.minimum(free, locked), count)
    wanted = _Wanted(chords, count, regular, locked, grading, _crease(decomposition))
    fresh = _divide(decomposition, wanted)
    quads = _quad_mesh(surface, fresh, _on_crease(blocks, decomposition.quads.crease))
    notes = []
    if fresh.missed:
        notes.append(
            f"On {100 * fresh.missed:.1f} % of the grid lines from the wall the first height is off by"
            " more than 5 %: blocks there are too narrow or lean too much; ask for more quads."
        )
    return replace(
        decomposition, quads=quads, blocks=fresh.blocks, placement=fresh.placement,
        warnings=_still_true(decomposition) + notes,
    )


def _still_true(decomposition: Decomposition) -> list:
    """Its sentences but the one about its number of quads."""
    outdated = missed_count(len(decomposition.quads.quads))
    return [note for note in decomposition.warnings if not note.startswith(outdated)]


@dataclass(frozen=True)
class _Wanted:
    """Divisions (chords,) before grading, those that give the regular spacing (without locks), locked
    ones, 0 where free; grading, creases."""

    chords: Chords
    count: np.ndarray
    regular: np.ndarray
    locked: np.ndarray
    grading: Grading | None
    crease: Crease | None


def _divide(decomposition, wanted: _Wanted) -> Regridded:
    """Divide the blocks; bad quads are smoothed, or a finer and smoothed grid is graded."""
    surface = decomposition.whole
    given = Regridded(
        decomposition.placement, decomposition.quads.quads, decomposition.blocks
    )
    fresh = _regrid(surface, given, wanted)
    worst = _shape(surface, fresh).min()
    if wanted.grading is None:
        return fresh if worst > _WORST_SHAPE else _smoothed(surface, fresh, wanted.crease)
    if worst > 0 and fresh.missed <= _MOST_MISSED:
        return fresh
    count = np.zeros_like(wanted.count)
    count[wanted.chords.edge_chord] = divisions(given.blocks)
    count = np.maximum(2 * count, np.minimum(4 * count, _FINE_ENOUGH))
    finer = _regrid(surface, given, replace(wanted, count=count, grading=None))
    finer = _smoothed(surface, finer, wanted.crease)
    better = _regrid(surface, finer, wanted)
    return max(fresh, better, key=lambda grid: _rank(surface, grid))


def _rank(surface, grid: Regridded):
    """Of two graded grids: one without folds, then nearer to the first height, then better shaped."""
    worst = _shape(surface, grid).min()
    return worst > 0, -grid.missed, worst


def _smoothed(surface, grid: Regridded, crease: Crease | None) -> Regridded:
    """The grid smoothed; vertices on feature edges stay."""
    held = replace(grid.placement, fixed=_held(grid, crease))
    placement = smooth(surface, held, grid.quads)
    return replace(grid, placement=replace(placement, fixed=grid.placement.fixed))


def _regrid(surface, given: Regridded, wanted: _Wanted) -> Regridded:
    """Divide the blocks of a quad mesh with the same chords."""
    arcs = edge_arcs(surface, given.placement, given.blocks)
    if wanted.grading is None:
        free, no = [None] * len(arcs), np.zeros(len(arcs), bool)
        division = _division(given, wanted, arcs, wanted.count, free, no, no, None)
        division = replace(division, crease=wanted.crease)
        return regrid(surface, given.placement, given.blocks, arcs, division)
    loops, measured, tried = build_loops(surface), None, []
    bends = edge_bends(loops, given.placement, given.blocks, arcs, edge_directions(given.blocks))
    count = np.zeros_like(wanted.count)
    for _ in range(_MOST_PASSES):
        spacing = space_edges(
            given.blocks, wanted.chords, given.placement.point,
            edge_loops(given.blocks, given.placement.loop), arcs,
            wanted.regular, wanted.locked, wanted.grading, measured, count,
        )
        division = _division(
            given, wanted, arcs, spacing.count, spacing.fraction, spacing.leads, ~spacing.faded, bends
        )
        division = replace(
            division, wall_side=spacing.wall_side, grading=wanted.grading, measured=measured,
            crease=wanted.crease,
        )
        fresh = regrid(surface, given.placement, given.blocks, arcs, division)
        measured, missed = measured_heights(
            loops, fresh.placement, fresh.blocks, division.asked, wanted.grading, measured
        )
        tried.append(replace(fresh, missed=missed))
        settled = len(tried) > 1 and missed >= tried[-2].missed and (count == spacing.count).all()
        if missed == 0 or settled:
            break
        count = spacing.count
    nearest = min(tried, key=lambda grid: grid.missed)
    mended = _mended(surface, nearest, wanted.crease, spacing)
    if _shape(surface, mended).min() > 0:
        return mended
    best = max(tried, key=lambda grid: _rank(surface, grid))
    return _mended(surface, best, wanted.crease, spacing)


def _mended(surface, grid: Regridded, crease: Crease | None, spacing) -> Regridded:
    """The graded grid, its worst quads mended; first cells and feature edges stay."""
    held = _held(grid, crease)
    for block, side in np.argwhere(spacing.wall_side):
        held[turned_grid(grid.blocks, block, side)[:2]] = True
    placement = mend_worst_quads(
        surface, replace(grid.placement, fixed=held), grid.quads, along_edges=True,
        good_enough=_MENDED_SHAPE,
    )
    return replace(grid, placement=replace(placement, fixed=grid.placement.fixed))


def _held(grid: Regridded, crease: Crease | None) -> np.ndarray:
    """(P,) bool, fixed vertices and those on feature edges, as they would leave these."""
    held = grid.placement.fixed.copy()
    for edge in np.flatnonzero(crease.edge) if crease is not None else ():
        held[edge_chain(grid.blocks, edge)] = True
    return held


def _division(given, wanted, arcs, chord_count, prescribed, leads, by_arc, bends) -> Division:
    count = chord_count[wanted.chords.edge_chord]
    index = edge_indices(
        given.blocks, wanted.chords, given.placement.fixed, arcs, count, prescribed, leads, by_arc, bends
    )
    return Division(count, index)


def _least_counts(chords, locked, least):
    """(chords,) int64, fewest divisions for the kinks on the edges."""
    limit = locked[chords.edge_chord]
    short = np.flatnonzero((limit > 0) & (limit < least))
    if len(short):
        edge = short[0]
        raise SettingsError(
            f"Block edge {edge} is locked to {limit[edge]} divisions, but {least[edge] - 1} kinks of"
            f" the boundary lie on it; lock it to {least[edge]} or more."
        )
    result = np.ones(chords.count, np.int64)
    np.maximum.at(result, chords.edge_chord, least)
    return result


def _demand_moderate(blocks, chords, count):
    total = count[chords.edge_chord[blocks.block_edge[:, :2]]].astype(float).prod(1).sum()
    if total > MOST_QUADS:
        raise SettingsError(
            f"These divisions make {total:,.0f} quads, more than {MOST_QUADS:,}; ask for fewer."
        )


def _wishes(decomposition, chords, length, edge_length, quad_count):
    """Wanted divisions of each chord, and the wanted number of quads or None."""
    blocks, settings = decomposition.blocks, decomposition.settings
    if edge_length is not None:
        if not edge_length > 0:
            raise SettingsError(f"The edge length {edge_length} must be a positive number.")
        area = decomposition.whole.face_area.sum()
        return mean_lengths(blocks, chords, length) / edge_length, area / edge_length**2
    present = np.zeros(chords.count)
    present[chords.edge_chord] = divisions(blocks)
    if quad_count is None and settings.edge_length is None:
        quad_count = settings.quad_count
    return present, quad_count


def _shape(surface, fresh):
    """(Q,) float64, scaled Jacobian against the normals of the surface: below 0 where folded."""
    placement = fresh.placement
    normal = surface_normal(surface, placement.face, placement.point)
    return scaled_jacobian(placement.point, fresh.quads, normal)


def _crease(decomposition) -> Crease | None:
    """The block edges along feature edges and these themselves, None without any."""
    charts, mesh_edges = decomposition.charts, decomposition.quads.crease
    if charts is None or not len(mesh_edges):
        return None
    surface, halfedge = decomposition.whole, np.flatnonzero(charts.across >= 0)
    return Crease(
        _on_crease(decomposition.blocks, mesh_edges), surface.points[surface.tail[halfedge]],
        surface.points[surface.head[halfedge]], halfedge // 3,
    )


def _on_crease(blocks: Blocks, crease) -> np.ndarray:
    """(E,) bool, block edges that run along feature edges; crease (n, 2) int, mesh edges there."""
    first = blocks.edge_vertex[blocks.edge_offset[:-1]]
    second = blocks.edge_vertex[blocks.edge_offset[:-1] + 1]
    ends = np.sort(np.stack([first, second], axis=1), axis=1)
    span = np.array([len(blocks.grid_vertex) + 1, 1])
    return np.isin(ends @ span, np.sort(crease, axis=1) @ span)


def _quad_mesh(surface, fresh, on_crease) -> QuadMesh:
    shape = _shape(surface, fresh)
    if shape.min() <= 0:
        block = fresh.blocks.quad_block[shape.argmin()]
        raise LayoutError(
            f"With these divisions {np.count_nonzero(shape <= 0)} quads fold over, the worst in"
            f" block {block}; give it more divisions or a milder grading."
        )
    point = fresh.placement.point
    on_boundary = np.zeros(len(point), bool)
    blocks = fresh.blocks
    on_edge = np.repeat(blocks.edge_on_boundary, np.diff(blocks.edge_offset))
    on_boundary[blocks.edge_vertex[on_edge]] = True
    valence = np.bincount(fresh.quads.ravel(), minlength=len(point))
    chain = [edge_chain(blocks, edge) for edge in np.flatnonzero(on_crease)]
    steps = [np.stack([vertex[:-1], vertex[1:]], axis=1) for vertex in chain]
    crease = np.concatenate([np.zeros((0, 2), np.int64), *steps])
    return QuadMesh(point, fresh.quads, on_boundary, valence, shape, crease)
