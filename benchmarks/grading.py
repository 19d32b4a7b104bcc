#!/usr/bin/env python3
"""Grading towards walls: how well first heights and growth are met, and at what shape and cost.

    python3 benchmarks/grading.py MESH.obj ... [--quads 5000] [--heights 1e-4 1e-3] [--ratio 1.2]

Prints a row of a table per mesh and height. Lines are those that leave a wall, but for nodes that
lie on a boundary themselves; the growth is measured over the first ten cells of each line.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from time import process_time

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

from rivals import read_triangles

from core.divisions.divisions import redivide
from core.divisions.wall_spacing import Grading, edge_loops, turned_grid
from core.errors import CrossfieldError
from core.pipeline import decompose
from core.settings import Settings
from core.surface.boundary import build_loops

CELLS = 11


def wall_lines(result):
    """Distances of first nodes from the wall, and ratios of neighbouring cells, both (n,) float64."""
    loops, placement = build_loops(result.whole), result.placement
    on_wall = edge_loops(result.blocks, placement.loop)[result.blocks.block_edge] >= 0
    away, ratio = [], []
    for block, side in np.argwhere(on_wall):
        grid = turned_grid(result.blocks, block, side)
        inside = ~result.quads.on_boundary[grid[1]]
        loop = placement.loop[grid[0, inside]]
        point = placement.point[grid[1, inside]]
        foot, _ = loops.point(loop, loops.closest(loop, point))
        away.append(np.linalg.norm(point - foot, axis=1))
        line = placement.point[grid[: min(CELLS, (len(grid) + 1) // 2)][:, inside]]
        cell = np.linalg.norm(np.diff(line, axis=0), axis=2)
        ratio.append((cell[1:] / cell[:-1]).ravel())
    return np.concatenate(away), np.concatenate(ratio)


def row(name, before, height, growth):
    """A row of the table."""
    start = process_time()
    try:
        after = redivide(before, grading=Grading(height, growth))
    except CrossfieldError as error:
        return f"| {name} | {height:g} | refused: {error} | | | | |"
    seconds = process_time() - start
    away, ratio = wall_lines(after)
    met = 100 * np.mean(np.abs(away / height - 1) <= 0.05)
    return (
        f"| {name} | {height:g} | {met:.1f} | {np.quantile(ratio, 0.99):.2f} / {ratio.max():.2f}"
        f" | {after.quads.scaled_jacobian.min():.2f} | {len(after.quads.quads):,} | {seconds:.1f} |"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--quads", type=int, default=5000)
    parser.add_argument("--heights", type=float, nargs="+", default=[1e-4, 1e-3])
    parser.add_argument("--ratio", type=float, default=1.2)
    options = parser.parse_args()
    print("| mesh | first height | met within 5 %, % of lines | growth, 99 % / worst"
          " | worst scaled Jacobian | quads | CPU seconds |")
    print("|---|---|---|---|---|---|---|")
    for path in options.meshes:
        before = decompose(*read_triangles(path), Settings(quad_count=options.quads))
        for height in options.heights:
            print(row(path.stem, before, height, options.ratio), flush=True)


if __name__ == "__main__":
    main()
