"""Choosing as many elements as possible of which no two contradict each other."""

from __future__ import annotations

import numpy as np


def independent_set(wanted, pairs, preference) -> np.ndarray:
    """(n,) bool, many of the wanted elements, and no pair of them.

    wanted      (n,) bool
    pairs       (k, 2) int64, elements that exclude each other; one paired with itself is never taken
    preference  (n,) float64, lower ones first where the number of pairs does not tell

    Those with the fewest pairs come first; then one is given up wherever two come in for it. (a
    maximal independent set with exchanges of one for two; the best there is in most cases)
    """
    left = wanted.copy()
    left[pairs[pairs[:, 0] == pairs[:, 1], 0]] = False
    both = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0)
    both = both[left[both].all(1)]
    neighbour = np.split(both[:, 1], np.searchsorted(both[:, 0], np.arange(1, len(left))))
    degree = np.bincount(both[:, 0], minlength=len(left))
    rank = np.empty(len(left))
    rank[np.argsort(preference, kind="stable")] = np.linspace(0, 0.5, len(left))
    chosen = left & (degree == 0)
    left &= degree > 0
    while left.any():
        best = np.argmin(np.where(left, degree + rank, np.inf))
        chosen[best], left[best] = True, False
        for lost in neighbour[best][left[neighbour[best]]]:
            left[lost] = False
            degree[neighbour[lost]] -= 1
    while _exchange(chosen, neighbour, both):
        pass
    return chosen


def _exchange(chosen, neighbour, both) -> bool:
    """Give up elements for which two others come in, in place; was there any?"""
    opponents = np.bincount(both[chosen[both[:, 1]], 0], minlength=len(chosen))
    changed = False
    for element in np.flatnonzero(chosen):
        # Only this one keeps them out.
        waiting = neighbour[element][opponents[neighbour[element]] == 1]
        for one in waiting:
            others = waiting[~np.isin(waiting, [one, *neighbour[one]])]
            if len(others):
                for was, now in ((element, False), (one, True), (others[0], True)):
                    chosen[was] = now
                    opponents[neighbour[was]] += 1 if now else -1
                changed = True
                break
    free = np.flatnonzero((opponents == 0) & ~chosen & np.isin(np.arange(len(chosen)), both))
    for element in free:
        if opponents[element] == 0:
            chosen[element] = changed = True
            opponents[neighbour[element]] += 1
    return changed
