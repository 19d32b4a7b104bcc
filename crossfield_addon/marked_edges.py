"""Edges that the user has marked on a mesh: what the quad mesh is to keep as chains of edges."""

from __future__ import annotations

import numpy as np

# Identifier, label and description of each kind of mark, as Blender's enumerations want them.
MARKS = (
    ("SHARP", "Sharp", "Edges marked as sharp"),
    ("SEAM", "Seams", "Edges marked as seams"),
    ("CREASE", "Creases", "Edges with a crease weight of at least one half"),
    ("MATERIAL", "Materials", "Edges between faces of different materials"),
)
# Marks that are kept unless others are asked for.
USUAL_MARKS = frozenset({"SHARP"})


def marked_edges(mesh, kinds) -> np.ndarray:
    """(n, 2) int32, ends of the edges of a Mesh (not being edited) that carry a mark.

    kinds  set of identifiers of MARKS
    """
    marked = np.zeros(len(mesh.edges), bool)
    if not len(marked) or not kinds:
        return np.zeros((0, 2), np.int32)
    readers = {"SHARP": _sharp, "SEAM": _seams, "CREASE": _creased, "MATERIAL": _material_borders}
    for kind in kinds:
        marked |= readers[kind](mesh)
    ends = np.zeros((len(mesh.edges), 2), np.int32)
    mesh.attributes[".edge_verts"].data.foreach_get("value", ends.ravel())
    return ends[marked]


def _flag(mesh, name):
    values = np.zeros(len(mesh.edges), bool)
    mesh.edges.foreach_get(name, values)
    return values


def _sharp(mesh):
    return _flag(mesh, "use_edge_sharp")


def _seams(mesh):
    return _flag(mesh, "use_seam")


def _creased(mesh):
    weights = mesh.attributes.get("crease_edge")
    values = np.zeros(len(mesh.edges), np.float32)
    if weights is not None:
        weights.data.foreach_get("value", values)
    return values >= 0.5


def _material_borders(mesh):
    material = np.zeros(len(mesh.polygons), np.int32)
    size = np.zeros(len(mesh.polygons), np.int32)
    edge = np.zeros(len(mesh.loops), np.int32)
    mesh.polygons.foreach_get("material_index", material)
    mesh.polygons.foreach_get("loop_total", size)
    mesh.attributes[".corner_edge"].data.foreach_get("value", edge)
    lowest = np.full(len(mesh.edges), np.iinfo(np.int32).max)
    highest = np.full(len(mesh.edges), -1)
    of_corner = np.repeat(material, size)
    np.minimum.at(lowest, edge, of_corner)
    np.maximum.at(highest, edge, of_corner)
    return lowest < highest
