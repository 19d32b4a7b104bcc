"""The objects that show a result, new and unlinked; the property `ROLE` tells what each one is.

They are linked by numbers: the quad mesh has the block of each quad and the block edge of each mesh
edge, the block mesh has one quad for each block and one edge for each block edge, and the curve
has one spline for each block edge, in their order.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..core.blocks.block_quality import block_quality
from ..core.blocks.chords import divisions, find_chords, locked_counts
from ..core.divisions.block_mesh import block_mesh
from . import markers, palette
from .attributes import AttributeKind, write_attribute

ROLE = "crossfield_role"
FACE_NUMBER = AttributeKind("INT", "FACE", "value", np.int32, "int")
FACE_VALUE = AttributeKind("FLOAT", "FACE", "value", np.float32, "float")
EDGE_NUMBER = AttributeKind("INT", "EDGE", "value", np.int32, "int")
POINT_NUMBER = AttributeKind("INT", "POINT", "value", np.int32, "int")
# Values of the edge attribute lock_state.
FREE, FOLLOWS, LOCKED = 0, 1, 2


def display_size(decomposition) -> float:
    """Unit of drawn things: a quarter of a usual quad edge, at most 1/300 of the diagonal."""
    largest = float(np.linalg.norm(np.ptp(decomposition.surface.points, axis=0))) / 300
    if decomposition.quads is None:
        return largest
    edge = decomposition.quads.points[decomposition.quads.quads[:, :2]]
    return min(largest, 0.25 * float(np.median(np.linalg.norm(edge[:, 1] - edge[:, 0], axis=1))))


def singularity_empties(name, positions, valences, size) -> list:
    """An empty for each singularity, carrying k and valence; red for k < 0, blue for k > 0."""
    empties = []
    for position, valence in zip(positions, valences.tolist(), strict=True):
        k = valence - 4
        empty = bpy.data.objects.new(f"{name} singularity k={k:+d}", None)
        empty.location = position
        empty.scale = size, size, size
        empty.empty_display_type = "SPHERE"
        empty.instance_type = "COLLECTION"
        empty.instance_collection = markers.ball_collection(-1 if k < 0 else 1)
        empty.color = palette.NEGATIVE if k < 0 else palette.POSITIVE
        empty["k"] = k
        empty["valence"] = valence
        empty[ROLE] = "singularity"
        empties.append(empty)
    return empties


def curve_object(name, chains, radius, role):
    """One POLY curve object; chains is a list of (n, 3) arrays of points."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    curve.bevel_depth = radius
    curve.bevel_resolution = 0
    for chain in chains:
        spline = curve.splines.new("POLY")
        spline.points.add(len(chain) - 1)
        spline.points.foreach_set(
            "co", np.column_stack([chain, np.ones(len(chain))]).astype(np.float32).ravel()
        )
    curve.materials.append(palette.line_material())
    result = bpy.data.objects.new(name, curve)
    result.color = palette.LINE
    result[ROLE] = role
    return result


def boundary_object(name, decomposition, radius, locks=()):
    """The curves of all block edges; those whose divisions are locked have colours of their own.

    Edges of a T-layout are other ones than those that can be locked, and have one colour.
    """
    layout, blocks = decomposition.layout, decomposition.blocks
    chains = np.split(decomposition.quads.points[layout.edge_vertex], layout.edge_offset[1:-1])
    result = curve_object(name, chains, radius, "edges")
    if layout is not blocks:
        return result
    for state in (FOLLOWS, LOCKED):
        result.data.materials.append(palette.lock_material(state == LOCKED))
    for spline, state in zip(result.data.splines, lock_states(blocks, locks).tolist(), strict=True):
        spline.material_index = state
    return result


def lock_states(blocks, locks) -> np.ndarray:
    """(E,) int64: LOCKED edges, those that FOLLOW one of them, FREE ones; locks as pairs."""
    chords = find_chords(blocks)
    held = locked_counts(chords, locks)[chords.edge_chord] > 0
    state = np.where(held, FOLLOWS, FREE)
    state[[edge for edge, _ in locks]] = LOCKED
    return state


def quad_object(name, decomposition):
    """The quad mesh with the number of the block and the quality of each face.

    Its materials are a small palette in which neighbouring blocks differ.
    """
    quads, blocks, layout = decomposition.quads, decomposition.blocks, decomposition.layout
    shade = palette.block_shades(layout)[layout.quad_block]
    mesh = _quad_mesh(name, quads.points, quads.quads, shade)
    write_attribute(mesh, "block", FACE_NUMBER, layout.quad_block)
    quality = block_quality(quads.points, quads.quads, blocks, quads.scaled_jacobian)
    for measure in ("scaled_jacobian", "skewness", "aspect_ratio"):
        write_attribute(mesh, measure, FACE_VALUE, _finite(getattr(quality, measure)))
    first = np.delete(np.arange(len(blocks.edge_vertex)), blocks.edge_offset[1:] - 1)
    steps = np.stack([blocks.edge_vertex[first], blocks.edge_vertex[first + 1]], axis=1)
    number = np.repeat(np.arange(len(blocks.edge_on_boundary)), divisions(blocks))
    write_attribute(mesh, "block_edge", EDGE_NUMBER, edge_numbers(mesh, steps, number))
    result = bpy.data.objects.new(name, mesh)
    result.show_wire = True
    result[ROLE] = "quads"
    return result


