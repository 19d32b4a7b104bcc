"""PLY: a header that describes elements and their properties, then text or binary data."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..cleaning.polygons import Polygons
from ..errors import InputError
from .text_lines import parse_numbers

_KINDS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_TRUNCATED = (
    "ends before the {0} {1} elements that it announces, so it is truncated or damaged;"
    " get the whole file"
)


@dataclass(frozen=True)
class _Property:
    """A property; `count_kind` is that of a list's length, None for a single value."""

    name: str
    kind: str
    count_kind: str | None


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


def parse_ply(data: bytes) -> tuple[np.ndarray, Polygons]:
    """Points (V, 3) float64 and polygons.

    Raises InputError with the cause only; the caller puts the file's name before it.
    """
    order, elements, start = _header(data)
    body = _Text(data[start:]) if order == "" else _Binary(data[start:], order)
    points = polygons = None
    for element in elements:
        values = _read_element(body, element)
        if element.name == "vertex":
            points = _coordinates(values)
        elif element.name == "face":
            polygons = _polygons(values)
    if points is None:
        raise InputError("has no vertices; check that it holds a mesh")
    if polygons is None:
        raise InputError("has no faces; export the mesh with its faces")
    return points, polygons


def _header(data):
    """Byte order ("" for text), the elements, and where the data begin."""
    if data[:3].strip() not in (b"ply", b"PLY") or data[3:4] not in (b"\n", b"\r", b" "):
        raise InputError("is not a PLY file; check its format")
    end = data.find(b"end_header")
    if end < 0:
        raise InputError("has no end of its header, so it is truncated; get the whole file")
    start = end + len(b"end_header")
    while data[start : start + 1] in (b" ", b"\t"):
        start += 1
    start += 2 if data[start : start + 2] == b"\r\n" else 1
    order, elements = None, []
    for line in data[:end].decode("ascii", "replace").splitlines()[1:]:
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = _ORDERS[words[1]]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], _whole_number(words[2])))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(_property(words[1:]))
        except (IndexError, KeyError, ValueError):
            raise InputError(f"has {line.strip()!r} in its header, which cannot be read") from None
    if order is None:
        raise InputError("does not say its format in the header, so it cannot be read")
    return order, elements, start


def _whole_number(word):
    number = int(word)
    if number < 0:
        raise ValueError(word)
    return number


def _property(words):
    if words[0] == "list":
        if _KINDS[words[1]][0] == "f":
            raise ValueError(words[1])
        return _Property(words[3], _KINDS[words[2]], _KINDS[words[1]])
    return _Property(words[1], _KINDS[words[0]], None)


class _Text:
    """Data as text: every value takes one place."""

    def __init__(self, data):
        self.values = parse_numbers(data, np.float64)
        self.size = len(self.values)
        self.place = 0

    def width(self, kind):
        return 1

    def take(self, places, kind):
        return self.values[places]

    def one(self, place, kind):
        value = self.values[place]
        if not (np.isfinite(value) and value == np.floor(value)):
            raise InputError(f"has a list of {value} values, so it is damaged")
        return int(value)


class _Binary:
    """Binary data: places are bytes."""

    def __init__(self, data, order):
        self.data, self.order = np.frombuffer(data, np.uint8), order
        self.size = len(data)
        self.place = 0

    def width(self, kind):
        return int(kind[1])

    def take(self, places, kind):
        width = self.width(kind)
        if len(places) and np.all(np.diff(places) == width):
            rows = self.data[places[0] : places[0] + width * len(places)]
        else:
            rows = self.data[places[:, None] + np.arange(width)].ravel()
        return np.frombuffer(rows.tobytes(), self.order + kind)

    def one(self, place, kind):
        return int(np.frombuffer(self.data, self.order + kind, 1, place)[0])


