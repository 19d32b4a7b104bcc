"""Spacing along lines that leave a wall: a first height that grows by a ratio, then stays regular.

The cells of a line are as long as the smallest of three: first height times ratio^k counted from
its low end, the same from its high end, and a regular length. All lengths are object-space
lengths; a first height of inf leaves an end free.
"""

from __future__ import annotations

import numpy as np

_HALVINGS = 60
# Cells that shrink for want of room stay above this share of the first height.
_SMALLEST = 0.1


def cell_lengths(count: int, low, high, ratio, cap) -> np.ndarray:
    """(n, count) float64, lengths of the cells of n lines.

    low, high, ratio, cap  (n,) float64: first heights at both ends, growth, longest cell
    """
    step = np.arange(count)
    power = np.asarray(ratio)[:, None] ** step
    from_low = np.asarray(low)[:, None] * power
    from_high = np.asarray(high)[:, None] * power[:, ::-1]
    return np.minimum(np.minimum(from_low, from_high), np.asarray(cap)[:, None])


def cells_needed(length, low, high, ratio: float, regular) -> np.ndarray:
    """(n,) int64, fewest cells that reach along lines without exceeding growth or regular length.

    length, low, high, regular  (n,) float64
    """
    length, low, high, regular = np.broadcast_arrays(
        *(np.asarray(a, np.float64) for a in (length, low, high, regular))
    )
    layers = sum(
        np.log(np.maximum(np.where(np.isfinite(end), regular / end, 1.0), 1.0)) / np.log(ratio)
        for end in (low, high)
    )
    most = np.ceil(layers + length / np.minimum(np.minimum(low, high), regular).clip(1e-300))
    most = np.minimum(most, np.ceil(2 * layers + length / regular) + 4).astype(np.int64)
    few, enough = np.zeros(len(length), np.int64), np.maximum(most, 1)
    while (enough - few > 1).any():
        middle = (few + enough) // 2
        reach = _reach(np.maximum(middle, 1), low, high, ratio, regular)
        reached = (reach >= length * (1 - 1e-9)) & (middle > 0)
        few, enough = np.where(reached, few, middle), np.where(reached, middle, enough)
    return enough


def _reach(count, low, high, ratio, cap):
    """Sum of the cell lengths of each line, each with its own number of cells."""
    step = np.arange(count.max(initial=1))
    back = count[:, None] - 1 - step
    with np.errstate(over="ignore", invalid="ignore"):
        from_low = low[:, None] * ratio**step
        from_high = high[:, None] * ratio ** np.maximum(back, 0).astype(np.float64)
    cells = np.minimum(np.minimum(from_low, from_high), cap[:, None])
    return np.where(back >= 0, cells, 0.0).sum(1)


def graded_positions(length, count: int, low, high, ratio: float) -> np.ndarray:
    """(n, count + 1) float64, arc lengths of the nodes on lines of given length and cell number.

    length, low, high  (n,) float64

    First heights are kept where the line has room for them; the cells between grow by at most
    `ratio` to one common length. Where there are too few cells for that, they grow faster. Where
    not all cells have room at the smaller first height, those between shrink, by at most `ratio`
    squared and to a tenth; where even that is too long, all are scaled down.
    """
    length, low, high = (
        np.array(a) for a in np.broadcast_arrays(*(np.asarray(a, float) for a in (length, low, high)))
    )
    growth = np.full(len(length), float(ratio))
    endless = np.full(len(length), np.inf)

    def reach(rate, cap):
        with np.errstate(over="ignore"):
            return cell_lengths(count, low, high, rate, cap).sum(1)

    short = np.isfinite(np.minimum(low, high)) & (reach(growth, endless) < length)
    if short.any():
        least, most = growth.copy(), np.full(len(length), 1e6)
        for _ in range(_HALVINGS):
            middle = np.sqrt(least * most)
            under = reach(middle, endless) < length
            least, most = np.where(under, middle, least), np.where(under, most, middle)
        growth = np.where(short, most, growth)
    smallest, largest = length / count, length.copy()
    for _ in range(_HALVINGS):
        middle = np.sqrt(smallest * largest)
        under = reach(growth, middle) < length
        smallest, largest = np.where(under, middle, smallest), np.where(under, largest, middle)
    cells = cell_lengths(count, low, high, growth, largest)
    full = largest < np.minimum(low, high) * (1 - 1e-9)
    full &= np.isfinite(np.minimum(low, high))
    cells[full] = _shrinking_cells(length[full], count, low[full], high[full], ratio)
    position = np.cumsum(cells, axis=1)
    position *= (length / position[:, -1])[:, None]
    return np.concatenate([np.zeros((len(length), 1)), position], axis=1)


def _shrinking_cells(length, count, low, high, ratio):
    """(n, count) float64, cells over the smaller first height: they shrink away from the ends with
    first heights."""
    step = np.arange(count)
    depth = np.minimum(
        np.where(np.isfinite(low)[:, None], step, count),
        np.where(np.isfinite(high)[:, None], step[::-1], count),
    )
    share = length / np.minimum(low, high)
    least, most = np.full(len(length), ratio**-2.0), np.ones(len(length))
    for _ in range(_HALVINGS):
        rate = np.sqrt(least * most)
        under = np.maximum(rate[:, None] ** depth, _SMALLEST).sum(1) < share
        least, most = np.where(under, rate, least), np.where(under, most, rate)
    return np.maximum(least[:, None] ** depth, _SMALLEST)
