#!/usr/bin/env python3
"""CPU seconds and quality of Crossfield and of its rivals, on the same meshes, in one run.

    python3 benchmarks/run_benchmarks.py MESH.obj ... [--quads 5000] [--output docs/benchmarks.md]

Needs NumPy and SciPy; rivals that are not installed are left out with a note. Each result is made
by a process of its own; its seconds are the CPU time of that whole process, less importing the
rival's library.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

from rivals import RIVALS, read_triangles  # noqa: E402

from core.blocks.blocks import find_blocks  # noqa: E402
from core.quads.quality import scaled_jacobian  # noqa: E402
from core.surface.surface import build_surface  # noqa: E402

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
TIME_LIMIT = 120


def timed(command):
    """Run a command; returns (CPU seconds, "" or the last line of what went wrong)."""
    environment = os.environ | ONE_THREAD
    before = os.times()
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT
        )
    except subprocess.TimeoutExpired:
        return float("inf"), f"no result in {TIME_LIMIT} s"
    after = os.times()
    seconds = after.children_user + after.children_system
    seconds -= before.children_user + before.children_system
    if done.returncode:
        return seconds, (done.stderr.strip().splitlines() or ["failed"])[-1]
    return seconds, ""


def run_crossfield(path, wanted, folder):
    """(seconds, stages, points, faces, failure) of the headless command."""
    quads, report = folder / "quads.obj", folder / "report.json"
    command = [sys.executable, HERE.parent / "crossfield.py", "decompose", path]
    command += ["--quad-count", str(wanted), "--quads", quads, "--report", report]
    seconds, failure = timed(list(map(str, command)))
    if failure:
        return seconds, {}, None, None, failure
    points, faces = [], []
    for line in quads.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(w) for w in words[1:4]])
        elif words[:1] == ["f"]:
            faces.append([int(w.split("/")[0]) - 1 for w in words[1:]])
    return seconds, json.loads(report.read_text())["seconds"], np.array(points), faces, ""


def run_rival(name, path, wanted, folder):
    """The same for a rival."""
    output = folder / "rival.npz"
    command = [sys.executable, HERE / "rivals.py", name, path, wanted, output]
    seconds, failure = timed(list(map(str, command)))
    if failure or not output.exists():
        return seconds, {}, None, None, failure or "no result"
    with np.load(output) as data:
        faces = np.split(data["corners"], np.cumsum(data["sizes"])[:-1])
        seconds -= float(data["importing"])
        return seconds, {}, data["points"], [f.tolist() for f in faces], ""


def segments(points, faces):
    """(B, 2) int64, the sides that belong to one face only."""
    sides = np.array([s for f in faces for s in zip(f, f[1:] + f[:1], strict=True)])
    low, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    return low[count == 1], low, count


def distance_to(points, starts, ends):
    """(n,) float64, distance of points from the nearest of some segments."""
    along = ends - starts
    square = np.maximum((along**2).sum(1), 1e-300)
    nearest = np.full(len(points), np.inf)
    for chunk in np.array_split(np.arange(len(points)), max(1, len(points) // 200)):
        away = points[chunk, None] - starts
        share = np.clip((away * along).sum(2) / square, 0, 1)
        off = away - share[..., None] * along
        nearest[chunk] = np.sqrt((off**2).sum(2)).min(1, initial=np.inf)
    return nearest


def loops_of(boundary):
    """Number of connected pieces of the boundary segments."""
    piece = {}

    def root(v):
        while piece.setdefault(v, v) != v:
            piece[v] = piece[piece[v]]
            v = piece[v]
        return v

    for a, b in boundary.tolist():
        piece[root(a)] = root(b)
    return len({root(v) for v in list(piece)})


def measure(points, faces, surface):
    """The columns of the table for one result."""
    boundary, sides, count = segments(points, faces)
    quads = np.array([f for f in faces if len(f) == 4])
    used = np.unique(sides)
    euler = len(used) - len(sides) + len(faces)
    normal = np.zeros_like(surface.points)
    for k in range(3):
        weighted = surface.face_normal * surface.face_area[:, None]
        np.add.at(normal, surface.triangles[:, k], weighted)
    shape = scaled_jacobian(points, quads, normal[cKDTree(surface.points).query(points)[1]])
    rim = surface.tail[surface.loop_halfedges], surface.head[surface.loop_halfedges]
    edge = np.linalg.norm(points[sides[:, 0]] - points[sides[:, 1]], axis=1).mean()
    ends = points[boundary[:, 0]], points[boundary[:, 1]]
    off = [distance_to((ends[0] + ends[1]) / 2, *(surface.points[r] for r in rim))]
    off.append(distance_to(surface.points[rim[0]], *ends) if len(boundary) else [np.inf])
    valence = np.bincount(np.concatenate(faces), minlength=len(points))
    outer = np.zeros(len(points), bool)
    outer[boundary.ravel()] = True
    return {
        "quads": f"{len(quads)}"
        + (f" + {len(faces) - len(quads)}" if len(quads) < len(faces) else ""),
        "irregular": int(((valence != 4) & ~outer & (valence > 0)).sum()),
        "blocks": block_count(quads, points, valence, outer) if len(quads) == len(faces) else "-",
        "SJ min / mean": f"{shape.min():.2f} / {shape.mean():.3f}",
        "SJ <= 0": int((shape <= 0).sum()),
        "deviation": f"{max(o.max() if len(o) else 0 for o in map(np.asarray, off)) / edge:.2f}",
        "topology kept": "yes"
        if euler == surface.euler_characteristic
        and loops_of(boundary) == surface.loop_count
        and count.max() <= 2
        else "no",
    }


def block_count(quads, points, valence, outer):
    """Blocks of the base complex, by the same rule for everybody; "-" where there is none."""
    source = np.where(outer, valence != 2, valence != 4) & (valence > 0)
    try:
        return find_blocks(quads, len(points), source).count
    except Exception:  # a rival's mesh need not be a manifold
        return "-"


def main():
    """Run everything and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--quads", type=int, default=5000)
    parser.add_argument("--output", type=Path, help="write the table to this file too")
    arguments = parser.parse_args()
    rows, stage_rows, notes = [], [], []
    present = [n for n, (module, _) in RIVALS.items() if importlib.util.find_spec(module)]
    notes += [
        f"{name} is not installed and was left out." for name in RIVALS if name not in present
    ]
    for path in arguments.meshes:
        surface = build_surface(*read_triangles(path))
        for name in ["Crossfield", *present]:
            with tempfile.TemporaryDirectory() as folder:
                run = run_crossfield if name == "Crossfield" else run_rival
                head = () if name == "Crossfield" else (name,)
                outcome = run(*head, path, arguments.quads, Path(folder))
            seconds, stages, points, faces, failure = outcome
            row = {
                "input": path.stem,
                "program": name,
                "CPU s": f"{seconds:.2f}" if np.isfinite(seconds) else "-",
            }
            row |= {"quads": failure} if failure else measure(points, faces, surface)
            rows.append(row)
            if stages:
                stage_rows.append({"input": path.stem} | {k: f"{v:.2f}" for k, v in stages.items()})
            print(" ".join(str(v) for v in row.values()), flush=True)
    text = "\n".join([table(rows), "", table(stage_rows), "", machine(arguments.quads), *notes, ""])
    print("\n" + text)
    if arguments.output:
        arguments.output.write_text(text, encoding="utf-8")


def table(rows):
    """Rows of dicts as a Markdown table."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(str(row.get(c, "")) for c in columns) + " |" for row in rows]
    return "\n".join(lines)


def machine(wanted):
    """What the numbers were measured with."""
    return (
        f"{wanted} quads wanted; Python {platform.python_version()}, NumPy {np.__version__}, one"
        " thread for linear algebra. CPU s: whole process, less importing the rival's library."
        " Blocks: of the base complex. SJ: scaled Jacobian. Deviation: largest distance between"
        " the boundaries, in mean edge lengths.\n"
    )


if __name__ == "__main__":
    main()
