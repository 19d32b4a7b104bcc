"""The graph on which integer arc lengths change without disturbing any cell.

Each cell asks twice that opposite sides agree (side 0 = side 2, side 1 = side 3). Take every such
balance as a vertex and every arc as an edge between the balances that it enters, with +1 from
sides 0 and 1 and -1 from sides 2 and 3: a bidirected flow. Here it is unfolded into an ordinary
directed graph, whose *states* are ``2 * balance + (one too much)``; an edge changes one arc by +1
or -1, mends the state that it leaves and disturbs the one that it enters. A closed walk, or a walk
from the outside to the outside through boundary arcs, keeps all balances. (method section 8)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells.cells import CellComplex
from ..errors import LayoutError

# Rounds of relaxation between two looks for walks of negative cost.
ROUNDS_PER_CHECK = 8


@dataclass(frozen=True)
class LengthGraph:
    """Changes of arc lengths as directed edges, sorted by the state that they enter.

    state_count   4 C; the outside is one state more, number state_count
    arc_count     A
    edge_from     (E,) int64 state that the change mends
    edge_to       (E,) int64 state that it disturbs; ascending
    edge_change   (E,) int64, 2 * arc for +1, 2 * arc + 1 for -1
    group         (G,) int64, first edge of every run with one edge_to
    """

    state_count: int
    arc_count: int
    edge_from: np.ndarray
    edge_to: np.ndarray
    edge_change: np.ndarray
    group: np.ndarray

    @property
    def outside(self) -> int:
        return self.state_count


@dataclass(frozen=True)
class Walks:
    """Walks that keep all balances.

    offset  (W + 1,) int64; walk w takes the edges edge[offset[w]:offset[w + 1]] of the LengthGraph
    edge    int64
    cost    (W,) float64, sum of the costs of the edges, each taken by itself
    """

    offset: np.ndarray
    edge: np.ndarray
    cost: np.ndarray

    def __len__(self) -> int:
        return len(self.cost)


def build_length_graph(complex: CellComplex) -> LengthGraph:
    """Unfold the balances of all cells.

    Raises LayoutError if an arc lies on no cell or on more than two sides.
    """
    arc, side = complex.side_halfarc // 2, complex.slot_side
    used = np.bincount(arc, minlength=complex.arc_count)
    if len(used) and (used.min() < 1 or used.max() > 2):
        bad = int(np.flatnonzero((used < 1) | (used > 2))[0])
        raise LayoutError(f"Arc {bad} of the layout lies on {used[bad]} cell sides, not on 1 or 2.")
    balance, sign = 2 * (side // 4) + side % 2, np.where(side % 4 < 2, 1, -1)
    order = np.argsort(arc, kind="stable")
    partner = np.full(len(arc), -1)
    twice = np.flatnonzero(arc[order][1:] == arc[order][:-1])
    partner[order[twice]], partner[order[twice + 1]] = order[twice + 1], order[twice]
    states = 4 * complex.cell_count
    pieces = []
    for amount in (1, -1):
        entered = 2 * balance + (sign * amount > 0)
        mended = 2 * balance + (sign * amount < 0)
        change = 2 * arc + (amount < 0)
        target = np.where(partner >= 0, entered[partner], states)
        single = np.flatnonzero(partner < 0)
        pieces.append((mended, target, change))
        pieces.append((np.full(len(single), states), entered[single], change[single]))
    start, target, change = (np.concatenate(column) for column in zip(*pieces))
    order = np.argsort(target, kind="stable")
    target = target[order]
    group = np.flatnonzero(np.diff(target, prepend=-1))
    return LengthGraph(states, complex.arc_count, start[order], target, change[order], group)


def impossible_arcs(graph: LengthGraph) -> np.ndarray:
    """(A,) bool, arcs that have length zero in every non-negative solution.

    A non-negative solution is a sum of walks that only lengthen, so an arc can be positive if and
    only if lengthening it lies on a closed walk of such changes.
    """
    longer = np.flatnonzero(graph.edge_change % 2 == 0)
    begin, end = graph.edge_from[longer], graph.edge_to[longer]
    part = _strong_components(graph.state_count + 1, begin, end)
    possible = np.zeros(graph.arc_count, bool)
    possible[graph.edge_change[longer[part[begin] == part[end]]] // 2] = True
    return ~possible


def lengthening_walk(graph: LengthGraph, arc: int) -> np.ndarray:
    """(n,) int64 changes, all +1, of a shortest walk through an arc that is not impossible."""
    longer = graph.edge_change % 2 == 0
    first = int(np.flatnonzero(graph.edge_change == 2 * arc)[0])
    reached = np.full(graph.state_count + 1, -1)
    goal, front = graph.edge_from[first], np.zeros(graph.state_count + 1, bool)
    front[graph.edge_to[first]] = True
    reached[graph.edge_to[first]] = first
    while reached[goal] < 0:
        edge = np.flatnonzero(longer & front[graph.edge_from] & (reached[graph.edge_to] < 0))
        if not len(edge):
            raise LayoutError(f"Arc {arc} of the layout can only have length zero.")
        reached[graph.edge_to[edge]] = edge
        front[:] = False
        front[graph.edge_to[edge]] = True
    changes, edge = [graph.edge_change[first]], reached[goal]
    while edge != first:
        changes.append(graph.edge_change[edge])
        edge = reached[graph.edge_from[edge]]
    return np.array(changes, np.int64)


def cheap_walks(graph: LengthGraph, edge_cost: np.ndarray, tolerance: float = 1e-6) -> Walks:
    """Walks of negative cost, many at once, by Bellman and Ford's relaxation of all edges.

    edge_cost  (E,) float64, inf where the change is not allowed

    Every few rounds the closed walks found so far (disjoint in their states) are handed out or,
    when there is none, the walks from the outside to each boundary arc: many short walks are worth
    more than the few cheapest ones. Nothing is returned only when nothing is negative.
    """
    finite = edge_cost[np.isfinite(edge_cost)]
    far = (graph.state_count + 1) * (1.0 + np.abs(finite).max(initial=0.0))
    distance = np.full(graph.state_count + 1, far)
    distance[graph.outside] = 0.0
    through = np.full(graph.state_count + 1, -1)
    inner = int(np.searchsorted(graph.edge_to, graph.outside))
    group = graph.group[graph.group < inner]
    size = np.diff(np.append(group, inner))
    state, start, step = graph.edge_to[group], graph.edge_from[:inner], edge_cost[:inner]
    for count in range(1, graph.state_count + 2):
        offer = distance[start] + step
        best = np.minimum.reduceat(offer, group) if len(group) else offer
        better = best < distance[state] - tolerance
        if not better.any():
            break
        limit = np.where(better, best, -np.inf)
        chosen = np.flatnonzero(offer <= np.repeat(limit, size))
        through[graph.edge_to[chosen]] = chosen
        distance[state[better]] = best[better]
        if count % ROUNDS_PER_CHECK == 0:
            walks = _negative_walks(graph, through, edge_cost, distance, tolerance)
            if len(walks):
                return walks
    return _negative_walks(graph, through, edge_cost, distance, tolerance)


def _negative_walks(graph, through, edge_cost, distance, tolerance) -> Walks:
    closed = _closed_walks(graph, through, edge_cost)
    return closed if len(closed) else _outer_walks(graph, through, edge_cost, distance, tolerance)


def _closed_walks(graph, through, edge_cost) -> Walks:
    """The cycles among the edges by which the states were last reached."""
    before = np.where(through >= 0, graph.edge_from[through], graph.outside)
    before[graph.outside] = graph.outside
    ahead = before
    for _ in range(int(graph.state_count + 1).bit_length()):
        ahead = ahead[ahead]
    on_cycle = np.unique(ahead)
    on_cycle = on_cycle[on_cycle != graph.outside]
    if not len(on_cycle):
        return _collect([], [], edge_cost, 0)
    # One state of each cycle: the smallest, found while walking all cycles in step.
    smallest, current = on_cycle.copy(), before[on_cycle]
    while True:
        running = current != on_cycle
        if not running.any():
            break
        smallest = np.minimum(smallest, current)
        current = np.where(running, before[current], current)
    first = on_cycle[smallest == on_cycle]
    return _follow(graph, through, first, before[first], through[first], edge_cost)


def _outer_walks(graph, through, edge_cost, distance, tolerance) -> Walks:
    """Walks from the outside to the outside, the cheapest for every last edge."""
    last = np.arange(np.searchsorted(graph.edge_to, graph.outside), len(graph.edge_to))
    total = distance[graph.edge_from[last]] + edge_cost[last]
    last = last[total < -tolerance]
    outside = np.full(len(last), graph.outside)
    return _follow(graph, through, outside, graph.edge_from[last], last, edge_cost)


def _follow(graph, through, goal, current, edge, edge_cost) -> Walks:
    """Walk all back from `current` to `goal` in step; `edge` is the last edge of each walk."""
    number, count = np.arange(len(goal)), len(goal)
    numbers, edges = [number], [edge]
    running = current != goal
    while running.any():
        number, goal, current = number[running], goal[running], current[running]
        edge = through[current]
        numbers.append(number)
        edges.append(edge)
        current = graph.edge_from[edge]
        running = current != goal
    return _collect(numbers, edges, edge_cost, count)


def _collect(numbers, edges, edge_cost, count) -> Walks:
    if not count:
        return Walks(np.zeros(1, np.int64), np.zeros(0, np.int64), np.zeros(0))
    number, edge = np.concatenate(numbers), np.concatenate(edges)
    order = np.argsort(number, kind="stable")
    offset = np.concatenate([[0], np.cumsum(np.bincount(number, minlength=count))])
    cost = np.bincount(number, edge_cost[edge], count)
    return Walks(offset, edge[order], cost)


def _strong_components(count, begin, end) -> np.ndarray:
    """(count,) int64 numbers of the strongly connected components (Tarjan, without recursion)."""
    order = np.argsort(begin, kind="stable")
    target = end[order].tolist()
    offset = np.concatenate([[0], np.cumsum(np.bincount(begin, minlength=count))]).tolist()
    index, low, part = [-1] * count, [0] * count, [-1] * count
    position, stack, counter, parts = offset[:-1], [], 0, 0
    for root in range(count):
        path = [root] if index[root] < 0 else []
        while path:
            state = path[-1]
            if index[state] < 0:
                index[state] = low[state] = counter
                counter += 1
                stack.append(state)
            if position[state] < offset[state + 1]:
                following = target[position[state]]
                position[state] += 1
                if index[following] < 0:
                    path.append(following)
                elif part[following] < 0:
                    low[state] = min(low[state], index[following])
                continue
            path.pop()
            if path:
                low[path[-1]] = min(low[path[-1]], low[state])
            if low[state] == index[state]:
                while part[state] < 0:
                    part[stack.pop()] = parts
                parts += 1
    return np.array(part, np.int64)
