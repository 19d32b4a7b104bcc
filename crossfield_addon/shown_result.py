"""A result of the open file as a Decomposition again, as the user sees it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..core.errors import InputError
from ..core.quads.quality import scaled_jacobian
from . import kept_blocks, results
from .mesh_arrays import evaluated_arrays, evaluated_materials


def divided(collection):
    """(computed Decomposition, WantedDivisions, Decomposition divided so) of a result.

    The block mesh must not be in edit mode. Raises InputError where what was kept is damaged.
    """
    mesh = results.find_object(collection, "blocks").data
    computed, wanted = kept_blocks.kept_decomposition(mesh), kept_blocks.wanted_divisions(mesh)
    return computed, wanted, wanted.divide(computed)


def shown_decomposition(context, collection, in_world=False):
    """The decomposition with the vertices of the quad mesh where the user sees them.

    in_world  True for points in the world, else in object space

    Vertices that were not moved by hand or by modifiers have the exact coordinates that were computed.
    Raises InputError where the faces of the quad mesh are no longer those of the blocks.
    """
    decomposition = divided(collection)[2]
    points = decomposition.quads.points
    quads = results.find_object(collection, "quads")
    if quads is not None:
        points = _seen(context, quads, decomposition.quads)
    if in_world:
        points = _in_world(points, quads or results.find_object(collection, "blocks"))
    if points is decomposition.quads.points:
        return decomposition
    shape = scaled_jacobian(points, decomposition.quads.quads)
    return replace(
        decomposition, quads=replace(decomposition.quads, points=points, scaled_jacobian=shape)
    )


def _seen(context, shown, computed):
    points, corner_vertex, _ = evaluated_arrays(context, shown)
    if len(points) != len(computed.points) or not np.array_equal(
        corner_vertex, computed.quads.ravel()
    ):
        raise InputError(
            f"The faces of {shown.name!r} were changed by hand or by modifiers and are no longer those"
            " of the blocks; undo that or regrid the blocks."
        )
    moved = (points.astype(np.float32) != computed.points.astype(np.float32)).any(1)
    return np.where(moved[:, None], points, computed.points) if moved.any() else computed.points


def _in_world(points, shown):
    matrix = np.array(shown.matrix_world, np.float64)
    if np.array_equal(matrix, np.eye(4)):
        return points
    if np.linalg.det(matrix[:3, :3]) <= 0:
        raise InputError(
            f"{shown.name!r} is mirrored or flattened by its scale; apply the scale, or leave out"
            " the transform."
        )
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def materials(context, collection, polygon_count):
    """Names and (N,) material of the polygons that were decomposed; ([], None) if not known."""
    source = results.source_of(collection)
    if source is None or source.type != "MESH":
        return [], None
    names, material = evaluated_materials(context, source)
    return (names, material) if len(material) == polygon_count else ([], None)
