"""Coloured balls that make the empties at singularities visible.

Blender draws every empty in one colour, so each empty shows an instance of a ball: one collection
for each sign, not linked to any scene, shared by all results of a file.
"""

from __future__ import annotations

import bpy
import numpy as np

from . import palette

_SIGNS = {-1: ("Crossfield k < 0", palette.NEGATIVE), 1: ("Crossfield k > 0", palette.POSITIVE)}


def ball_collection(sign: int):
    """The collection with the ball of radius 1 for one sign of k, made where it is missing."""
    name, colour = _SIGNS[sign]
    collection = bpy.data.collections.get(name)
    if collection is None:
        collection = bpy.data.collections.new(name)
        mesh = bpy.data.meshes.new(name)
        points, quads = ball(1.0)
        mesh.from_pydata(points.tolist(), [], quads.tolist())
        mesh.polygons.foreach_set("use_smooth", np.ones(len(quads), bool))
        mesh.materials.append(palette.material(name.removeprefix("Crossfield "), colour))
        shown = bpy.data.objects.new(name, mesh)
        shown.color = colour
        shown.show_in_front = True
        collection.objects.link(shown)
    return collection


def remove_unused() -> None:
    """Remove the balls that no empty shows any more."""
    for name, _ in _SIGNS.values():
        collection = bpy.data.collections.get(name)
        if collection is not None and not collection.users:
            for shown in list(collection.objects):
                bpy.data.meshes.remove(shown.data)
            bpy.data.collections.remove(collection)


def ball(radius, count=24):
    """Points (n, 3) and quads (m, 4) of a sphere cut by meridians and parallels."""
    around, along = np.arange(count), np.arange(count // 2)[:, None]
    phi = 2 * np.pi * around / count
    theta = np.pi * np.arange(count // 2 + 1)[:, None] / (count // 2)
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    points = radius * np.stack([x, y, np.cos(theta) + 0 * phi], axis=-1).reshape(-1, 3)
    low, following = along * count, (around + 1) % count
    quads = [low + around, low + count + around, low + count + following, low + following]
    return points, np.stack(quads, axis=-1).reshape(-1, 4)
