"""Colours of the results: sRGB-free linear values that Blender takes as they are."""

from __future__ import annotations

import bpy
import numpy as np

NEGATIVE = (0.80, 0.05, 0.04, 1.0)
POSITIVE = (0.03, 0.17, 0.80, 1.0)
LINE = (0.010, 0.014, 0.024, 1.0)
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


def block_shades(blocks) -> np.ndarray:
    """(B,) int64 into `BLOCKS`, blocks that share a side having different shades.

    Greedy over the blocks, the least used free shade first; a block has few neighbours, and
    when all shades are taken a neighbour's is repeated.
    """
    edge_count = len(blocks.edge_on_boundary)
    sides = [[] for _ in range(edge_count)]
    for block, edges in enumerate(blocks.block_edge.tolist()):
        for edge in edges:
            sides[edge].append(block)
    shade = np.full(blocks.count, -1)
    used = np.zeros(len(BLOCKS), int)
    for block, edges in enumerate(blocks.block_edge.tolist()):
        taken = {shade[other] for edge in edges for other in sides[edge]}
        free = [s for s in range(len(BLOCKS)) if s not in taken] or range(len(BLOCKS))
        shade[block] = min(free, key=lambda s: used[s])
        used[shade[block]] += 1
    return shade
