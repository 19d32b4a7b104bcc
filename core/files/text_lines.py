"""Numbers on the lines of a text that begin with some keyword, by array operations.

Mesh files of a million lines are read without a Python loop over the lines: tokens and lines are
found in the bytes as an array, and all numbers of one keyword are converted in one call.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from ..errors import InputError

_NEWLINE, _SPACE, _HASH = 10, 32, 35


@dataclass(frozen=True)
class TextLines:
    """The bytes of a text, and where its tokens lie. Build it with `split_lines`.

    buffer       (B,) uint8, comments blanked out, ending in white space
    newline      (n,) int64, places of the line ends
    token        (T,) int64, places where tokens start
    token_line   (T,) int64, line of each token, from 0
    line_token   (m + 1,) int64, the first token of each line that has any, and T
    """

    buffer: np.ndarray
    newline: np.ndarray
    token: np.ndarray
    token_line: np.ndarray
    line_token: np.ndarray


@dataclass(frozen=True)
class KeywordLines:
    """The lines that begin with one keyword.

    text    (b,) uint8, the rest of those lines, one after the other, line ends included
    count   (m,) int64, tokens after the keyword on each line
    number  (m,) int64, line numbers from 0
    """

    text: np.ndarray
    count: np.ndarray
    number: np.ndarray

    def values(self, kind) -> np.ndarray:
        """(sum of count,) of dtype `kind`, all tokens as numbers.

        Raises InputError with the place, but without the file's name, if one is no such number.
        """
        total = int(self.count.sum())
        text = self.text.tobytes()
        values = parse_numbers(text, kind)
        if len(values) == total:
            return values
        convert = int if np.dtype(kind).kind == "i" else float
        for line, number in zip(text.split(b"\n"), self.number.tolist()):
            for token in line.split():
                try:
                    convert(token)
                except ValueError:
                    shown = token.decode("utf-8", "replace")
                    raise InputError(f"line {number + 1} has {shown!r} for a number") from None
        raise InputError(f"a number near line {self.number[0] + 1} cannot be read")


def parse_numbers(text: bytes, kind) -> np.ndarray:
    """Numbers separated by white space; an empty array if anything else is among them."""
    if not text.strip():
        return np.zeros(0, kind)
    with warnings.catch_warnings():
        # How NumPy tells that it stopped before the end; later versions raise ValueError.
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, kind, sep=" ")
        except (DeprecationWarning, ValueError):
            return np.zeros(0, kind)


def split_lines(data: bytes, comments: bool = True) -> TextLines:
    """Find the lines and tokens of a text; `#` starts a comment if `comments`."""
    buffer = np.frombuffer(data + b"\n" + b" " * 16, np.uint8).copy()
    buffer[buffer == 13] = _NEWLINE
    newline = np.flatnonzero(buffer == _NEWLINE)
    if comments and b"#" in data:
        _blank_comments(buffer, newline)
    blank = buffer <= _SPACE
    token = np.flatnonzero(~blank & np.concatenate([[True], blank[:-1]]))
    token_line = np.searchsorted(newline, token)
    first = np.flatnonzero(np.diff(token_line, prepend=-1))
    return TextLines(buffer, newline, token, token_line, np.append(first, len(token)))


def _blank_comments(buffer, newline):
    start = np.flatnonzero(buffer == _HASH)
    buffer[ranges_to_ends(len(buffer), start, newline)] = _SPACE


def ranges_to_ends(size: int, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(size,) bool, True from each start up to and without the next end.

    start, end  ascending places; the last end lies behind the last start
    """
    end = end[np.searchsorted(end, start)]
    first = np.diff(end, prepend=-1) > 0
    return _between(size, start[first], end[first])


def _between(size, start, end):
    """(size,) bool, True from each start up to and without its end; the ranges are disjoint."""
    change = np.zeros(size, np.int8)
    change[start] = 1
    change[end] -= 1
    return np.cumsum(change, dtype=np.int8).astype(bool)


def keyword_lines(lines: TextLines, keyword: bytes) -> KeywordLines:
    """The lines whose first token is the keyword, at most 15 letters long."""
    first = lines.line_token[:-1]
    place = lines.token[first]
    match = lines.buffer[place + len(keyword)] <= _SPACE
    for offset, letter in enumerate(keyword):
        match &= lines.buffer[place + offset] == letter
    number = lines.token_line[first[match]]
    count = np.diff(lines.line_token)[match] - 1
    start, end = place[match] + len(keyword), lines.newline[number] + 1
    return KeywordLines(lines.buffer[_between(len(lines.buffer), start, end)], count, number)
