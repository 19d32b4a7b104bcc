"""Materials of the polygons of an OBJ file, by its usemtl lines."""

from __future__ import annotations

import numpy as np

from .text_lines import keyword_lines, split_lines


def parse_materials(data: bytes) -> tuple[list, np.ndarray]:
    """Names of the materials in the order of use, and (N,) int64, the material of each polygon.

    Polygons before the first usemtl line have material -1. Polygons are counted as
    `obj_file.parse_obj` does.
    """
    lines = split_lines(data.removeprefix(b"\xef\xbb\xbf"))
    uses, faces = keyword_lines(lines, b"usemtl"), keyword_lines(lines, b"f")
    given = [
        b" ".join(line.split()).decode("utf-8", "replace")
        for line in uses.text.tobytes().split(b"\n")[: len(uses.number)]
    ]
    names = list(dict.fromkeys(given))
    number = np.array([-1, *(names.index(name) for name in given)])
    return names, number[np.searchsorted(uses.number, faces.number)]
