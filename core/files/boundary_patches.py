"""Named boundary patches: which block edges belong to which part of the boundary."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..blocks.blocks import Blocks


@dataclass(frozen=True)
class Patches:
    """Boundary patches of a block layout.

    name        list of str, letters, digits and underscores
    edge_patch  (E,) int64, patch of each block edge, -1 inside
    """

    name: list
    edge_patch: np.ndarray


def loop_patches(blocks: Blocks, edge_loop) -> Patches:
    """One patch for each boundary loop, named loop_0, loop_1, ...; edge_loop (E,) int, -1 inside."""
    names = [f"loop_{loop}" for loop in range(int(edge_loop.max(initial=-1)) + 1)]
    return Patches(names, np.asarray(edge_loop, np.int64))


def material_patches(
    blocks: Blocks, edge_loop, vertex_face, face_origin, polygon_material, names
) -> Patches:
    """Patches named by the materials of the polygons along the boundary.

    edge_loop         (E,) int64, boundary loop of each block edge, -1 inside
    vertex_face       (P,) int64, triangle that holds each vertex of the quad mesh
    face_origin       (F,) int64, polygon of each triangle
    polygon_material  (N,) int64, material of each polygon, -1 without
    names             list of str, one for each material

    An edge takes the material of most of its vertices, the first of several. Edges whose polygons
    have no material keep the patch of their loop. With fewer than two materials along the
    boundary the loops tell more, and are the patches.
    """
    loops = loop_patches(blocks, edge_loop)
    material = np.full(len(edge_loop), -1)
    for edge in np.flatnonzero(edge_loop >= 0):
        chain = blocks.edge_vertex[blocks.edge_offset[edge] : blocks.edge_offset[edge + 1]]
        # The ends lie between two edges and may be held by a polygon of the next one.
        inner = chain[1:-1] if len(chain) > 2 else chain
        found = polygon_material[face_origin[vertex_face[inner]]]
        found = found[found >= 0]
        if len(found):
            material[edge] = np.bincount(found).argmax()
    used = np.unique(material[material >= 0])
    if len(used) < 2:
        return loops
    bare = np.unique(edge_loop[(edge_loop >= 0) & (material < 0)])
    patch = np.where(material >= 0, np.searchsorted(used, material), -1)
    without = (edge_loop >= 0) & (material < 0)
    patch[without] = len(used) + np.searchsorted(bare, edge_loop[without])
    wanted = [names[m] for m in used] + [loops.name[loop] for loop in bare]
    return Patches(_distinct(wanted), patch)


def _distinct(names):
    """Names that every format takes, no two alike, none taken by the two sides of an extrusion."""
    taken, result = {"front", "back", "defaultFaces"}, []
    for name in names:
        plain = re.sub(r"\W", "_", name, flags=re.ASCII) or "patch"
        plain = f"_{plain}" if plain[0].isdigit() else plain
        unique, number = plain, 1
        while unique in taken:
            number += 1
            unique = f"{plain}_{number}"
        taken.add(unique)
        result.append(unique)
    return result


def loops_of_material(surface, face_origin, polygon_material, material: int) -> tuple:
    """Numbers of the boundary loops that run along polygons of a material for half their length.

    surface           TriangleSurface
    face_origin       (F,) int64, polygon of each triangle
    polygon_material  (N,) int64
    """
    halfedge = surface.loop_halfedges
    loop = np.repeat(np.arange(surface.loop_count), np.diff(surface.loop_offset))
    length = surface.edge_length[halfedge]
    of_material = polygon_material[face_origin[halfedge // 3]] == material
    share = np.bincount(loop, length * of_material, surface.loop_count)
    whole = np.bincount(loop, length, surface.loop_count)
    return tuple(np.flatnonzero((share > 0) & (share >= 0.5 * whole)).tolist())
