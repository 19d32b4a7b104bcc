"""Pictures of a decomposition, rendered by Blender's Workbench without a window.

Works in a scene of its own in the open file and removes it afterwards.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from . import markers, palette, result_objects
from .blend_files import quiet

LAYERS = ("surface", "distance", "field", "lines", "quads", "blocks", "singularities")
_PAPER = (1.0, 1.0, 1.0)
_SURFACE = (0.80, 0.82, 0.85, 1.0)
_CROSS = (0.10, 0.28, 0.42, 1.0)
_WIRE = (0.20, 0.22, 0.26, 1.0)


def render_picture(
    path: Path,
    decomposition,
    layers=("quads", "blocks", "singularities"),
    pixels=1600,
    window=None,
    weight=1.0,
) -> None:
    """Write a PNG of some of `LAYERS`, the longer side of the picture having `pixels`.

    weight scales the thickness of lines, crosses and balls.

    The camera looks along the mean normal of the surface, without perspective. window is None for
    the whole surface, or (low, high), two corners (2,) in the picture's plane, in lengths to the
    right and up from the origin.
    """
    scene = bpy.data.scenes.new("Crossfield picture")
    objects = []
    try:
        view = _view_axes(decomposition.surface)
        low, high = window or _extent(decomposition.surface, view)
        size = np.subtract(high, low)
        objects = _layer_objects(decomposition, layers, weight * size.max() / 1600)
        objects.append(_camera(decomposition.surface, view, np.add(low, high) / 2, size))
        for shown in objects:
            scene.collection.objects.link(shown)
        scene.camera = objects[-1]
        _set_up_render(scene, path, size, pixels, flat=_is_flat(decomposition.surface))
        with quiet():
            bpy.ops.render.render(write_still=True, scene=scene.name)
    finally:
        _remove(scene, objects)


def _view_axes(surface):
    """(3, 3), rows right, up and towards the viewer."""
    normal = (surface.face_normal * surface.face_area[:, None]).sum(0)
    length = np.linalg.norm(normal)
    towards = normal / length if length > 1e-6 * surface.face_area.sum() else np.array([0, 0, 1.0])
    up = np.array([0, 1.0, 0]) if abs(towards[2]) > 0.9 else np.array([0, 0, 1.0])
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def _extent(surface, view):
    """Low and high corner of the surface in the picture's plane, with a margin."""
    seen = surface.points @ view[:2].T
    margin = 0.02 * np.ptp(seen, axis=0).max()
    return seen.min(0) - margin, seen.max(0) + margin


def _is_flat(surface):
    depth = surface.points @ surface.face_normal[0]
    return np.ptp(depth) < 1e-3 * np.linalg.norm(np.ptp(surface.points, axis=0))


def _layer_objects(decomposition, layers, pixel):
    """The objects of the wanted layers; `pixel` is the length of one pixel at 1600 pixels."""
    objects = []
    if "surface" in layers:
        objects += _surface_objects(decomposition.surface, pixel)
    if "distance" in layers:
        lines = contours(decomposition.surface, decomposition.distance)
        curve = result_objects.curve_object("distance", lines, 1.2 * pixel, "distance")
        objects.append(_painted(curve, _CROSS))
    if "field" in layers:
        crosses = cross_segments(decomposition, 26 * pixel)
        curve = result_objects.curve_object("field", crosses, 1.0 * pixel, "field")
        objects.append(_painted(curve, _CROSS))
    if "lines" in layers:
        complex_ = decomposition.complex
        lines = np.split(complex_.arc_point, complex_.arc_offset[1:-1])
        objects.append(result_objects.curve_object("lines", lines, 2.0 * pixel, "lines"))
    if "quads" in layers:
        objects += _quad_objects(decomposition, pixel)
    if "blocks" in layers:
        blocks, points = decomposition.layout, decomposition.quads.points
        chains = np.split(points[blocks.edge_vertex], blocks.edge_offset[1:-1])
        objects.append(result_objects.curve_object("blocks", chains, 1.8 * pixel, "edges"))
    if "singularities" in layers:
        objects += _markers(*_singular_points(decomposition, layers), 9 * pixel)
    return objects


def _surface_objects(surface, pixel):
    """The working surface and its boundary."""
    mesh = bpy.data.meshes.new("surface")
    mesh.from_pydata(surface.points.tolist(), [], surface.triangles.tolist())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    rim = result_objects.curve_object("rim", _rim(surface), 1.6 * pixel, "rim")
    return [_painted(mesh, _SURFACE), _painted(rim, palette.LINE)]


def contours(surface, values, count=24) -> list:
    """Segments, as (2, 3) arrays of points, where values per vertex pass `count` even levels."""
    top = values.max() * (1 + 1e-9) + 1e-300
    level = count * values[surface.triangles] / top
    segments = []
    for wanted in np.arange(0.5, count):
        above = level > wanted
        mixed = np.flatnonzero(above.any(1) & ~above.all(1))
        alone = np.where(above[mixed].sum(1) == 1, above[mixed].argmax(1), above[mixed].argmin(1))
        corner = surface.points[surface.triangles[mixed]]
        row = np.arange(len(mixed))
        ends = []
        for step in (1, 2):
            other = (alone + step) % 3
            near, far = level[mixed][row, alone], level[mixed][row, other]
            share = ((wanted - near) / (far - near))[:, None]
            ends.append(corner[row, alone] * (1 - share) + corner[row, other] * share)
        segments += list(np.stack(ends, axis=1))
    return segments


