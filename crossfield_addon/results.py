"""From a Decomposition to what the user sees: one collection of result objects for each input.

The collection remembers its input object by an ID property, so that it is found again after
either of them was renamed. Result objects are children of the input with no transform of their
own: they stand in its place and scale and follow it.
"""

from __future__ import annotations

import bpy
import numpy as np

from . import attributes, markers, palette
from .attributes import AttributeKind, write_attribute

_SOURCE = "crossfield_source"
_SENTENCE = "crossfield_sentence"
_NOTES = "crossfield_notes"
_ROLE = "crossfield_role"
_BLOCK = AttributeKind("INT", "FACE", "value", np.int32, "int")
_QUALITY = AttributeKind("FLOAT", "FACE", "value", np.float32, "float")


def write_results(scene, source, arrays, decomposition, keep_lines=False) -> list[str]:
    """Replace the results of an object by those of a decomposition.

    arrays are the MeshArrays that were decomposed. Returns the notes for the user: warnings of
    the core, and a sentence when the attributes could not be written.
    """
    notes = list(decomposition.warnings)
    obstacle = _obstacle(source, arrays)
    if obstacle:
        notes.append(obstacle)
    else:
        values = attributes.attribute_values(decomposition, len(arrays.points))
        attributes.write_attributes(source, values)
    collection = _empty_collection(scene, source)
    for result in _result_objects(source, decomposition, keep_lines):
        result.parent = source
        result.show_in_front = True
        collection.objects.link(result)
    collection[_SENTENCE] = decomposition.sentence()
    collection[_NOTES] = "\n".join(notes)
    return notes


def _obstacle(source, arrays) -> str:
    """Why the mesh cannot take attributes, or ""; ours from an earlier run are removed then."""
    if not source.data.is_editable:
        return "The mesh is linked from another file, so no attributes were written onto it."
    if arrays.on_object:
        return ""
    attributes.remove_attributes(source)
    return (
        "Modifiers change the faces of this mesh, so no attributes were written onto it; "
        "apply the modifiers to have them."
    )


def remove_results(source) -> bool:
    """Remove the results and attributes of an object; True when there were any."""
    removed = source.data.is_editable and attributes.remove_attributes(source)
    collection = find_collection(source)
    if collection is None:
        return removed
    _remove_objects(collection)
    for key in (_SOURCE, _SENTENCE, _NOTES):
        collection.pop(key, None)
    if not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)
    markers.remove_unused()
    palette.remove_unused()
    return True


def find_collection(source):
    """The collection with the results of an object, or None."""
    for collection in bpy.data.collections:
        if collection.get(_SOURCE) == source:
            return collection
    return None


def result_text(source) -> tuple[str, list[str]]:
    """The sentence on the results of an object and the notes, ("", []) without results."""
    collection = find_collection(source)
    if collection is None:
        return "", []
    return collection.get(_SENTENCE, ""), collection.get(_NOTES, "").splitlines()


def _empty_collection(scene, source):
    """The object's collection of results, linked to the scene, without earlier results."""
    collection = find_collection(source)
    if collection is None:
        collection = bpy.data.collections.new(f"Crossfield {source.name}")
        collection[_SOURCE] = source
    _remove_objects(collection)
    if collection not in scene.collection.children_recursive:
        scene.collection.children.link(collection)
    return collection


def _remove_objects(collection):
    """Remove the result objects and their data; anything else the user put there stays."""
    for result in [o for o in collection.objects if _ROLE in o]:
        data = result.data
        bpy.data.objects.remove(result)
        if data is not None and not data.users:
            pool = bpy.data.meshes if isinstance(data, bpy.types.Mesh) else bpy.data.curves
            pool.remove(data)


def _result_objects(source, decomposition, keep_lines):
    """New, unlinked objects for all that was computed."""
    size = display_size(decomposition)
    results = singularity_empties(source.name, *decomposition.singular_points(), 3 * size)
    complex_, blocks, quads = decomposition.complex, decomposition.blocks, decomposition.quads
    if complex_ is not None and (keep_lines or blocks is None):
        lines = np.split(complex_.arc_point, complex_.arc_offset[1:-1])
        results.append(curve_object(f"{source.name} lines", lines, 0.4 * size, "lines"))
    if blocks is not None:
        chains = np.split(quads.points[blocks.edge_vertex], blocks.edge_offset[1:-1])
        results.append(curve_object(f"{source.name} block boundaries", chains, 0.4 * size, "edges"))
        results.append(quad_object(f"{source.name} quads", quads, blocks))
    return results


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
        empty[_ROLE] = "singularity"
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
    result[_ROLE] = role
    return result


def quad_object(name, quads, blocks):
    """The quad mesh with the face attributes block (INT) and scaled_jacobian (FLOAT).

    Its materials are a small palette in which neighbouring blocks differ.
    """
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(quads.points))
    mesh.vertices.foreach_set("co", quads.points.astype(np.float32).ravel())
    mesh.loops.add(quads.quads.size)
    mesh.loops.foreach_set("vertex_index", quads.quads.astype(np.int32).ravel())
    mesh.polygons.add(len(quads.quads))
    start = np.arange(0, quads.quads.size, 4, dtype=np.int32)
    mesh.polygons.foreach_set("loop_start", start)
    for material in palette.block_materials():
        mesh.materials.append(material)
    shade = palette.block_shades(blocks)[blocks.quad_block]
    mesh.polygons.foreach_set("material_index", shade.astype(np.int32))
    mesh.update(calc_edges=True)
    write_attribute(mesh, "block", _BLOCK, blocks.quad_block)
    write_attribute(mesh, "scaled_jacobian", _QUALITY, quads.scaled_jacobian)
    result = bpy.data.objects.new(name, mesh)
    result.show_wire = True
    result[_ROLE] = "quads"
    return result
