"""One-sided surfaces are cut open along short paths."""

import numpy as np
import pytest

from tests.core.cleaned import cleaned


def strip_of_half_turns(around, across, turns):
    """A band with so many half turns: a Möbius band where they are odd."""
    u = 2 * np.pi * np.arange(around) / around
    v = np.linspace(-0.3, 0.3, across + 1)
    tilt = 0.5 * turns * u
    radius = 1 + v[None] * np.cos(tilt)[:, None]
    points = np.stack(
        [
            radius * np.cos(u)[:, None],
            radius * np.sin(u)[:, None],
            np.broadcast_to(v * np.sin(tilt)[:, None], radius.shape),
        ],
        -1,
    )
    quads = []
    for i in range(around):
        for j in range(across):
            row, last = i * (across + 1), i == around - 1
            a, b = row + j, row + j + 1
            flip = last and turns % 2
            c = (across - j if flip else j) if last else a + across + 1
            d = (across - j - 1 if flip else j + 1) if last else b + across + 1
            quads.append([a, b, d, c])
    return points.reshape(-1, 3), quads


@pytest.mark.parametrize("around, across", [(12, 1), (30, 4), (40, 9)])
def test_moebius_band_is_cut_across(around, across):
    points, quads = strip_of_half_turns(around, across, 1)
    mesh, surface = cleaned(points, quads)
    assert (surface.euler_characteristic, surface.loop_count) == (1, 1)
    assert surface.face_count == 2 * len(quads)
    across = f"{across} edge" + "s" * (across > 1)
    assert f"The one-sided surface was cut open along {across}." in mesh.warnings
    assert cleaned(*strip_of_half_turns(30, 4, 2))[1].euler_characteristic == 0


def test_klein_bottle_is_cut():
    """The torus with its ends glued the other way round: closed and one-sided."""
    m, n = 16, 10
    u, v = np.meshgrid(np.arange(m), np.arange(n), indexing="ij")
    a, b = 2 * np.pi * u / m, 2 * np.pi * v / n
    points = np.stack(
        [
            (2 + np.cos(a / 2) * np.sin(b) - np.sin(a / 2) * np.sin(2 * b)) * np.cos(a),
            (2 + np.cos(a / 2) * np.sin(b) - np.sin(a / 2) * np.sin(2 * b)) * np.sin(a),
            np.sin(a / 2) * np.sin(b) + np.cos(a / 2) * np.sin(2 * b),
        ],
        -1,
    ).reshape(-1, 3)
    number = lambda i, j: i * n + j % n if i < m else (-j) % n
    quads = [
        [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]
        for i in range(m)
        for j in range(n)
    ]
    _, surface = cleaned(points, quads)
    assert surface.face_count == 2 * m * n
    assert surface.component_count == 1 and surface.loop_count >= 1


def test_projective_plane_of_six_vertices():
    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1)]
    faces += [(1, 2, 4), (2, 3, 5), (3, 4, 1), (4, 5, 2), (5, 1, 3)]
    points = np.random.default_rng(5).random((6, 3))
    _, surface = cleaned(points, faces)
    assert surface.face_count == 10 and surface.component_count == 1
    assert (surface.euler_characteristic, surface.loop_count) == (1, 1)


def test_moebius_bands_joined_with_holes_and_others():
    band, quads = strip_of_half_turns(24, 5, 1)
    quads = [q for k, q in enumerate(quads) if k not in (22, 57)]
    _, surface = cleaned(band, quads)
    assert surface.component_count == 1
    two = np.concatenate([band, band + [4, 0, 0]])
    _, surface = cleaned(two, quads + [[v + len(band) for v in q] for q in quads])
    assert surface.component_count == 2
