"""The programs that users would pick instead, one call each: mesh file in, quad mesh out.

Run by run_benchmarks.py in a process of its own:

    python3 rivals.py NAME INPUT.obj WANTED_QUADS OUTPUT.npz

OUTPUT holds points, corners and sizes of the faces, and the CPU seconds spent on importing.
"""

from __future__ import annotations

import sys
import time

import numpy as np


def read_triangles(path):
    """(points (V, 3) float64, triangles (F, 3) int64) of a plain OBJ of triangles."""
    with open(path, encoding="ascii") as file:
        rows = [line.split() for line in file]
    points = np.array([row[1:4] for row in rows if row[:1] == ["v"]], float)
    corners = [[int(c.split("/")[0]) for c in row[1:4]] for row in rows if row[:1] == ["f"]]
    return points, np.array(corners) - 1


def quadriflow(path, wanted):
    """Blender's QuadriFlow, boundaries preserved."""
    import bpy

    yield
    points, triangles = read_triangles(path)
    mesh = bpy.data.meshes.new("input")
    mesh.from_pydata(points.tolist(), [], triangles.tolist())
    shown = bpy.data.objects.new("input", mesh)
    bpy.context.scene.collection.objects.link(shown)
    bpy.context.view_layer.objects.active = shown
    shown.select_set(True)
    done = bpy.ops.object.quadriflow_remesh(
        mode="FACES", target_faces=wanted, use_preserve_boundary=True, use_preserve_sharp=False
    )
    if done != {"FINISHED"}:
        raise RuntimeError("QuadriFlow returned CANCELLED")
    result = shown.data
    yield np.array([v.co for v in result.vertices]), [list(p.vertices) for p in result.polygons]


def instant_meshes(path, wanted):
    """Instant Meshes, pure quads, aligned to boundaries."""
    import pynanoinstantmeshes

    yield
    points, triangles = read_triangles(path)
    points, faces = pynanoinstantmeshes.remesh(
        points.astype(np.float32),
        triangles.astype(np.uint32),
        vertex_count=-1,
        face_count=wanted // 4,  # its pure quads are quarters of the faces that it counts
        align_to_boundaries=True,
    )
    yield np.array(points), [f if f[3] != f[2] else f[:3] for f in np.asarray(faces).tolist()]


def gmsh(path, wanted):
    """gmsh's quasi-structured quads on a parametrisation of the triangles."""
    import gmsh as program

    yield
    points, triangles = read_triangles(path)
    corner = points[triangles]
    area = 0.5 * np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    program.initialize()
    program.option.setNumber("General.Terminal", 0)
    surface = program.model.addDiscreteEntity(2, 1)
    program.model.mesh.addNodes(2, surface, np.arange(1, len(points) + 1), points.ravel())
    program.model.mesh.addElementsByType(surface, 2, [], (triangles + 1).ravel())
    program.model.mesh.classifySurfaces(np.pi / 4, True, True, np.pi)
    program.model.mesh.createGeometry()
    program.option.setNumber("Mesh.Algorithm", 11)
    size = 2 * np.sqrt(area.sum() / wanted)  # it halves every edge in the end
    program.option.setNumber("Mesh.MeshSizeMin", size)
    program.option.setNumber("Mesh.MeshSizeMax", size)
    program.model.mesh.generate(2)
    tags, places, _ = program.model.mesh.getNodes()
    number = np.zeros(int(tags.max()) + 1, np.int64)
    number[tags.astype(np.int64)] = np.arange(len(tags))
    faces = []
    for kind, size in ((2, 3), (3, 4)):
        nodes = program.model.mesh.getElementsByType(kind)[1].astype(np.int64)
        faces += number[nodes].reshape(-1, size).tolist()
    yield places.reshape(-1, 3), faces


RIVALS = {
    "QuadriFlow": ("bpy", quadriflow),
    "Instant Meshes": ("pynanoinstantmeshes", instant_meshes),
    "gmsh": ("gmsh", gmsh),
}


def main(name, path, wanted, output):
    """Run one rival and write what came out."""
    steps = RIVALS[name][1](path, int(wanted))
    before = time.process_time()
    next(steps)
    importing = time.process_time() - before
    points, faces = next(steps)
    np.savez(
        output,
        points=points,
        corners=np.concatenate([np.asarray(f, np.int64) for f in faces]),
        sizes=np.array([len(f) for f in faces]),
        importing=importing,
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
