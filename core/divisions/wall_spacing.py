"""Grading towards walls: how many cells block edges need, and where their nodes lie.

A block edge leaves a wall where a block has a side on the wall beside it. Its first height is set
there, its cells grow until they meet the regular spacing, in the blocks behind it too if need be.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import Chords, forward_sides
from ..errors import SettingsError
from ..surface.boundary import BoundaryLoops
from .chord_fading import fade_along_chord
from .grading import cells_needed, graded_positions

# The first height is measured across the wall; lines that lean more than this are not followed.
LEAST_SINE = 0.3
# A first node this near to the first height, in proportion, meets it.
FIRST_HEIGHT_TOLERANCE = 0.05
# A cell of this share of the regular one meets it.
MEETS = 0.95
_MOST_ROUNDS = 50
# Where cells have no room the regular length of their chord grows in such steps, at most so often.
_WIDENING, _MOST_WIDENINGS = 2.0, 5
# A line this full of first cells has no room for more.
_FULL = 0.9


@dataclass(frozen=True)
class Grading:
    """Boundary-layer spacing towards walls.

    first_height  object-space length, distance of the first nodes from the wall
    growth        ratio of one cell to the one before it, above 1
    loops         numbers of the boundary loops that are walls, or None for all of them
    """

    first_height: float
    growth: float = 1.2
    loops: tuple | None = None

    def __post_init__(self):
        if not (isfinite(self.first_height) and self.first_height > 0):
            raise SettingsError(f"The first height {self.first_height} must be a positive number.")
        if not 1 < self.growth <= 10:
            raise SettingsError(f"The growth {self.growth} must be above 1 and at most 10.")


@dataclass(frozen=True)
class WallSpacing:
    """The spacing that a grading asks of every block edge.

    count      (chords,) int64, divisions
    fraction   list of E: (n + 1,) float64, arc length of the nodes over the edge's length, from
               its stored start; None where the grading asks nothing
    faded      (E,) bool, edges beside those that leave a wall: their fractions are those of the
               old divisions, not of the arc length
    leads      (E,) bool, edges with fractions
    wall_side  (B, 4) bool, sides that lie on a wall
    """

    count: np.ndarray
    fraction: list
    faded: np.ndarray
    leads: np.ndarray
    wall_side: np.ndarray


def edge_loops(blocks: Blocks, vertex_loop) -> np.ndarray:
    """(E,) int64, boundary loop that each block edge lies on, -1 inside; vertex_loop (P,) int."""
    start = blocks.edge_vertex[blocks.edge_offset[:-1]]
    return np.where(blocks.edge_on_boundary, np.asarray(vertex_loop)[start], -1)


def space_edges(
    blocks: Blocks, chords: Chords, points, edge_loop, edge_arc, count, locked, grading: Grading,
    measured=None, least=0,
) -> WallSpacing:
    """Spacing of all block edges for a grading.

    points       (P, 3) float64, vertices of the quad mesh
    edge_loop    (E,) int64, boundary loop of each edge or -1
    edge_arc     list of E: (m + 1,) float64, arc length at the vertices of each edge
    count        (chords,) int64, divisions without grading and locks; they give the regular spacing
    locked       (chords,) int64, locked divisions, 0 where free
    measured     first cells of lines by `measured_heights` of an earlier try, or None
    least        (chords,) int64 or 0, fewest divisions

    Raises SettingsError for a loop that is not there, a first height above the regular spacing and
    locks that leave too few cells.
    """
    wall_side = _wall_sides(blocks, edge_loop, grading)
    edge_length = np.array([arc[-1] for arc in edge_arc])
    regular, limit = edge_length / count[chords.edge_chord], locked[chords.edge_chord]
    first, shrink, stretch = _first_heights(
        blocks, points, wall_side, edge_length, grading, measured
    )
    even = np.where(limit, edge_length / np.maximum(limit, 1), regular)
    _refuse_too_high(first.min(1), even, limit, grading)
    layout = _Layout(blocks, chords, forward_sides(blocks), _sides_across(blocks), wall_side)
    start = np.where(locked, locked, np.maximum(count, least))
    for _ in range(_MOST_WIDENINGS):
        count, reached = _settle(layout, edge_length, stretch, first, regular, start, locked, grading)
        if measured is None:
            _refuse_locked(chords, locked, count, grading)
        # Once the rule is met, cells of locked lines grow a little faster where they must.
        count = np.where(locked, locked, count)
        tight = _without_room(chords, count, first, edge_length * shrink) & (locked == 0)
        if not tight.any():
            break
        # Fewer cells fit, if the regular ones of the wide blocks of the chord are longer.
        start = np.where(tight, least, start)
        regular = np.where(tight[chords.edge_chord], _WIDENING * regular, regular)
    ends = _faded_ends(blocks, chords, edge_length, reached, regular)
    leads = np.isfinite(ends).any(1)
    faded = leads & ~np.isfinite(reached).any(1)
    # Cells of faded edges are measured by the old divisions at the edge's ends.
    scale = np.array([(len(arc) - 1) * np.diff(arc)[[0, -1]] / arc[-1] for arc in edge_arc])
    ends[faded] /= scale[faded]
    fraction = _fractions(edge_length, count[chords.edge_chord], ends, grading.growth)
    return WallSpacing(count, fraction, faded, leads, wall_side)


@dataclass(frozen=True)
class _Layout:
    """A block layout and its walls; forward, across as from forward_sides and _sides_across."""

    blocks: Blocks
    chords: Chords
    forward: np.ndarray
    across: np.ndarray
    wall_side: np.ndarray


def _settle(layout: _Layout, length, stretch, first, regular, count, locked, grading):
    """Divisions (chords,) that suffice everywhere, and the first cells (E, 2) that come of them.

    count   (chords,) int64, divisions to begin with; more where they do not suffice
    locked  (chords,) int64, locked divisions, 0 where free
    """
    edge_chord = layout.chords.edge_chord
    # Locked cells grow as far as it takes them to fill their line, beyond the regular ones too.
    limit = locked[edge_chord]
    longest = np.where(limit > 0, np.maximum(regular, length * stretch), regular)
    for _ in range(_MOST_ROUNDS):
        reached = _continue_behind(
            layout, length, np.maximum(count, 1)[edge_chord], first, regular, grading.growth
        )
        graded = np.flatnonzero(np.isfinite(reached).any(1))
        needed = np.zeros(len(length), np.int64)
        needed[graded] = cells_needed(
            (length * stretch)[graded], *reached[graded].T, grading.growth, longest[graded]
        )
        before, count = count, count.copy()
        np.maximum.at(count, edge_chord, needed)
        if np.array_equal(before, count):
            break
    return count, reached


def _without_room(chords, count, first, shortest):
    """(chords,) bool, chords with lines from a wall that are too short for all their cells."""
    wall = np.flatnonzero(np.isfinite(first).any(1))
    chord = chords.edge_chord[wall]
    result = np.zeros(len(count), bool)
    result[chord[count[chord] * first[wall].min(1) > _FULL * shortest[wall]]] = True
    return result


def _wall_sides(blocks, edge_loop, grading):
    known = np.unique(edge_loop[edge_loop >= 0])
    if not len(known):
        raise SettingsError("The surface has no boundary to be graded towards; leave it out.")
    if grading.loops is None:
        return edge_loop[blocks.block_edge] >= 0
    for loop in grading.loops:
        if loop not in known:
            raise SettingsError(
                f"There is no boundary loop {loop}; loops are numbered from 0 to {known.max()}."
            )
    return np.isin(edge_loop[blocks.block_edge], np.array(grading.loops))


def _first_heights(blocks, points, wall_side, edge_length, grading, measured):
    """First cell (E, 2) float64 at both ends of each edge, inf where free; shrink and stretch (E,).

    The first height is measured across the wall, so edges that lean get a longer cell. Shrink and
    stretch are the shortest and longest grid line of the blocks on the wall over the edge's length.
    """
    forward = forward_sides(blocks)
    edges = len(edge_length)
    total, number = np.zeros((edges, 2)), np.zeros((edges, 2))
    shrink, stretch = np.ones(edges), np.ones(edges)
    for block, side in np.argwhere(wall_side):
        grid = points[turned_grid(blocks, block, side)]
        line_length = np.linalg.norm(np.diff(grid, axis=0), axis=2).sum(0)
        height = line_heights(grid[0], grid[1] - grid[0], grading)
        if measured is not None:
            height = measured[block, side]
        for turn, line in ((1, -1), (3, 0)):
            edge = blocks.block_edge[block, (side + turn) % 4]
            end = int(forward[block, (side + turn) % 4] != (turn == 1))
            total[edge, end] += height[line]
            number[edge, end] += 1
            shrink[edge] = min(shrink[edge], line_length.min() / edge_length[edge])
            stretch[edge] = max(stretch[edge], line_length.max() / edge_length[edge])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(number > 0, total / number, np.inf), shrink, stretch


def line_heights(row, leaving, grading: Grading) -> np.ndarray:
    """(k,) float64, first cells of lines that leave a wall at points row (k, 3) along leaving (k, 3).

    They are as long as it takes to be the first height away from the wall.
    """
    return grading.first_height / np.maximum(sine(np.gradient(row, axis=0), leaving), LEAST_SINE)


def measured_heights(loops: BoundaryLoops, placement, blocks: Blocks, asked, grading, before=None):
    """First cells to ask for after those of a graded grid were measured.

    asked   (block, side) -> (k,) float64, first cells that were asked of the lines from a side on a
            wall, counter-clockwise along it
    before  what this returned for the grid before, if that was followed

    Returns a dict like asked, and the share of lines whose first node is farther from or nearer to
    the wall than the first height by more than FIRST_HEIGHT_TOLERANCE.
    """
    result, missed, lines = {}, 0, 0
    for (block, side), height in asked.items():
        foot, first = turned_grid(blocks, block, side)[:2]
        point = placement.point[first]
        leaving = point - placement.point[foot]
        loop = placement.loop[foot]
        wall, _ = loops.point(loop, loops.closest(loop, point))
        away = np.maximum(np.linalg.norm(point - wall, axis=1), 1e-300)
        better = height * grading.first_height / away
        # Lines on block edges were asked what had been measured on both sides of them, at first
        # nothing; nodes on the boundary say nothing of the wall.
        ends = [0, -1]
        step = np.linalg.norm(leaving[ends], axis=1)
        step = step if before is None else before[block, side][ends]
        better[ends] = step * grading.first_height / away[ends]
        rule = line_heights(placement.point[foot], leaving, grading)
        on_boundary = placement.loop[first] >= 0
        better = np.where(on_boundary, rule, better)
        error = np.abs(away[~on_boundary] / grading.first_height - 1)
        missed += np.count_nonzero(error > FIRST_HEIGHT_TOLERANCE)
        lines += len(error)
        result[block, side] = np.clip(better, LEAST_SINE * grading.first_height,
                                      grading.first_height / LEAST_SINE)
    return result, missed / max(lines, 1)


def sine(first, second):
    """Sine of the angle between vectors; arrays (..., 3)."""
    area = np.linalg.norm(np.cross(first, second), axis=-1)
    length = np.linalg.norm(first, axis=-1) * np.linalg.norm(second, axis=-1)
    return area / np.maximum(length, 1e-300)


def turned_grid(blocks: Blocks, block, side) -> np.ndarray:
    """(rows, columns) int64, the vertices of a block, turned so that the side is the first row."""
    m, n = blocks.shape[block]
    vertex = blocks.grid_vertex[blocks.grid_offset[block] : blocks.grid_offset[block + 1]]
    return np.rot90(vertex.reshape(n + 1, m + 1), side)


def _refuse_too_high(first, regular, limit, grading):
    """Refuse first cells (E,) above the regular ones, all (E,); limit: locked divisions or 0."""
    if not np.isfinite(first).any():
        raise SettingsError("No block edge leaves the chosen walls; choose other boundary loops.")
    excess = np.where(np.isfinite(first), first / regular, 0.0)
    edge = np.argmax(excess)
    if excess[edge] <= 1:
        return
    if limit[edge]:
        room = max(1, int(limit[edge] / excess[edge]))
        raise SettingsError(
            f"The chord of block edge {edge} is locked to {limit[edge]} divisions, but a first height"
            f" of {grading.first_height:g} leaves room for {room}; lock it to fewer or change the"
            " grading."
        )
    raise SettingsError(
        f"The first height {grading.first_height:g} is above the regular spacing"
        f" {regular[edge]:.3g} of block edge {edge}; give a smaller one or larger quads."
    )


def _sides_across(blocks):
    """(B, 4) int64, 4 * block + side that lies on the other side of an edge, -1 at the boundary."""
    side = np.arange(blocks.block_edge.size)
    order = np.lexsort([side, blocks.block_edge.ravel()])
    edge = blocks.block_edge.ravel()[order]
    across = np.full(len(side), -1)
    pair = np.flatnonzero(edge[1:] == edge[:-1])
    across[order[pair]], across[order[pair + 1]] = order[pair + 1], order[pair]
    return across.reshape(-1, 4)


def _continue_behind(layout: _Layout, length, cells, first, regular, ratio):
    """First cells (E, 2) with those of blocks behind, where cells have not met the regular ones."""
    first = first.copy()
    visited, across = layout.wall_side.copy(), layout.across
    front = np.argwhere(layout.wall_side)
    while len(front):
        ends = _end_cells(length, cells, first, ratio)
        following = []
        for block, side in front:
            place = across[block, (side + 2) % 4]
            if place < 0 or visited.ravel()[place]:
                continue
            behind, there = divmod(int(place), 4)
            if _hand_over(layout, ends, first, regular, ratio, (block, side), (behind, there)):
                visited[behind, there] = True
                following.append((behind, there))
        front = np.array(following, np.int64).reshape(-1, 2)
    return first


def _hand_over(layout, ends, first, regular, ratio, here, behind):
    """Set the first cells of the block behind; False where all have met the regular spacing."""
    blocks, forward, handed = layout.blocks, layout.forward, False
    for turn in (1, 3):
        side, next_side = (here[1] + turn) % 4, (behind[1] + turn) % 4
        edge, next_edge = blocks.block_edge[here[0], side], blocks.block_edge[behind[0], next_side]
        # Side 1 leaves the wall as it is walked counter-clockwise, side 3 runs towards it.
        far = int(forward[here[0], side] == (turn == 1))
        near = int(forward[behind[0], next_side] != (turn == 1))
        cell = ratio * ends[edge, far]
        # A wall at the far end has small cells of its own there.
        grows = np.isfinite(first[edge, 1 - far]) and not np.isfinite(first[edge, far])
        if grows and cell < MEETS * regular[next_edge]:
            first[next_edge, near] = min(first[next_edge, near], cell)
            handed = True
    return handed


def _end_cells(length, cells, first, ratio):
    """(E, 2) float64, first and last cell of every edge with a first height, else nan; at least
    the mean cell."""
    result = np.full((len(length), 2), np.nan)
    graded = np.isfinite(first).any(1)
    for count in np.unique(cells[graded]):
        same = np.flatnonzero(graded & (cells == count))
        position = graded_positions(length[same], int(count), *first[same].T, ratio)
        result[same, 0] = position[:, 1]
        result[same, 1] = position[:, -1] - position[:, -2]
    # Cells that shrink for want of room do not hand on how small they are.
    return np.maximum(result, (length / cells)[:, None])


def _faded_ends(blocks, chords, length, reached, regular):
    """First cells (E, 2): those of walls, and at the same ends of the other edges of their chords
    such that grow to the regular ones with the distance from there."""
    turned = chords.edge_turned[:, None]
    alike = np.where(turned, reached[:, ::-1], reached)
    result = alike.copy()
    for chord in np.unique(chords.edge_chord[np.isfinite(reached).any(1)]):
        edges = np.flatnonzero(chords.edge_chord == chord)
        for end in (0, 1):
            known = np.isfinite(alike[edges, end])
            own = np.log(np.where(known, alike[edges, end], regular[edges]))[:, None]
            if known.any():
                faded = fade_along_chord(blocks, chords, chord, length, own, known)
                result[edges, end] = np.exp(faded[:, 0])
    return np.where(turned, result[:, ::-1], result)


def _refuse_locked(chords, locked, count, grading):
    """Refuse locks below the divisions (chords,) that a grading needs."""
    short = np.flatnonzero((locked > 0) & (count > locked))
    if len(short):
        chord = short[np.argmax(count[short] - locked[short])]
        edge = int(np.flatnonzero(chords.edge_chord == chord)[0])
        raise SettingsError(
            f"The chord of block edge {edge} is locked to {locked[chord]} divisions, but a first"
            f" height of {grading.first_height:g} with growth {grading.growth:g} needs {count[chord]};"
            " lock it to more or change the grading."
        )


def _fractions(length, cells, first, ratio):
    graded = np.isfinite(first).any(1)
    result = [None] * len(length)
    for count in np.unique(cells[graded]):
        same = np.flatnonzero(graded & (cells == count))
        position = graded_positions(length[same], int(count), *first[same].T, ratio)
        for edge, row in zip(same.tolist(), position / length[same, None]):
            result[edge] = row
    return result
