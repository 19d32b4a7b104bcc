"""How often each chord is divided: one integer for each, from how wide it is. (method section 8)"""

from __future__ import annotations

import numpy as np

from ..cells.cells import CellComplex
from ..quads.lengths import count_quads
from .layout_chords import LayoutChords

# A count of quads this near to the wanted one is good enough.
COUNT_TOLERANCE = 0.02
_MOST_TRIALS = 24


def chord_widths(edge_length, edge_chord, division) -> np.ndarray:
    """(count,) float64: how wide each chord is, the geometric mean of the places where it is crossed.

    edge_length  (n,) float64, lengths of mesh edges across chords
    edge_chord   (n,) int64, their chords
    division     (count,) int64, edges from one side of each chord to the other

    Zero for chords without edges.
    """
    total = np.bincount(edge_chord, np.log(np.maximum(edge_length, 1e-300)), len(division))
    count = np.bincount(edge_chord, minlength=len(division))
    return np.where(count, division * np.exp(total / np.maximum(count, 1)), 0.0)


def arc_widths(complex: CellComplex, chords: LayoutChords) -> np.ndarray:
    """(count,) float64, widths of the chords by the arcs that cross them."""
    units = np.bincount(chords.unit_arc, minlength=complex.arc_count)
    edge = (complex.arc_length / np.maximum(units, 1))[chords.unit_arc]
    return chord_widths(edge, chords.unit_chord, np.ones(chords.count, np.int64))


def divide(width, size: float, row, alive) -> np.ndarray:
    """(count,) int64 divisions for quads of the given edge length.

    width  (count,) float64
    row    (count,) int64, chords with equal number are divided together and may become 0 as long
           as one of them does not
    alive  (count,) bool, chords that are not zero for good

    Every row gets its total width over size, rounded, at least 1, and shares it out by width.
    """
    wish = np.where(alive, width, 0.0) / size
    rows = int(row.max(initial=-1)) + 1
    total = np.bincount(row, wish, rows)
    goal = np.maximum(1, np.rint(total)) * (np.bincount(row, alive, rows) > 0)
    return _shared_out(wish, row, goal)


def divide_to_count(complex: CellComplex, chords: LayoutChords, width, quad_count, row, alive):
    """(count,) int64 divisions for a wanted number of quads, as near to it as this layout allows.

    Arguments as of `divide`; quad_count is the wanted number of quads.
    """
    real = count_quads(complex, chords.lengths(width, complex.arc_count))
    size = np.sqrt(max(real, 1e-300) / quad_count)
    low, high, best = 0.0, np.inf, None
    for _ in range(_MOST_TRIALS):
        division = divide(width, size, row, alive)
        count = max(count_quads(complex, chords.lengths(division, complex.arc_count)), 0.5)
        miss = abs(np.log(count / quad_count))
        if best is None or miss < best[0]:
            best = (miss, division, size)
        if miss < COUNT_TOLERANCE:
            break
        if count > quad_count:
            low = size
        else:
            high = size
        size *= np.sqrt(count / quad_count)
        if not low < size < high:
            size = np.sqrt(low * high) if 0 < low and high < np.inf else size
    return _mend_count(complex, chords, width / best[2], quad_count, row, best[1])


def _mend_count(complex, chords, wish, quad_count, row, division):
    """Single rows one division more or less, those first that were rounded the most."""
    def miss(trial):
        count = count_quads(complex, chords.lengths(trial, complex.arc_count))
        return np.log(max(count, 0.5) / quad_count)

    now = miss(division)
    sign = -1 if now > 0 else 1
    order = np.argsort(sign * (division - wish), kind="stable")
    for chord in order[: _MOST_TRIALS if abs(now) > COUNT_TOLERANCE else 0].tolist():
        trial = division.copy()
        trial[chord] += sign
        if division[chord] == 0 or trial[row == row[chord]].sum() < 1:
            continue
        if abs(miss(trial)) < abs(now):
            division, now = trial, miss(trial)
    return division


def thin_out(complex: CellComplex, chords: LayoutChords, division, quad_count, row) -> np.ndarray:
    """(count,) int64: fewer divisions, for at most so many quads, fewer only where there are many.

    row  (count,) int64, chords with equal number are thinned together, see `divide`

    Rows divided once or twice stay as they are, the others keep two divisions or more: small
    features are as well resolved as before.
    """
    total = np.bincount(row, division)
    least, low, high = np.minimum(total, 2), 1.0, float(max(total.max(initial=1), 2))
    result = _shared_out(division, row, least)
    for _ in range(_MOST_TRIALS):
        ratio = np.sqrt(low * high)
        trial = _shared_out(division, row, np.maximum(least, np.rint(total / ratio)))
        if count_quads(complex, chords.lengths(trial, complex.arc_count)) > quad_count:
            low = ratio
        else:
            high, result = ratio, trial
    return result


def _shared_out(wish, row, goal) -> np.ndarray:
    """(count,) int64 with the sum goal (r,) in each row, in proportion to wish (count,).

    What is left over by rounding down goes where most was cut off.
    """
    total = np.bincount(row, wish, len(goal))
    share = wish * (goal / np.maximum(total, 1e-300))[row]
    result = np.floor(share + 1e-9).astype(np.int64)
    missing = (goal - np.bincount(row, result, len(goal))).astype(np.int64)
    order = np.lexsort([-np.where(wish > 0, share - result, -1.0), row])
    first = np.searchsorted(row[order], np.arange(len(goal)))
    rank = np.arange(len(row)) - first[row[order]]
    result[order] += rank < missing[row[order]]
    return result
