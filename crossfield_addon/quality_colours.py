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
    ("SCALED_JACOBIAN", "Scaled Jacobian", "Light where quads are rectangles; inverted ones are red"),
    ("SKEWNESS", "Skewness", "Light where all corners are right angles"),
    ("ASPECT_RATIO", "Aspect Ratio", "Light where quads are squares, on a logarithmic scale"),
)
# Values that are dark and light on the full range.
_FULL_RANGE = {"SCALED_JACOBIAN": (0.0, 1.0), "SKEWNESS": (1.0, 0.0), "ASPECT_RATIO": (100.0, 1.0)}
_SHOWN, _FITTED, _RANGE = "crossfield_quality", "crossfield_fit_range", "crossfield_range"
_INVERTED = (0.80, 0.02, 0.02)


def shown_measure(collection) -> str:
    """What the quads of a result are coloured by."""
    return collection.get(_SHOWN, "NONE")


def shown_range(collection) -> tuple:
    """The values shown dark and light, () where the colours mean no values."""
    return tuple(collection.get(_RANGE, ()))


def show_measure(collection, quads, measure: str, fit_range: bool) -> None:
    """Colour the quads of a result, and remember by what.

    fit_range  True: dark is the worst quad of this mesh; False: dark is as bad as can be, an aspect
               ratio of 100
    """
    collection[_SHOWN], collection[_FITTED] = measure, fit_range
    paint_again(collection, quads)


def paint_again(collection, quads) -> None:
    """Colour new quads of a result as those before them."""
    mesh, measure = quads.data, shown_measure(collection)
    if ATTRIBUTE in mesh.color_attributes:
        mesh.color_attributes.remove(mesh.color_attributes[ATTRIBUTE])
    collection[_RANGE] = []
    if measure == "NONE":
        return
    if measure == "BLOCKS":
        _paint(mesh, _block_colours(mesh))
        return
    value = np.zeros(len(mesh.polygons), np.float32)
    mesh.attributes[measure.lower()].data.foreach_get("value", value)
    worst, best = _FULL_RANGE[measure]
    if collection[_FITTED] and len(value):
        worst = float(value.min() if measure == "SCALED_JACOBIAN" else value.max())
        worst = max(worst, 0.0)
    collection[_RANGE] = [worst, best]
    _paint(mesh, value_colours(value, measure, worst, best))


def _paint(mesh, colour):
    mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "CORNER")
    size = np.zeros(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", size)
    opaque = np.column_stack([colour, np.ones(len(colour))]).astype(np.float32)
    values = np.repeat(opaque, size, axis=0).ravel()
    mesh.color_attributes[ATTRIBUTE].data.foreach_set("color", values)
    mesh.color_attributes.active_color = mesh.color_attributes[ATTRIBUTE]
    mesh.color_attributes.render_color_index = mesh.color_attributes.active_color_index


def _block_colours(mesh):
    shade = np.zeros(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("material_index", shade)
    return np.array(palette.BLOCKS)[shade % len(palette.BLOCKS), :3]


def value_colours(value, measure: str, worst: float, best: float) -> np.ndarray:
    """(F, 3) float64, linear colours of the values (F,) of a measure."""
    inverted = value <= 0
    if measure == "ASPECT_RATIO":
        value, worst, best = np.log(np.maximum(value, 1.0)), np.log(max(worst, 1.0)), np.log(best)
    span = best - worst
    colour = palette.ramp((value - worst) / span if span else np.ones(len(value)))
    if measure == "SCALED_JACOBIAN":
        colour[inverted] = _INVERTED
    return colour


def show_in_viewports(context, measure: str) -> None:
    """Let the solid shading of the 3D viewports show the colour attribute, or materials again."""
    kind = "MATERIAL" if measure == "NONE" else "VERTEX"
    for area in context.screen.areas if context.screen else ():
        for space in area.spaces:
            if isinstance(space, bpy.types.SpaceView3D) and space.shading.color_type in (
                "MATERIAL", "VERTEX",
            ):
                space.shading.color_type = kind
