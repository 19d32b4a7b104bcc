"""Colours of the results: sRGB-free linear values that Blender takes as they are."""

from __future__ import annotations

import bpy
import numpy as np

NEGATIVE = (0.80, 0.05, 0.04, 1.0)
POSITIVE = (0.03, 0.17, 0.80, 1.0)
LINE = (0.010, 0.014, 0.024, 1.0)
LOCKED = (0.90, 0.10, 0.03, 1.0)
FOLLOWS = (0.95, 0.42, 0.05, 1.0)
BLOCKS = (
    (0.49, 0.66, 0.83, 1.0),
    (0.89, 0.72, 0.42, 1.0),
    (0.53, 0.75, 0.53, 1.0),
    (0.85, 0.56, 0.53, 1.0),
    (0.66, 0.58, 0.80, 1.0),
    (0.50, 0.75, 0.75, 1.0),
    (0.87, 0.80, 0.58, 1.0),
    (0.76, 0.76, 0.78, 1.0),
)
_PREFIX = "Crossfield "


def block_materials() -> list:
    """One material for each shade of `BLOCKS`, shared by all results."""
    return [material(f"block {k + 1}", colour) for k, colour in enumerate(BLOCKS)]


def line_material():
    """The material of block boundaries and lines."""
    return material("line", LINE)


def lock_material(locked: bool):
    """The material of block edges with locked divisions, or of those that must follow them."""
    return material("locked", LOCKED) if locked else material("follows a lock", FOLLOWS)


def remove_unused() -> None:
    """Remove our materials when no result uses them any more."""
    for unused in [m for m in bpy.data.materials if not m.users]:
        if unused.name.startswith(_PREFIX):
            bpy.data.materials.remove(unused)


def material(name, colour):
    """The shared material of this name, made where it is missing."""
    found = bpy.data.materials.get(_PREFIX + name)
    if found is None:
        found = bpy.data.materials.new(_PREFIX + name)
        found.diffuse_color = colour
    return found


def ramp(value) -> np.ndarray:
    """(n, 3) float64, linear colours from dark violet at 0 over green to light yellow at 1.

    Lightness rises evenly, so that equal steps of the value look like equal steps, also without
    seeing colours: a line through Oklab from hue 300 to hue 105 degrees (Ottosson 2020).
    """
    value = np.clip(np.asarray(value, np.float64), 0, 1)
    lightness = 0.25 + 0.70 * value
    hue = np.radians(300 - 195 * value)
    chroma = 0.095 + 0.035 * (2 * value - 1) ** 2  # as much as sRGB can show on the way
    a, b = chroma * np.cos(hue), chroma * np.sin(hue)
    long = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3
    medium = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3
    short = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3
    linear = np.stack([
        4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * medium + 1.7076147010 * short,
    ], axis=-1)
    return np.clip(linear, 0, 1)


def block_shades(blocks) -> np.ndarray:
    """(B,) int64 into `BLOCKS`, blocks that share a side having different shades.

    Greedy over the blocks, the least used free shade first; a block has few neighbours, and
    when all shades are taken a neighbour's is repeated.
    """
    edges_of = [e.tolist() for e in np.split(blocks.side_edge, blocks.side_offset[4:-1:4])]
    sides = [[] for _ in range(len(blocks.edge_on_boundary))]
    for block, edges in enumerate(edges_of):
        for edge in edges:
            sides[edge].append(block)
    shade = np.full(blocks.count, -1)
    used = np.zeros(len(BLOCKS), int)
    for block, edges in enumerate(edges_of):
        taken = {shade[other] for edge in edges for other in sides[edge]}
        free = [s for s in range(len(BLOCKS)) if s not in taken] or range(len(BLOCKS))
        shade[block] = min(free, key=lambda s: used[s])
        used[shade[block]] += 1
    return shade
