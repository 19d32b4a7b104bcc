"""Choosing as many elements as possible of which no two exclude each other."""

from __future__ import annotations

import numpy as np

from .surface import connected_components


def independent_set(wanted, pairs, preference) -> np.ndarray:
    """(n,) bool, as many of the wanted elements as possible, and no pair of them.

    wanted      (n,) bool
    pairs       (k, 2) int64, elements that exclude each other; one paired with itself is never taken
    preference  (n,) float64, lower ones first where the number of pairs does not tell

    Where the elements fall into two families and exclude only those of the other one, as lines of
    two directions do, there can be no more than are chosen (Koenig's theorem). Elsewhere those with
    the fewest pairs come first, and one is given up wherever two come in for it.
    """
    left = wanted.copy()
    left[pairs[pairs[:, 0] == pairs[:, 1], 0]] = False
    both = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0)
    both = both[left[both].all(1)]
    neighbour = np.split(both[:, 1], np.searchsorted(both[:, 0], np.arange(1, len(left))))
    chosen = _fewest_pairs_first(left, neighbour, both, preference)
    while _exchange(chosen, neighbour, both):
        pass
    for group in _groups(len(left), both):
        largest = _of_two_families(group.tolist(), neighbour)
        if len(largest) > chosen[group].sum():
            chosen[group] = False
            chosen[largest] = True
    return chosen


def _fewest_pairs_first(wanted, neighbour, both, preference):
    degree = np.bincount(both[:, 0], minlength=len(wanted))
    rank = np.empty(len(wanted))
    rank[np.argsort(preference, kind="stable")] = np.linspace(0, 0.5, len(wanted))
    chosen, left = wanted & (degree == 0), wanted & (degree > 0)
    while left.any():
        best = np.argmin(np.where(left, degree + rank, np.inf))
        chosen[best], left[best] = True, False
        for lost in neighbour[best][left[neighbour[best]]]:
            left[lost] = False
            degree[neighbour[lost]] -= 1
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


def _groups(count, both) -> list:
    """The elements that have pairs, in connected groups."""
    if not len(both):
        return []
    tied = np.unique(both[:, 0])
    part = connected_components(count, both[:, 0], both[:, 1])
    order = tied[np.argsort(part[tied], kind="stable")]
    return np.split(order, np.flatnonzero(np.diff(part[order])) + 1)


def _of_two_families(group, neighbour) -> list:
    """A largest choice from a connected group; empty where there are not two families."""
    family, queue = {group[0]: 0}, [group[0]]
    for element in queue:
        for other in neighbour[element].tolist():
            if other not in family:
                family[other] = 1 - family[element]
                queue.append(other)
            elif family[other] == family[element]:
                return []
    first = [element for element in group if family[element] == 0]
    partner, mate = {}, {}
    for element in first:
        _augment(element, neighbour, partner, mate)
    # What alternating paths from single elements reach: the first family there, the second elsewhere.
    reached, queue = set(), [element for element in first if element not in mate]
    kept = set(queue)
    for element in queue:
        for other in neighbour[element].tolist():
            if other not in reached:
                reached.add(other)
                queue.append(partner[other])
                kept.add(partner[other])
    second = [element for element in group if family[element] == 1 and element not in reached]
    return [*kept, *second]


def _augment(start, neighbour, partner, mate):
    """Find a partner for an element of the first family, others changing theirs; in place.

    partner  second family -> first; mate  first family -> second
    """
    came_from, queue = {}, [start]
    for element in queue:
        for other in neighbour[element].tolist():
            if other in came_from:
                continue
            came_from[other] = element
            if other in partner:
                queue.append(partner[other])
                continue
            while other is not None:
                element = came_from[other]
                before = mate.get(element)
                partner[other], mate[element] = element, other
                other = before
            return