def _read_element(body, element):
    """Name -> (count,) values, or (values, lengths (count,)) of a list; moves body.place on."""
    if not element.properties:
        return {}
    least = sum(body.width(p.count_kind or p.kind) for p in element.properties)
    if body.place + least * element.count > body.size:
        raise InputError(_TRUNCATED.format(element.count, element.name))
    lists = [p for p in element.properties if p.count_kind is not None]
    lengths = _uniform_lengths(body, element, lists)
    if lengths is None:
        lengths = _varying_lengths(body, element, lists)
    sizes = iter(lengths.T)
    widths = []
    for item in element.properties:
        if item.count_kind is None:
            widths.append(np.full(element.count, body.width(item.kind)))
        else:
            widths.append(body.width(item.count_kind) + body.width(item.kind) * next(sizes))
    record = np.sum(widths, axis=0, dtype=np.int64)
    place = body.place + np.cumsum(record) - record
    body.place += int(record.sum())
    if body.place > body.size:
        raise InputError(_TRUNCATED.format(element.count, element.name))
    return _values(body, element, lengths, place, widths)


def _values(body, element, lengths, place, widths):
    values, sizes = {}, iter(lengths.T)
    for item, width in zip(element.properties, widths):
        if item.count_kind is None:
            values[item.name] = body.take(place, item.kind)
        else:
            length = next(sizes)
            start = np.repeat(place + body.width(item.count_kind), length)
            within = np.arange(len(start)) - np.repeat(np.cumsum(length) - length, length)
            values[item.name] = body.take(start + within * body.width(item.kind), item.kind), length
        place = place + width
    return values


def _uniform_lengths(body, element, lists):
    """(count, lists) lengths if all records are like the first, which most files have, else None."""
    if not lists or not element.count:
        return np.zeros((element.count, len(lists)), np.int64)
    first = _record_lengths(body, element, body.place)
    lengths = np.tile(np.array(first[0], np.int64), (element.count, 1))
    size = first[1] - body.place
    if body.place + size * element.count > body.size:
        return None
    offset, sizes = 0, iter(first[0])
    for item in element.properties:
        if item.count_kind is None:
            offset += body.width(item.kind)
            continue
        length = next(sizes)
        places = body.place + offset + size * np.arange(element.count)
        if (body.take(places, item.count_kind) != length).any():
            return None
        offset += body.width(item.count_kind) + body.width(item.kind) * length
    return lengths


def _varying_lengths(body, element, lists):
    """(count, lists) lengths, read record after record: each says where the next begins."""
    lengths = np.zeros((element.count, len(lists)), np.int64)
    place = body.place
    for number in range(element.count):
        lengths[number], place = _record_lengths(body, element, place)
    return lengths


def _record_lengths(body, element, place):
    """Lengths of the lists of the record at a place, and the place after it."""
    lengths = []
    for item in element.properties:
        if item.count_kind is None:
            place += body.width(item.kind)
            continue
        after = place + body.width(item.count_kind)
        length = body.one(place, item.count_kind) if after <= body.size else 0
        if length < 0:
            raise InputError(f"has a list of {length} values in a {element.name}, so it is damaged")
        place = after + length * body.width(item.kind)
        lengths.append(length)
        if place > body.size:
            raise InputError(_TRUNCATED.format(element.count, element.name))
    return lengths, place


def _coordinates(values):
    if not all(axis in values and not isinstance(values[axis], tuple) for axis in "xyz"):
        raise InputError("has vertices without x, y and z; check that it holds a mesh")
    return np.stack([values[axis].astype(np.float64) for axis in "xyz"], axis=1)


def _polygons(values):
    for name in ("vertex_indices", "vertex_index"):
        if isinstance(values.get(name), tuple):
            corner, size = values[name]
            if not np.all(np.isfinite(corner) & (corner == np.floor(corner))):
                raise InputError("refers to a vertex by what is not a whole number")
            return Polygons(corner.astype(np.int64), np.concatenate([[0], np.cumsum(size)]))
    raise InputError("has faces without lists of vertices; check that it holds a mesh")
