"""Grid quality as colours of the quad mesh: one active colour attribute, dark where a quad is bad."""

from __future__ import annotations

import bpy
import numpy as np

from . import palette

ATTRIBUTE = "crossfield_colour"
# Identifier, label and description of what the quads can be coloured by.
MEASURES = (
    ("NONE", "None", "No colour attribute; the materials show the blocks"),
    ("BLOCKS", "Blocks", "A colour for each block, neighbours being different"),
    ("SCALED_JACOBIAN", "Scaled Jacobian", "1 for a rectangle is light, 0 is dark, inverted is red"),
    ("SKEWNESS", "Skewness", "0 for right angles is light, 1 is dark"),
    ("ASPECT_RATIO", "Aspect Ratio", "1 for a square is light, 100 is dark, on a logarithmic scale"),
)
_SHOWN = "crossfield_quality"
_LONGEST = 100.0
_INVERTED = (0.80, 0.02, 0.02)


def shown_measure(collection) -> str:
    """What the quads of a result are coloured by."""
    return collection.get(_SHOWN, "NONE")


def show_measure(collection, quads, measure: str) -> None:
    """Colour the quads of a result, and remember by what."""
    collection[_SHOWN] = measure
    paint(quads.data, measure)


def paint(mesh, measure: str) -> None:
    """Write the colour attribute of a quad mesh (not being edited), or remove it."""
    if ATTRIBUTE in mesh.color_attributes:
        mesh.color_attributes.remove(mesh.color_attributes[ATTRIBUTE])
    if measure == "NONE":
        return
    colour = np.ones((len(mesh.polygons), 4), np.float32)
    colour[:, :3] = face_colours(mesh, measure)
    mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "CORNER")
    size = np.zeros(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", size)
    values = np.repeat(colour, size, axis=0).ravel()
    mesh.color_attributes[ATTRIBUTE].data.foreach_set("color", values)
    mesh.color_attributes.active_color = mesh.color_attributes[ATTRIBUTE]
    mesh.color_attributes.render_color_index = mesh.color_attributes.active_color_index


def face_colours(mesh, measure: str) -> np.ndarray:
    """(F, 3) float64, linear colours of the faces."""
    if measure == "BLOCKS":
        shade = np.zeros(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("material_index", shade)
        return np.array(palette.BLOCKS)[shade % len(palette.BLOCKS), :3]
    value = np.zeros(len(mesh.polygons), np.float32)
    mesh.attributes[measure.lower()].data.foreach_get("value", value)
    colour = palette.ramp(goodness(value, measure))
    if measure == "SCALED_JACOBIAN":
        colour[value <= 0] = _INVERTED
    return colour


def goodness(value, measure: str) -> np.ndarray:
    """Values of a measure on a scale from 0 for bad to 1 for best."""
    if measure == "SKEWNESS":
        value = 1 - value
    elif measure == "ASPECT_RATIO":
        value = 1 - np.log(np.maximum(value, 1)) / np.log(_LONGEST)
    return np.clip(value, 0, 1)


def show_in_viewports(context, measure: str) -> None:
    """Let the solid shading of the 3D viewports show the colour attribute, or materials again."""
    kind = "MATERIAL" if measure == "NONE" else "VERTEX"
    for area in context.screen.areas if context.screen else ():
        for space in area.spaces:
            if isinstance(space, bpy.types.SpaceView3D) and space.shading.color_type in (
                "MATERIAL", "VERTEX",
            ):
                space.shading.color_type = kind
