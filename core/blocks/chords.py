"""Chords: block edges that face each other across blocks and so share one number of divisions.

Edges are those of conforming blocks; where these are joined to a T-layout, its sides are divided as
the edges along them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import SettingsError
from ..surface.surface import connected_components
from .blocks import Blocks

# Locks that ask for more than this are slips of the pen.
MOST_DIVISIONS = 100_000
# A count of quads this near to the wanted one needs no chord to be changed by single divisions.
COUNT_TOLERANCE = 0.03
# A count of quads this near to the wanted one is kept as it is.
COUNT_PROMISE = 0.1


@dataclass(frozen=True)
class Chords:
    """Classes of opposite block edges. Build them with `find_chords`.

    edge_chord   (E,) int64, chord of each block edge, numbered by their first edges
    edge_turned  (E,) bool; edges of a chord that are alike here run from the same side of the
                 strip of blocks to the other, as they are stored
    """

    edge_chord: np.ndarray
    edge_turned: np.ndarray

    @property
    def count(self) -> int:
        return int(self.edge_chord.max(initial=-1)) + 1


def forward_sides(blocks: Blocks) -> np.ndarray:
    """(B, 4) bool: does a side, counter-clockwise, run in the direction its edge is stored in?"""
    return blocks.side_forward.reshape(-1, 4)


def divisions(blocks: Blocks) -> np.ndarray:
    """(E,) int64, the number of quads along each block edge."""
    return np.diff(blocks.edge_offset) - 1


def find_chords(blocks: Blocks) -> Chords:
    """The chords of a block layout. (method section 9)"""
    forward = forward_sides(blocks)
    # Node 2 e is the edge as stored, node 2 e + 1 the edge reversed; opposite sides run against
    # each other, so a chord has two components, one for each direction across it.
    first = 2 * blocks.block_edge[:, :2] + ~forward[:, :2]
    second = 2 * blocks.block_edge[:, 2:] + forward[:, 2:]
    first, second = first.ravel(), second.ravel()
    count = 2 * len(blocks.edge_on_boundary)
    part = connected_components(
        count, np.concatenate([first, first ^ 1]), np.concatenate([second, second ^ 1])
    ).reshape(-1, 2)
    chord = np.unique(part.min(1), return_inverse=True)[1].ravel()
    return Chords(chord, part[:, 0] > part[:, 1])


def locked_counts(chords: Chords, locks) -> np.ndarray:
    """(chords,) int64, the divisions that the user's locks ask of each chord, 0 where free.

    locks  pairs (block edge, divisions), or a dict of them

    Raises SettingsError for an edge that is not there, for what is no whole number from 1 to
    MOST_DIVISIONS and for locks that contradict each other.
    """
    result = np.zeros(chords.count, np.int64)
    by_edge = np.full(chords.count, -1)
    for edge, count in locks.items() if hasattr(locks, "items") else locks:
        if not 0 <= edge < len(chords.edge_chord):
            raise SettingsError(
                f"There is no block edge {edge} to lock; edges are numbered from 0 to"
                f" {len(chords.edge_chord) - 1}."
            )
        if not (1 <= count <= MOST_DIVISIONS and count == int(count)):
            raise SettingsError(
                f"Block edge {edge} is locked to {count}; lock it to a whole number from 1 to"
                f" {MOST_DIVISIONS:,}."
            )
        chord = chords.edge_chord[edge]
        if result[chord] not in (0, count):
            other = by_edge[chord]
            same = "is" if other == edge else f"and block edge {other} face each other and are"
            raise SettingsError(
                f"Block edge {edge} {same} locked to both {result[chord]} and {count} divisions;"
                " give one number."
            )
        result[chord], by_edge[chord] = count, edge
    return result


def mean_lengths(blocks: Blocks, chords: Chords, edge_length) -> np.ndarray:
    """(chords,) float64, length of the edges of each chord, averaged over the strip of its blocks.

    edge_length  (E,) float64, object-space lengths
    """
    side = edge_length[blocks.block_edge]
    length = (side[:, :2] + side[:, 2:]) / 2
    width = length[:, ::-1]
    chord = chords.edge_chord[blocks.block_edge[:, :2]]
    area = np.bincount(chord.ravel(), (length * width).ravel(), chords.count)
    return area / np.maximum(np.bincount(chord.ravel(), width.ravel(), chords.count), 1e-300)


def quad_total(blocks: Blocks, chords: Chords, count) -> int:
    """Number of quads with count[c] divisions on chord c."""
    return int(count[chords.edge_chord[blocks.block_edge[:, :2]]].prod(1).sum())


def choose_counts(blocks: Blocks, chords: Chords, wish, locked, least=1, quad_count=None):
    """Divisions of each chord near a wish: (chords,) int64.

    wish        (chords,) float64, wanted divisions
    locked      (chords,) int64, divisions of locked chords, 0 where free
    least       int or (chords,) int64, fewest divisions of free chords
    quad_count  wanted number of quads, or None: the wishes are then scaled, if needed, so that
                the number of quads comes within a tenth of it where locks and layout allow
    """
    def counts(scale):
        rounded = np.floor(np.asarray(wish) * scale + 0.5).astype(np.int64)
        return np.where(locked > 0, locked, np.maximum(rounded, least))

    plain = counts(1.0)
    if quad_count is None:
        return plain
    if abs(quad_total(blocks, chords, plain) / quad_count - 1) <= COUNT_PROMISE:
        return plain
    low, high = 1e-3, 1e3
    for _ in range(50):
        middle = np.sqrt(low * high)
        few = quad_total(blocks, chords, counts(middle)) < quad_count
        low, high = (middle, high) if few else (low, middle)
    nearest = min(counts(low), counts(high), key=lambda c: _miss(blocks, chords, c, quad_count))
    return _tune(blocks, chords, nearest, locked, least, quad_count)


def _miss(blocks, chords, count, quad_count):
    return abs(quad_total(blocks, chords, count) - quad_count)


def _tune(blocks, chords, count, locked, least, quad_count):
    """Single divisions more or fewer on free chords until the number of quads is near enough."""
    pair = chords.edge_chord[blocks.block_edge[:, :2]]
    for _ in range(4 * chords.count):
        missing = quad_count - quad_total(blocks, chords, count)
        if abs(missing) <= COUNT_TOLERANCE * quad_count:
            break
        # Quads that one division more on a chord adds; a chord that crosses itself adds more.
        gain = np.bincount(pair.ravel(), count[pair[:, ::-1]].ravel(), chords.count)
        step = 1 if missing > 0 else -1
        free = (locked == 0) & (count + step >= least) & (gain < 2 * abs(missing))
        if not free.any():
            break
        # The chord whose spacing changes least in proportion.
        chord = np.argmax(np.where(free, count, -1))
        changed = count.copy()
        changed[chord] += step
        if _miss(blocks, chords, changed, quad_count) >= abs(missing):
            break
        count = changed
    return count
