"""Wavefront OBJ: vertices and polygons of a text file."""

from __future__ import annotations

import numpy as np

from ..cleaning.polygons import Polygons
from ..errors import InputError
from .text_lines import KeywordLines, keyword_lines, ranges_to_ends, split_lines

_SLASH, _SPACE = 47, 32


def parse_obj(data: bytes) -> tuple[np.ndarray, Polygons]:
    """Points (V, 3) float64 and polygons; texture and normal references are passed over.

    Raises InputError with the cause only; the caller puts the file's name before it.
    """
    if b"\0" in data:
        raise InputError("is not an OBJ file but binary data; check its format")
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\\" in data:
        for line_end in (b"\\\r\n", b"\\\n", b"\\\r"):
            data = data.replace(line_end, b" ")
    lines = split_lines(data)
    vertices, faces = keyword_lines(lines, b"v"), keyword_lines(lines, b"f")
    if not len(vertices.count):
        raise InputError("has no vertices, so it is not an OBJ mesh; check its format")
    points = _first_three(vertices)
    corner = _vertex_numbers(faces, vertices)
    return points, Polygons(corner, np.concatenate([[0], np.cumsum(faces.count)]))


def _first_three(vertices):
    """Coordinates, without a weight or a colour after them."""
    short = vertices.count < 3
    if short.any():
        line = vertices.number[np.argmax(short)] + 1
        raise InputError(f"has a vertex with fewer than three coordinates on line {line}")
    values = vertices.values(np.float64)
    start = np.cumsum(vertices.count) - vertices.count
    return values[start[:, None] + np.arange(3)]


def _vertex_numbers(faces, vertices):
    """Vertex numbers from 0: positive ones count from 1, negative ones back from the line."""
    number = _without_references(faces).values(np.int64)
    if (number == 0).any():
        line = np.repeat(faces.number, faces.count)[np.argmax(number == 0)] + 1
        raise InputError(f"refers to vertex 0 on line {line}, but OBJ files count from 1")
    backwards = number < 0
    known = np.searchsorted(vertices.number, np.repeat(faces.number, faces.count)[backwards])
    number[backwards] += known
    number[~backwards] -= 1
    return number


def _without_references(faces):
    """The same lines with "7/3/5" and "7//5" cut down to "7"."""
    text = faces.text
    slash = np.flatnonzero(text == _SLASH)
    # A token that starts with a slash has no vertex; it stays, to be reported.
    slash = slash[text[slash - 1] > _SPACE]
    if not len(slash):
        return faces
    cut = ranges_to_ends(len(text), slash, np.flatnonzero(text <= _SPACE))
    return KeywordLines(np.where(cut, np.uint8(_SPACE), text), faces.count, faces.number)
