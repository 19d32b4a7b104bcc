"""Numbers of quads written beside the edges of a block mesh while it is being edited."""

from __future__ import annotations

import blf
import bmesh
import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d

from . import results
from .result_objects import FOLLOWS, FREE, LOCKED, ROLE

_SIZE = 12
# Light, to be read on the colours that seams and sharp edges have.
_COLOURS = {
    FREE: (1.0, 1.0, 1.0, 1.0), FOLLOWS: (0.6, 1.0, 1.0, 1.0), LOCKED: (1.0, 0.75, 0.65, 1.0)
}
# With more edges the numbers would cover each other.
_MOST_EDGES = 1000


def add_handler():
    """Start to draw in all 3D viewports; returns what `remove_handler` takes."""
    return bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")


def remove_handler(handler) -> None:
    """Draw no more."""
    bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")


def edge_labels(shown) -> list:
    """(place in the world, text, lock_state) for each edge of a block mesh in edit mode, else [].

    The place is the middle of the curve of the block edge where there is one.
    """
    if shown is None or shown.get(ROLE) != "blocks" or shown.mode != "EDIT":
        return []
    edited = bmesh.from_edit_mesh(shown.data)
    layers = edited.edges.layers.int
    if not all(name in layers for name in ("block_edge", "divisions", "lock_state")):
        return []
    number, count, state = (layers[name] for name in ("block_edge", "divisions", "lock_state"))
    if len(edited.edges) > _MOST_EDGES:
        return []
    curves = _curves(shown, len(edited.edges))
    return [
        (
            shown.matrix_world @ (_middle(curves[edge[number]]) if curves else _centre(edge)),
            str(edge[count]), edge[state],
        )
        for edge in edited.edges
        if not edge.hide
    ]


def _curves(shown, edge_count):
    """The curves of the block edges, or () where they are not there one by one."""
    collection = results.find_collection(shown)
    curve = results.find_object(collection, "edges") if collection is not None else None
    if curve is None or len(curve.data.splines) != edge_count:
        return ()
    return curve.data.splines


def _middle(spline):
    points = spline.points
    return (points[(len(points) - 1) // 2].co + points[len(points) // 2].co).to_3d() / 2


def _centre(edge):
    return (edge.verts[0].co + edge.verts[1].co) / 2


def _draw():
    context = bpy.context
    if not context.space_data.overlay.show_overlays:
        return
    blf.size(0, _SIZE * context.preferences.system.ui_scale)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 3, 0.0, 0.0, 0.0, 1.0)
    for place, text, state in edge_labels(context.object):
        spot = location_3d_to_region_2d(context.region, context.region_data, place)
        if spot is not None:
            width, height = blf.dimensions(0, text)
            blf.color(0, *_COLOURS.get(state, _COLOURS[FREE]))
            blf.position(0, spot.x - width / 2, spot.y - height / 2, 0)
            blf.draw(0, text)
    blf.disable(0, blf.SHADOW)
