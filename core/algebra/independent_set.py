"""Choosing as many elements as possible of which no two exclude each other."""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from itertools import combinations

import numpy as np

from ..surface.surface import connected_components


def independent_set(wanted, pairs, preference) -> np.ndarray:
    """(n,) bool, as many of the wanted elements as possible, and no pair of them.

    wanted      (n,) bool
    pairs       (k, 2) int64, elements that exclude each other; one paired with itself is never taken
    preference  (n,) float64, lower ones first where the number of pairs does not tell

    Where the elements fall into two families and exclude only those of the other one, as lines of
    two directions do, there can be no more than are chosen (Koenig's theorem). Elsewhere those with
    the fewest pairs come first, and one is given up wherever two come in for it.
    """
    chosen = wanted.copy()
    chosen[pairs[pairs[:, 0] == pairs[:, 1], 0]] = False
    both = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0)
    both = both[chosen[both].all(1)]
    tied, first = np.unique(both[:, 0], return_index=True)
    chosen[tied] = False
    others = np.split(both[:, 1], first[1:])
    neighbour = {element: other.tolist() for element, other in zip(tied.tolist(), others)}
    for group in _groups(len(wanted), both, tied):
        choice = _fewest_pairs_first(group, neighbour, preference)
        while _exchange(choice, group, neighbour):
            pass
        largest = _of_two_families(group, neighbour)
        chosen[largest if len(largest) > len(choice) else list(choice)] = True
    return chosen


def _groups(count, both, tied) -> list:
    """The elements that have pairs, as lists of connected ones."""
    part = connected_components(count, both[:, 0], both[:, 1])
    order = tied[np.argsort(part[tied], kind="stable")]
    groups = np.split(order, np.flatnonzero(np.diff(part[order])) + 1)
    return [group.tolist() for group in groups if len(group)]


def _fewest_pairs_first(group, neighbour, preference) -> set:
    degree = {element: len(neighbour[element]) for element in group}
    waiting = [(degree[element], float(preference[element]), element) for element in group]
    heapify(waiting)
    chosen, gone = set(), set()
    while waiting:
        count, _, best = heappop(waiting)
        if best in gone or count != degree[best]:
            continue
        chosen.add(best)
        lost = [other for other in neighbour[best] if other not in gone]
        gone |= {best, *lost}
        for element in {other for each in lost for other in neighbour[each]} - gone:
            degree[element] = sum(other not in gone for other in neighbour[element])
            heappush(waiting, (degree[element], float(preference[element]), element))
    return chosen


def _exchange(chosen: set, group, neighbour) -> bool:
    """Give up elements for which two others come in, in place; was there any?"""
    opponents = {e: sum(other in chosen for other in neighbour[e]) for e in group}
    before = len(chosen)

    def change(element, step):
        for other in neighbour[element]:
            opponents[other] += step

    for element in sorted(chosen):
        # Only this one keeps them out.
        waiting = [other for other in neighbour[element] if opponents[other] == 1]
        for one, two in combinations(waiting, 2):
            if two not in neighbour[one]:
                chosen.remove(element)
                chosen.update((one, two))
                change(element, -1)
                change(one, 1)
                change(two, 1)
                break
    for element in group:
        if opponents[element] == 0 and element not in chosen:
            chosen.add(element)
            change(element, 1)
    return len(chosen) > before


def _of_two_families(group, neighbour) -> list:
    """A largest choice from a connected group; empty where there are not two families."""
    family, queue = {group[0]: 0}, [group[0]]
    for element in queue:
        for other in neighbour[element]:
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
        for other in neighbour[element]:
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
        for other in neighbour[element]:
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
