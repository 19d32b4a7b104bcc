"""Creases that end beside another crease give way; those that end in the open do not."""

import numpy as np

from core.features.crease_ends import drop_short_ends, give_ends_room
from core.features.features import marked_features
from tests.core.surfaces import plate


def lines(surface, *segments):
    """Mask of the edges along straight lines y, from x to x, on a plate of unit squares."""
    pairs = [
        [[a, b] for a, b in zip(row, row[1:], strict=False)]
        for y, low, high in segments
        for row in [_row(surface, y, low, high)]
    ]
    return marked_features(surface, np.arange(surface.vertex_count), np.concatenate(pairs))


def _row(surface, y, low, high):
    x = surface.points[:, 0]
    on = np.isclose(surface.points[:, 1], y) & (x > low - 1e-9) & (x < high + 1e-9)
    return np.flatnonzero(on)[np.argsort(x[on])]


def along(surface, crease):
    """Lengths of the creases on each line y that has any."""
    edge = surface.edges[crease[surface.edges]]
    y = surface.points[surface.tail[edge], 1].round(6)
    return {float(v): float(surface.edge_length[edge[y == v]].sum()) for v in np.unique(y)}


def shortened(segments, sharpness=None):
    surface = plate(np.ones((100, 40)))
    crease = lines(surface, *segments)
    angle = np.ones(len(crease))
    for y, value in (sharpness or {}).items():
        angle[np.isclose(surface.points[surface.tail, 1], y)] = value
    give_ends_room(surface, crease, angle)
    assert np.array_equal(crease, crease[surface.twin] & (surface.twin >= 0))
    return along(surface, crease)


def test_the_fainter_of_two_that_run_side_by_side_goes():
    both = ((20, 10, 90), (21, 0, 100))
    assert shortened(both) == {21: 100}
    assert shortened(both, {20: 3.0}) == {21: 100}  # what has no open end stays
    open_both = ((20, 10, 90), (21, 10, 80))
    assert shortened(open_both, {20: 0.5}) == {20: 10, 21: 70}  # beyond 80 it is alone
    assert shortened(open_both, {21: 0.5}) == {20: 80}


def test_what_runs_on_alone_stays():
    left = shortened(((20, 10, 60), (21, 50, 100)))
    assert set(left) == {20, 21}
    assert left[20] + left[21] == 100 - 10
    assert shortened(((20, 10, 60), (30, 50, 100))) == {20: 50, 30: 50}


def test_short_pieces_with_open_ends_do_not_count():
    surface = plate(np.ones((100, 40)))
    crease = lines(surface, (20, 10, 12), (30, 0, 100))
    drop_short_ends(surface, crease)
    assert along(surface, crease) == {30: 100}
