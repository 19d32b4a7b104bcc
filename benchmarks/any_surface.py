#!/usr/bin/env python3
"""What becomes of every mesh: repairs, way taken, blocks, quality, creases and seconds in one table.

    python3 benchmarks/any_surface.py FOLDER_OR_MESH ... [--primitives] [--quads 5000] [--output ...]

Needs SciPy, as run_benchmarks.py does; `--primitives` adds Blender's own shapes, alone, all joined
in one object, and with a subdivision modifier, and needs Blender's Python module. Everything runs
with default settings unless `--coarseness` says otherwise.
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

from run_benchmarks import distance_to, table

from core.errors import CrossfieldError
from core.features.features import detect_features
from core.files.mesh_files import read_mesh
from core.pipeline import decompose
from core.settings import Settings
from core.surface.surface import build_surface

PRIMITIVES = {
    "plane": {}, "grid": {}, "cube": {}, "cylinder": {}, "cone": {}, "uv_sphere": {},
    "ico_sphere": {}, "torus": {}, "monkey": {}, "circle": {"fill_type": "NGON"},
}
# Points on every crease edge of the input whose distance from the mesh is measured.
SAMPLES = np.array([0.0, 0.25, 0.5, 0.75])


def shared_meshes(paths):
    """(name, points, polygons or the sentence of a refusal) of all mesh files in order of name."""
    for path in paths:
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        for file in files:
            try:
                yield file.stem, *read_mesh(file)
            except CrossfieldError as error:
                yield file.stem, None, str(error)


def primitives():
    """The same of Blender's primitives: each alone, all joined, and subdivided once."""
    import bpy

    for levels in (0, 1):
        for name in [*PRIMITIVES, "joined"]:
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            for place, member in enumerate(PRIMITIVES if name == "joined" else [name]):
                add = getattr(bpy.ops.mesh, f"primitive_{member}_add")
                add(location=(3.0 * place, 0.0, 0.0), **PRIMITIVES[member])
            if name == "joined":
                bpy.ops.object.select_all(action="SELECT")
                bpy.ops.object.join()
            thing = bpy.context.object
            if levels:
                thing.modifiers.new("subdivision", "SUBSURF").levels = levels
            mesh = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
            points = np.array([vertex.co[:] for vertex in mesh.vertices], float)
            suffix = ", subdivided" if levels else ""
            yield name + suffix, points, [list(face.vertices) for face in mesh.polygons]


def crease_distance(result, settings):
    """Mean distance of the creases of the input from the edges of the mesh, in mean edge lengths."""
    surface = build_surface(result.clean.points, result.clean.triangles)
    mask = detect_features(surface, settings.feature_angle, settings.feature_follow_angle)
    edge = surface.edges[mask[surface.edges]]
    if not len(edge):
        return "-"
    tail, head = surface.points[surface.tail[edge]], surface.points[surface.head[edge]]
    sample = (tail[:, None] + SAMPLES[:, None] * (head - tail)[:, None]).reshape(-1, 3)
    quad = result.quads.quads
    ends = np.sort(np.stack([quad, np.roll(quad, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    first, second = result.quads.points[np.unique(ends, axis=0)].transpose(1, 0, 2)
    away = distance_to(sample, first, second)
    weight = np.repeat(surface.edge_length[edge], len(SAMPLES))
    return f"{np.average(away, weights=weight) / np.linalg.norm(second - first, axis=1).mean():.3f}"


def row(name, points, polygons, settings):
    """The row of the table for one mesh."""
    if points is None:
        return {"mesh": name, "way": f"refused: {polygons}"}
    try:
        result = decompose(points, polygons, settings)
    except CrossfieldError as error:
        return {"mesh": name, "way": f"refused: {error}"}
    quads = result.quads
    return {
        "mesh": name,
        "repairs": " ".join(result.clean.warnings) or "-",
        "way": result.way,
        "singularities": len(result.singularities),
        "blocks": result.blocks.count,
        "quads": len(quads.quads),
        "SJ min / mean": f"{quads.scaled_jacobian.min():.2f} / {quads.scaled_jacobian.mean():.3f}",
        "creases": crease_distance(result, settings),
        "seconds": f"{result.seconds['total']:.1f}",
    }


def main():
    """Run everything and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="*", type=Path)
    parser.add_argument("--primitives", action="store_true", help="Blender's own shapes too")
    parser.add_argument("--quads", type=int, default=5000)
    parser.add_argument("--coarseness", default=Settings().coarseness)
    parser.add_argument("--output", type=Path, help="write the table to this file too")
    arguments = parser.parse_args()
    settings = Settings(quad_count=arguments.quads, coarseness=arguments.coarseness)
    rows = []
    sources = [shared_meshes(arguments.meshes)] + [primitives()] * arguments.primitives
    for source in sources:
        for name, points, polygons in source:
            rows.append(row(name, points, polygons, settings))
            print(" | ".join(str(value) for value in rows[-1].values()), flush=True)
    text = "\n".join(["# Any surface", "", summary(rows, arguments), "", table(rows), ""])
    print("\n" + text)
    if arguments.output:
        arguments.output.write_text(text, encoding="utf-8")


def summary(rows, arguments):
    """What the columns mean, and how many meshes went the first way."""
    done = [r for r in rows if "quads" in r]
    first = sum(r["way"] == "direct" for r in done)
    return (
        f"{first} of {len(done)} meshes came out by the first way ({100 * first / len(done):.0f} %),"
        f" {len(rows) - len(done)} were refused. {arguments.quads} quads wanted, coarseness"
        f" {arguments.coarseness}. Way: see the [guide](guide.md#the-report). SJ: scaled Jacobian. Creases: mean distance"
        " of the creases of the input from the edges of the mesh, in mean edge lengths. Seconds:"
        f" of the report, CPU. Python {platform.python_version()}, NumPy {np.__version__}, one"
        " thread for linear algebra."
    )


if __name__ == "__main__":
    main()
