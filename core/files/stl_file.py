"""STL: triangles without shared vertices, as text or binary."""

from __future__ import annotations

import numpy as np

from ..cleaning.polygons import Polygons
from ..errors import InputError
from .text_lines import keyword_lines, split_lines

_RECORD = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84


def parse_stl(data: bytes) -> tuple[np.ndarray, Polygons]:
    """Points (V, 3) float64 and triangles; corners with equal coordinates are one vertex.

    Raises InputError with the cause only; the caller puts the file's name before it.
    """
    count = int.from_bytes(data[80:_HEADER], "little") if len(data) >= _HEADER else 0
    size = _HEADER + count * _RECORD.itemsize
    is_text = data[:512].lstrip().lower().startswith(b"solid")
    if len(data) >= _HEADER and (len(data) == size or not is_text):
        corner = _binary_corners(data, count, size)
    elif is_text:
        corner = _text_corners(data)
    else:
        raise InputError("is not an STL file; check its format")
    return _welded(corner)


def _binary_corners(data, count, size):
    if len(data) < size:
        raise InputError(
            f"announces {count:,} triangles but holds {(len(data) - _HEADER) // _RECORD.itemsize:,},"
            " so it is truncated or not an STL file; get the whole file"
        )
    record = np.frombuffer(data, _RECORD, count, _HEADER)
    return record["corner"].astype(np.float64).reshape(-1, 3)


def _text_corners(data):
    lines = split_lines(data, comments=False)
    vertices = keyword_lines(_lower(lines), b"vertex")
    wrong = vertices.count != 3
    if wrong.any():
        line = vertices.number[np.argmax(wrong)] + 1
        raise InputError(f"has a vertex without three coordinates on line {line}")
    if b"endsolid" not in data[-4096:].lower():
        raise InputError("ends without endsolid, so it is truncated; get the whole file")
    if len(vertices.count) % 3:
        raise InputError("has a triangle without three vertices, so it is damaged")
    return vertices.values(np.float64).reshape(-1, 3)


def _lower(lines):
    """Keywords may be written in capitals."""
    capital = (lines.buffer >= ord("A")) & (lines.buffer <= ord("Z"))
    lines.buffer[capital] += 32
    return lines


def _welded(corner):
    """Corners (3 N, 3) with the same coordinates to the last bit become one vertex.

    Vertices are numbered in the order in which they first appear.
    """
    corner = corner + 0.0  # -0.0 and 0.0 are the same place
    order = np.lexsort(corner.T)
    ordered = corner[order]
    new = np.ones(len(corner), bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(1)
    # The sort is stable, so the first of each run is the first in the file.
    first = order[new]
    group = np.cumsum(new) - 1
    rank = np.empty(len(first), np.int64)
    by_appearance = np.argsort(first)
    rank[by_appearance] = np.arange(len(first))
    vertex = np.empty(len(corner), np.int64)
    vertex[order] = rank[group]
    return corner[first[by_appearance]], Polygons(vertex, np.arange(0, len(corner) + 1, 3))
