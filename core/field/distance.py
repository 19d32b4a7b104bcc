"""Arrival distance: how far a front has travelled from the fixed crosses, and where it came from.

The Eikonal equation |grad d| = 1 is solved element by element (appendix A.1 of the paper with its
misprints corrected) by fast marching in array form: not one vertex at a time but all whose distance
lies within one edge length of the smallest pending one; a vertex whose distance falls later is
pending once more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.surface import TriangleSurface
from .front_elements import FrontElements, front_elements


@dataclass(frozen=True)
class ArrivalDistance:
    """Distance from the sources, and for every other vertex the element that gave it.

    Following parents always leads to strictly smaller distances and ends at sources.

    distance   (V,) float64, object-space lengths, 0 at the sources
    source     (V,) bool
    parent     (V, 2) int64, the vertices that the front came from, the target on the left of the
               edge between them; twice the same where the front came along an edge; the vertex
               itself at sources
    transport  (V, 2) float64, radians: an angle a at the parent becomes a + transport here
    base       (V,) float64, distance between the parents, 0 where they are the same
    apex       (V, 2) float64, the vertex seen from the first parent: along the edge towards the
               second, and away from it; see `front_elements.FrontElements`
    """

    distance: np.ndarray
    source: np.ndarray
    parent: np.ndarray
    transport: np.ndarray
    base: np.ndarray
    apex: np.ndarray


def arrival_distance(surface: TriangleSurface, sources: np.ndarray) -> ArrivalDistance:
    """Distance along the surface from the nearest source.

    sources  (V,) bool; a connected component without any starts at its vertex of least number
    """
    sources = _completed(surface, sources)
    elements = front_elements(surface)
    step = float(np.median(surface.edge_length))
    distance, upwind, single = _march(elements, sources, step)
    return _arrival(elements, sources, distance, upwind, single)


def _completed(surface, sources):
    """The sources, with one more in each component that has none."""
    component = np.empty(surface.vertex_count, np.int64)
    component[surface.tail] = np.repeat(surface.component, 3)
    reached = np.zeros(surface.component_count, bool)
    reached[component[sources]] = True
    _, first = np.unique(component, return_index=True)
    completed = np.array(sources, bool)
    completed[first[~reached]] = True
    return completed


def _march(elements: FrontElements, sources, step):
    """Distance, upwind element (-1 at sources) and which single parent (-1: both) per vertex."""
    feed, offset = _fed_elements(elements, len(sources))
    distance = np.where(sources, 0.0, np.inf)
    upwind = np.full(len(sources), -1, np.int64)
    single = np.full(len(sources), -1, np.int8)
    waiting = sources.copy()
    pending = np.flatnonzero(sources)
    while len(pending):
        reached = distance[pending]
        in_front = reached <= reached.min() + step
        front, pending = pending[in_front], pending[~in_front]
        waiting[front] = False
        element = _downwind(elements, feed, offset, front, distance)
        value, only = _arrivals(elements, element, distance)
        target = elements.target[element]
        better = value < distance[target]
        element, value, only, target = (a[better] for a in (element, value, only, target))
        np.minimum.at(distance, target, value)
        best = value == distance[target]
        upwind[target[best]] = element[best]
        single[target[best]] = only[best]
        fallen = np.unique(target[best][~waiting[target[best]]])
        waiting[fallen] = True
        pending = np.concatenate([pending, fallen])
    return distance, upwind, single


def _fed_elements(elements, vertex_count):
    """The elements that have each vertex as a parent: feed[offset[v]:offset[v + 1]]."""
    parents = elements.parent.ravel()
    feed = np.argsort(parents, kind="stable") % len(elements.target)
    count = np.bincount(parents, minlength=vertex_count)
    return feed, np.concatenate([[0], np.cumsum(count)])


def _downwind(elements, feed, offset, front, distance):
    """The elements that the front feeds and that may bring their targets a smaller distance."""
    count = offset[front + 1] - offset[front]
    before = np.cumsum(count) - count
    slot = np.arange(count.sum()) + np.repeat(offset[front] - before, count)
    element = feed[slot]
    return element[distance[elements.target[element]] > np.repeat(distance[front], count)]


def _arrivals(elements, element, distance):
    """Arrival at the targets through the elements, and which parent alone gave it (-1: both).

    Through the edge between the parents only where the front crosses it on the way to the target
    and passes both parents earlier; otherwise along one of the two sides.
    """
    first, second = distance[elements.parent[:, element]]
    base, (along, away) = elements.base[element], elements.apex[:, element]
    with np.errstate(invalid="ignore"):
        slope = (second - first) / base
        height = np.sqrt(1 - slope * slope)
        through = first + slope * along + height * away
        foot = along * height - away * slope
        crossed = (foot >= 0) & (foot <= base * height)
        crossed &= through > np.maximum(first, second)
    from_first = first + np.hypot(along, away)
    from_second = second + np.hypot(base - along, away)
    nearer = (from_second < from_first).astype(np.int8)
    value = np.where(crossed, through, np.minimum(from_first, from_second))
    return value, np.where(crossed, np.int8(-1), nearer)


def _arrival(elements, sources, distance, upwind, single):
    """What the marching found, gathered per vertex."""
    vertex = np.arange(len(sources))
    element = np.maximum(upwind, 0)
    parent, transport = elements.parent[:, element].T, elements.transport[:, element].T
    base, apex = elements.base[element], elements.apex[:, element].T
    for chosen in (0, 1):
        alone = np.flatnonzero(single == chosen)
        apex[alone, 0] = np.hypot(apex[alone, 0] - chosen * base[alone], apex[alone, 1])
        parent[alone] = parent[alone, chosen, None]
        transport[alone] = transport[alone, chosen, None]
    parent[sources] = vertex[sources, None]
    transport[sources] = 0.0
    lonely = sources | (single >= 0)
    base[lonely] = 0.0
    apex[single >= 0, 1] = 0.0
    apex[sources] = 0.0
    return ArrivalDistance(distance, sources, parent, transport, base, apex)
