#!/usr/bin/env python3
"""Blocks, shapes and CPU seconds of every choice of coarseness, in one table.

    python3 benchmarks/coarseness.py MESH.obj ... [--quads 5000] [--repeats 3] [--output ...]

Needs SciPy, as run_benchmarks.py does. The choices take turns, and the least CPU seconds of all
repeats count, so that other work on the machine spoils no comparison. "As often" is how many times
the seconds of the direct layout a choice takes. "Kept" says whether every mesh of the row has the
topology of the input, its boundary within a quarter of an edge length, and no inverted quad.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from pathlib import Path

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

from run_benchmarks import measure, table

from core.blocks.blocks import verify_blocks
from core.files.mesh_files import read_mesh
from core.pipeline import decompose
from core.settings import Settings

CHOICES = ("direct", "balanced", "fewest")
MOST_DEVIATION = 0.25


def row(path, wanted, repeats):
    """The row of the table for one mesh."""
    mesh = read_mesh(path)
    seconds, results = {choice: np.inf for choice in CHOICES}, {}
    for _ in range(repeats):
        for choice in CHOICES:
            result = decompose(*mesh, Settings(quad_count=wanted, coarseness=choice))
            seconds[choice] = min(seconds[choice], result.seconds["total"])
            results[choice] = result
    columns = {"input": path.stem}
    for choice, result in results.items():
        shape = result.quads.scaled_jacobian
        columns |= {
            choice: result.blocks.count,
            f"SJ, {choice}": f"{shape.min():.2f} / {shape.mean():.3f}",
            f"quads, {choice}": len(result.quads.quads),
            f"s, {choice}": f"{seconds[choice]:.2f}",
        }
        if choice != "direct":
            columns[f"as often, {choice}"] = f"{seconds[choice] / seconds['direct']:.2f}"
    return columns | {"kept": "yes" if all(map(is_kept, results.values())) else "no"}


def is_kept(result) -> bool:
    """Are topology and boundary those of the input, and all quads and blocks valid?"""
    quads = result.quads
    verify_blocks(result.blocks, quads.quads)
    found = measure(quads.points, quads.quads.tolist(), result.whole)
    return (
        found["topology kept"] == "yes"
        and found["SJ <= 0"] == 0
        and (result.whole.loop_count == 0 or float(found["deviation"]) <= MOST_DEVIATION)
    )


def main():
    """Run everything and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--quads", type=int, default=5000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--output", type=Path, help="write the table to this file too")
    arguments = parser.parse_args()
    rows = []
    for path in arguments.meshes:
        rows.append(row(path, arguments.quads, arguments.repeats))
        print(" | ".join(str(value) for value in rows[-1].values()), flush=True)
    text = "\n".join(["# The choices of coarseness", "", summary(arguments), "", table(rows), ""])
    print("\n" + text)
    if arguments.output:
        arguments.output.write_text(text, encoding="utf-8")


def summary(arguments):
    """What the columns mean and what they were measured with."""
    return (
        f"Made by `benchmarks/coarseness.py`. {arguments.quads} quads wanted: blocks, scaled"
        " Jacobian (least / mean), quads and CPU seconds as traced (direct), by default (balanced)"
        f" and with the fewest blocks; the least seconds of {arguments.repeats} runs each, and how"
        " many times those of the direct layout they are. Kept: topology and boundary are the"
        f" input's, no quad is inverted. Python {platform.python_version()}, NumPy"
        f" {np.__version__}, one thread for linear algebra."
    )


if __name__ == "__main__":
    main()
