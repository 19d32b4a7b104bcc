"""The attributes that Crossfield writes onto the user's mesh."""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import numpy as np


@dataclass(frozen=True)
class AttributeKind:
    """How one attribute is stored: Blender's type and domain, its value name, bmesh's layers."""

    type: str
    domain: str
    value: str
    dtype: type
    layers: str


_DIRECTION = AttributeKind("FLOAT_VECTOR", "POINT", "vector", np.float32, "float_vector")
_DISTANCE = AttributeKind("FLOAT", "POINT", "value", np.float32, "float")
_NUMBER = AttributeKind("INT", "FACE", "value", np.int32, "int")

KINDS = {
    "crossfield_direction": _DIRECTION,
    "crossfield_distance": _DISTANCE,
    "crossfield_index": _NUMBER,
    "crossfield_block": _NUMBER,
}


def attribute_values(decomposition, vertex_count) -> dict:
    """Name -> array for the vertices and polygons of the mesh that was decomposed.

    Vertices that no face uses, and those welded into another one, get the direction 0 and the
    distance -1. Without blocks, crossfield_block is left out.
    """
    origin = decomposition.clean.vertex_origin
    direction = np.zeros((vertex_count, 3))
    direction[origin] = decomposition.direction[: len(origin)]
    distance = np.full(vertex_count, -1.0)
    distance[origin] = decomposition.distance[: len(origin)]
    values = {
        "crossfield_direction": direction,
        "crossfield_distance": distance,
        "crossfield_index": decomposition.polygon_index,
    }
    if decomposition.blocks is not None:
        values["crossfield_block"] = decomposition.polygon_block
    return values


def write_attributes(source, values: dict) -> None:
    """Put the named values onto the object's mesh and remove our attributes not among them."""
    remove_attributes(source)
    if source.mode == "EDIT":
        _write_edited(source.data, values)
    else:
        for name, array in values.items():
            write_attribute(source.data, name, KINDS[name], array)


def write_attribute(mesh, name, kind: AttributeKind, array) -> None:
    """Add one attribute to a Mesh that is not being edited."""
    mesh.attributes.new(name, kind.type, kind.domain)
    flat = np.ascontiguousarray(array, kind.dtype).ravel()
    mesh.attributes[name].data.foreach_set(kind.value, flat)


def remove_attributes(source) -> bool:
    """Remove our attributes from the object's mesh; True when there were any."""
    if source.mode == "EDIT":
        return _remove_edited(source.data)
    names = [name for name in KINDS if name in source.data.attributes]
    for name in names:
        source.data.attributes.remove(source.data.attributes[name])
    return bool(names)


def _elements(edited, kind):
    return edited.verts if kind.domain == "POINT" else edited.faces


def _write_edited(mesh, values):
    edited = bmesh.from_edit_mesh(mesh)
    for name, array in values.items():
        kind = KINDS[name]
        elements = _elements(edited, kind)
        layer = getattr(elements.layers, kind.layers).new(name)
        for element, value in zip(elements, np.asarray(array, kind.dtype).tolist(), strict=True):
            element[layer] = value
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)


def _remove_edited(mesh):
    edited = bmesh.from_edit_mesh(mesh)
    removed = False
    for name, kind in KINDS.items():
        layers = getattr(_elements(edited, kind).layers, kind.layers)
        if name in layers:
            layers.remove(layers[name])
            removed = True
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
    return removed