def _quad_objects(decomposition, pixel):
    quads = result_objects.quad_object("quads", decomposition)
    wire = bpy.data.objects.new("wire", quads.data.copy())
    wire.data.materials.clear()
    wire.data.materials.append(_paint(_WIRE))
    wire.data.polygons.foreach_set("material_index", np.zeros(len(wire.data.polygons), np.int32))
    modifier = wire.modifiers.new("wire", "WIREFRAME")
    modifier.thickness = 1.1 * pixel
    modifier.offset = 0.0
    return [quads, wire]


def _singular_points(decomposition, layers):
    """Singularities as the picture shows them: in the quads, or where the field has them."""
    if "quads" in layers:
        return decomposition.singular_points()
    return decomposition.singularities.position, decomposition.singularities.valence


def _markers(positions, valences, radius):
    """A ball at each singularity: red for k < 0, blue for k > 0."""
    shown = []
    for colour, chosen in (
        (palette.NEGATIVE, valences < 4),
        (palette.POSITIVE, valences > 4),
    ):
        ball = bpy.data.meshes.new("ball")
        points, faces = markers.ball(radius)
        centre = np.asarray(positions)[chosen]
        every = (centre[:, None, :] + points).reshape(-1, 3)
        shift = len(points) * np.arange(len(centre))[:, None, None]
        ball.from_pydata(every.tolist(), [], (faces + shift).reshape(-1, 4).tolist())
        shown.append(_painted(ball, colour))
    return shown


def cross_segments(decomposition, spacing) -> list:
    """Two crossing segments at inner vertices about `spacing` apart, as (2, 3) arrays of points.

    Of each cell of a lattice, the vertex nearest to its centre is taken.
    """
    surface = decomposition.surface
    inner = np.flatnonzero(~surface.on_boundary)
    cell = np.floor(surface.points[inner] / spacing)
    off_centre = np.linalg.norm(surface.points[inner] / spacing - cell - 0.5, axis=1)
    inner, cell = inner[np.argsort(off_centre)], cell[np.argsort(off_centre)]
    chosen = inner[np.unique(cell, axis=0, return_index=True)[1]]
    normal = np.zeros_like(surface.points)
    for corner in range(3):
        weighted = surface.face_normal * surface.face_area[:, None]
        np.add.at(normal, surface.triangles[:, corner], weighted)
    normal = normal[chosen] / np.linalg.norm(normal[chosen], axis=1, keepdims=True)
    first = 0.42 * spacing * decomposition.direction[chosen]
    second = np.cross(normal, first)
    centre = surface.points[chosen]
    return [
        np.array([c - arm, c + arm])
        for c, pair in zip(centre, np.stack([first, second], axis=1), strict=True)
        for arm in pair
    ]


def _rim(surface):
    """The boundary loops as closed chains of points."""
    chains = np.split(surface.tail[surface.loop_halfedges], surface.loop_offset[1:-1])
    return [surface.points[np.append(chain, chain[:1])] for chain in chains if len(chain)]


def _paint(colour):
    material = bpy.data.materials.new("picture")
    material.diffuse_color = colour
    return material


def _painted(thing, colour):
    """An object of this colour, from a mesh or from an object."""
    shown = thing if isinstance(thing, bpy.types.Object) else bpy.data.objects.new("part", thing)
    shown.data.materials.clear()
    shown.data.materials.append(_paint(colour))
    return shown


def _camera(surface, view, centre, size):
    camera = bpy.data.cameras.new("picture")
    camera.type = "ORTHO"
    camera.ortho_scale = size.max()
    diagonal = np.linalg.norm(np.ptp(surface.points, axis=0))
    camera.clip_start, camera.clip_end = 1e-3 * diagonal, 10 * diagonal
    shown = bpy.data.objects.new("picture", camera)
    height = (surface.points @ view[2]).max() + diagonal
    matrix = np.eye(4)
    matrix[:3, :3] = view.T
    matrix[:3, 3] = np.append(centre, height) @ view
    shown.matrix_world = Matrix(matrix.tolist())
    return shown


def _set_up_render(scene, path, size, pixels, flat):
    render = scene.render
    render.engine = "BLENDER_WORKBENCH"
    shape = np.ceil(size / size.max() * pixels).astype(int).tolist()
    render.resolution_x, render.resolution_y = shape
    render.resolution_percentage = 100
    render.dither_intensity = 0.0  # flat colours stay flat, and the file small
    render.image_settings.file_format = "PNG"
    render.image_settings.color_mode = "RGB"
    render.image_settings.compression = 100
    render.filepath = str(path)
    scene.view_settings.view_transform = "Standard"
    scene.view_settings.exposure = 0.0 if flat else 0.6
    scene.world = bpy.data.worlds.new("picture")
    scene.world.color = _PAPER
    shading = scene.display.shading
    shading.light = "FLAT" if flat else "STUDIO"
    shading.color_type = "MATERIAL"
    scene.display.render_aa = "16"


def _remove(scene, objects):
    data = [shown.data for shown in objects]
    world = scene.world
    for shown in objects:
        bpy.data.objects.remove(shown)
    bpy.data.batch_remove([d for d in data if not d.users] + ([world] if world else []))
    bpy.data.batch_remove([m for m in bpy.data.materials if m.name.startswith("picture")])
    bpy.data.scenes.remove(scene)
    palette.remove_unused()
