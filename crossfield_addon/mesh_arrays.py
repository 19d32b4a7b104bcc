"""From a Blender object to the arrays that the core takes, always in object space."""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from ..core.errors import InputError
from .marked_edges import marked_edges


@dataclass(frozen=True)
class MeshArrays:
    """A polygon mesh as arrays.

    points         (V, 3) float64, object space
    corner_vertex  (L,) int32, vertex of each polygon corner, polygon after polygon
    polygon_start  (N,) int32, first corner of each polygon
    on_object      True when vertices and polygons are those of the object's own mesh, so that
                   values per vertex and per polygon can be written onto it
    marked_edges   (n, 2) int32, ends of the edges that carry a wanted mark
    """

    points: np.ndarray
    corner_vertex: np.ndarray
    polygon_start: np.ndarray
    on_object: bool
    marked_edges: np.ndarray

    @property
    def polygons(self):
        """(N, 3) or (N, 4) int64 where all polygons are alike, else a list of index lists."""
        size = np.diff(np.append(self.polygon_start, len(self.corner_vertex)))
        if len(size) and size[0] in (3, 4) and (size == size[0]).all():
            return self.corner_vertex.reshape(-1, size[0]).astype(np.int64)
        pieces = np.split(self.corner_vertex, self.polygon_start[1:]) if len(size) else []
        return [piece.tolist() for piece in pieces]


def read_object(context, source, marks=()) -> MeshArrays:
    """The mesh of an object: in edit mode as edited, otherwise with its modifiers applied.

    marks  identifiers of `marked_edges.MARKS` whose edges are wanted

    Raises InputError when the object is not a mesh or has no faces.
    """
    if source is None or source.type != "MESH":
        raise InputError("There is no active mesh object; select the mesh to decompose.")
    if source.mode == "EDIT":
        arrays = _read_edited(source, marks)
    else:
        arrays = _read_evaluated(context, source, marks)
    if not len(arrays.polygon_start):
        raise InputError(
            f"The mesh of {source.name!r} has no faces; Crossfield needs a surface with faces."
        )
    return arrays


def _read_edited(source, marks) -> MeshArrays:
    copy = bpy.data.meshes.new("Crossfield input")
    try:
        bmesh.from_edit_mesh(source.data).to_mesh(copy)
        return MeshArrays(*_mesh_arrays(copy), True, marked_edges(copy, marks))
    finally:
        bpy.data.meshes.remove(copy)


def _read_evaluated(context, source, marks) -> MeshArrays:
    depsgraph = context.evaluated_depsgraph_get()
    evaluated = source.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    try:
        points, corner_vertex, polygon_start = _mesh_arrays(mesh)
        marked = marked_edges(mesh, marks)
    finally:
        evaluated.to_mesh_clear()
    own_points, own_corner_vertex, own_polygon_start = _mesh_arrays(source.data)
    on_object = (
        len(points) == len(own_points)
        and np.array_equal(corner_vertex, own_corner_vertex)
        and np.array_equal(polygon_start, own_polygon_start)
    )
    return MeshArrays(points, corner_vertex, polygon_start, on_object, marked)


def _mesh_arrays(mesh):
    """(points, corner_vertex, polygon_start) of a Mesh that is not being edited."""
    points = np.zeros((len(mesh.vertices), 3), np.float32)
    corner_vertex = np.zeros(len(mesh.loops), np.int32)
    polygon_start = np.zeros(len(mesh.polygons), np.int32)
    if len(points):
        mesh.attributes["position"].data.foreach_get("vector", points.ravel())
    if len(corner_vertex):
        mesh.attributes[".corner_vert"].data.foreach_get("value", corner_vertex)
        mesh.polygons.foreach_get("loop_start", polygon_start)
    return points.astype(np.float64), corner_vertex, polygon_start


def evaluated_arrays(context, source):
    """(points, corner_vertex, polygon_start) of a mesh object as its modifiers leave it.

    In edit mode as it is edited, without modifiers.
    """
    return _from_evaluated(context, source, _mesh_arrays)


def evaluated_materials(context, source):
    """Names of the materials of an object and (N,) int64, the material of each polygon, -1 without.

    The polygons are those that `read_object` reads.
    """
    return _from_evaluated(context, source, lambda mesh: _polygon_materials(source, mesh))


def _from_evaluated(context, source, read):
    if source.mode == "EDIT":
        source.update_from_editmode()
        return read(source.data)
    depsgraph = context.evaluated_depsgraph_get()
    evaluated = source.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    try:
        return read(mesh)
    finally:
        evaluated.to_mesh_clear()


def _polygon_materials(source, mesh):
    index = np.zeros(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("material_index", index)
    slots = [slot.material for slot in source.material_slots]
    names = [material.name if material else "" for material in slots]
    filled = np.array([material is not None for material in slots] + [False])
    index = np.minimum(index, len(slots))
    return names, np.where(filled[index], index, -1).astype(np.int64)