def block_object(name, decomposition, locks=()):
    """The coarse block mesh: a quad for each block, with its quality, divisions and locks.

    Blocks of a T-layout are several faces, the face attribute `block` having their number.
    """
    quads, blocks, layout = decomposition.quads, decomposition.blocks, decomposition.layout
    coarse = block_mesh(quads.points, blocks)
    block = np.arange(blocks.count)
    if layout is not blocks:
        block[blocks.quad_block] = layout.quad_block
    mesh = _quad_mesh(name, coarse.points, coarse.quads, palette.block_shades(layout)[block])
    write_attribute(mesh, "vertex", POINT_NUMBER, coarse.vertex)
    write_attribute(mesh, "block", FACE_NUMBER, block)
    write_attribute(mesh, "face", FACE_NUMBER, np.arange(blocks.count))
    number = edge_numbers(mesh, coarse.edges, np.arange(len(coarse.edges)))
    write_attribute(mesh, "block_edge", EDGE_NUMBER, number)
    write_attribute(mesh, "chord", EDGE_NUMBER, coarse.edge_chord[number])
    for attribute in ("divisions", "lock", "lock_state"):
        write_attribute(mesh, attribute, EDGE_NUMBER, np.zeros(len(number)))
    for measure in _BLOCK_MEASURES:
        write_attribute(mesh, measure, FACE_VALUE, np.zeros(blocks.count))
    write_divisions(mesh, quads, blocks, locks)
    result = bpy.data.objects.new(name, mesh)
    result.display_type = "WIRE"
    result.hide_render = True  # it lies in the quads
    result[ROLE] = "blocks"
    return result


_BLOCK_MEASURES = "min_scaled_jacobian", "mean_scaled_jacobian", "max_skewness", "max_aspect_ratio"


def write_divisions(mesh, quads, blocks, locks) -> None:
    """Put divisions, locks and qualities onto a block mesh that was made by `block_object`.

    In edit mode Blender shows seams in red and sharp edges in blue: locked edges, and those that
    follow them. Edges and faces that the user has added are left alone.
    """
    edge, block = read_numbers(mesh, "EDGE", "block_edge"), read_numbers(mesh, "FACE", "face")
    count = np.zeros(len(blocks.edge_on_boundary), np.int64)
    count[[e for e, _ in locks]] = [n for _, n in locks]
    state = lock_states(blocks, locks)
    for name, value in (("divisions", divisions(blocks)), ("lock", count), ("lock_state", state)):
        mesh.attributes[name].data.foreach_set("value", value[edge].astype(np.int32))
    mesh.edges.foreach_set("use_seam", state[edge] == LOCKED)
    mesh.edges.foreach_set("use_edge_sharp", state[edge] == FOLLOWS)
    quality = block_quality(quads.points, quads.quads, blocks, quads.scaled_jacobian)
    for name in _BLOCK_MEASURES:
        value = _finite(getattr(quality, name))[block]
        mesh.attributes[name].data.foreach_set("value", value.astype(np.float32))
    mesh.update()


def read_numbers(mesh, domain, name) -> np.ndarray:
    """(n,) int64, an INT attribute of a mesh that is not being edited."""
    size = len(mesh.edges if domain == "EDGE" else mesh.polygons)
    values = np.zeros(size, np.int32)
    if size:
        mesh.attributes[name].data.foreach_get("value", values)
    return values.astype(np.int64)


def edge_numbers(mesh, pairs, number) -> np.ndarray:
    """(edges,) int64 of a mesh: the number of the pair of vertices that each edge joins, or -1.

    pairs (n, 2) int, no two of them joining the same vertices; number (n,) int
    """
    ends = np.zeros((len(mesh.edges), 2), np.int32)
    mesh.attributes[".edge_verts"].data.foreach_get("value", ends.ravel())
    span = np.array([len(mesh.vertices), 1])
    key, wanted = np.sort(ends.astype(np.int64), axis=1) @ span, np.sort(pairs, axis=1) @ span
    order = np.argsort(wanted)
    place = np.minimum(np.searchsorted(wanted[order], key), len(wanted) - 1)
    return np.where(wanted[order[place]] == key, np.asarray(number)[order[place]], -1)


def _quad_mesh(name, points, quads, shade):
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.astype(np.int32).ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    for material in palette.block_materials():
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", shade.astype(np.int32))
    mesh.update(calc_edges=True)
    for elements in (mesh.vertices, mesh.edges, mesh.polygons):
        elements.foreach_set("select", np.zeros(len(elements), bool))
    return mesh


def _finite(values):
    """Values that Blender can show: an edge without length makes an aspect ratio infinite."""
    return np.minimum(values, np.finfo(np.float32).max)
