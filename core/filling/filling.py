"""From four-sided cells to the quad mesh: lengths, connectivity, places, smoothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..blocks.blocks import Blocks, find_blocks
from ..blocks.thin_blocks import thin_as_traced, thin_rows_told
from ..cells.layout import Layout
from ..coarsening.coarsening import coarsen
from ..coarsening.corner_shape import corner_shape
from ..coarsening.drafts import Draft, source_vertices
from ..errors import Cancelled, LayoutError
from ..patience import Patience
from ..quads.cell_maps import map_cells
from ..quads.covering import quads_over_faces
from ..quads.lengths import scale_to_count, solve_lengths
from ..quads.mapping import place_vertices
from ..quads.placement import Placement
from ..quads.quad_mesh import QuadMesh
from ..quads.quads import QuadLayout, verify_lengths
from ..quads.quality import scaled_jacobian
from ..quads.sheets import build_sheets, crease_edges, synchronise, verify_sheets
from ..quads.smoothing import smooth
from ..quads.worst_quads import mend_worst_quads
from ..settings import Settings
from ..surface.surface import TriangleSurface

# Thin cells take a quad each, however small. To come near the wanted number in spite of them, all
# other quads grow, but no more than to wanted lengths of this share: cells of few long quads shear.
LEAST_FACTOR = 0.7
# CPU seconds, and seconds of the clock, that a coarse layout may take before the cells are filled as they are.
COARSE_SECONDS, COARSE_WAITED = 20.0, 45.0
_NO_TIME = "Finding fewer blocks took too long: the blocks are those of the lines as traced."
# Coarse layouts with a worse scaled Jacobian than this, and than this share of what the corners
# allow, are taken only where they have this share of the direct one's, or down to the last where
# that has so many times as many blocks: there it is no layout at all.
LEAST_COARSE, AS_GOOD, MANY_TIMES, LEAST_WITHOUT_CHOICE = 0.35, 0.95, 10, 0.2
_BAD_SHAPES = "Fewer blocks had bad shapes: the blocks are those of the lines as traced."
# Times that the cells are filled, each time with twice as many quads along those with folded ones.
MOST_REFINEMENTS = 3
# Times that arcs are lengthened before a layout counts as too coarse to fill.
MOST_LENGTHENINGS = 8


@dataclass(frozen=True)
class Filling:
    """The quad mesh of a layout.

    quads      QuadMesh
    layout     QuadLayout, its connectivity and where it comes from
    placement  Placement, where its vertices lie on the surface (the whole one, not cut)
    source     (P,) bool, vertices that end the straight lines of blocks: singularities, corners
    face_quad  (F,) int64, quad over the middle of each triangle of the surface, -1 if unknown
    warnings   sentences for the user
    """

    quads: QuadMesh
    layout: QuadLayout
    placement: Placement
    source: np.ndarray
    face_quad: np.ndarray
    warnings: tuple = ()


def fill_cells(surface: TriangleSurface, layout: Layout, settings: Settings, cancelled=None):
    """Fill the cells of a layout with quads of the wanted size or number: a Filling.

    Raises LayoutError where no valid quad mesh of about this size exists, Cancelled.
    """
    coarse, notes = None, ()
    if settings.coarseness != "direct":
        draft, notes = _coarse_draft(surface, layout, settings, cancelled)
        if draft is not None and _is_coarser(surface, layout, settings, draft, cancelled):
            coarse = _fill_coarsely(surface, layout, settings, draft, cancelled)
            if _worst(coarse) >= min(LEAST_COARSE, AS_GOOD * corner_shape(surface, layout)):
                return coarse
            notes = (_BAD_SHAPES,)
    try:
        direct = replace(_fill_directly(surface, layout, settings, cancelled), warnings=notes)
    except LayoutError:
        if coarse is None:
            raise
        return coarse
    if coarse is not None and _is_preferred(coarse, direct):
        return coarse
    if settings.coarseness == "direct":
        return direct
    return _with_thin_blocks(surface, settings, direct, coarse=False)


def _coarse_draft(surface, layout: Layout, settings, cancelled):
    """(Draft or None, sentences): a coarse layout, if one is found in time."""
    patience = Patience(COARSE_SECONDS, cancelled, COARSE_WAITED)
    try:
        return coarsen(surface, layout, settings, patience), ()
    except Cancelled:
        if not patience.ran_out:
            raise
        return None, (_NO_TIME,)


def _worst(filling: Filling) -> float:
    return float(filling.quads.scaled_jacobian.min())


def _is_preferred(coarse: Filling, direct: Filling) -> bool:
    """Is a coarse layout of bad shape taken all the same?"""
    if _worst(coarse) >= AS_GOOD * _worst(direct):
        return True
    few, many = _blocks(coarse).count, _blocks(direct).count
    return _worst(coarse) >= LEAST_WITHOUT_CHOICE and MANY_TIMES * few <= many


def _blocks(filling: Filling) -> Blocks:
    mesh = filling.quads
    return find_blocks(mesh.quads, len(mesh.points), filling.source, mesh.crease)


def _fill_directly(surface, layout: Layout, settings, cancelled) -> Filling:
    """The Filling of the cells as they are; where quads would be inverted, with more of them."""
    lower = np.ones(layout.complex.arc_count, np.int64)
    for _ in range(MOST_REFINEMENTS):
        filling, length = _fill_once(surface, layout, settings, lower, cancelled)
        folded = filling.layout.quad_cell[filling.quads.scaled_jacobian <= 0]
        if not len(folded):
            break
        slot = np.isin(layout.complex.slot_cell, folded)
        arc = np.unique(layout.complex.side_halfarc[slot] // 2)
        lower[arc] = 2 * length[arc]
    return filling


def _fill_once(surface, layout: Layout, settings, lower, cancelled):
    length, quads = _verified_lengths(surface, layout, settings, lower, cancelled)
    mapped = map_cells(layout.complex, layout.cell_mesh, quads.cell_shape, length)
    edge_length = np.sqrt(surface.face_area.sum() / len(quads.quad))
    sheets = build_sheets(layout.gluing, quads, length) if layout.gluing is not None else None
    placement = place_and_smooth(
        surface, layout, quads, length, mapped, sheets, edge_length, cancelled
    )
    face_quad = _quads_over_faces(surface, layout, quads, mapped)
    return _collect(layout, quads, sheets, placement, face_quad, ()), length


def _is_coarser(surface, layout: Layout, settings, coarse: Draft, cancelled) -> bool:
    """Has a coarse layout no more blocks than the direct one?

    The lines of the direct one run on beyond its cells: it has at least as many blocks as cells.
    """
    if coarse.blocks.count <= layout.complex.cell_count:
        return True
    lower, gluing = np.ones(layout.complex.arc_count, np.int64), layout.gluing
    try:
        length, quads = _verified_lengths(surface, layout, settings, lower, cancelled)
    except LayoutError:
        return True
    sheets, crease = None, ()
    if gluing is not None:
        sheets, crease = build_sheets(gluing, quads, length), crease_edges(gluing, quads)
    source = source_vertices(quads, sheets)
    direct = find_blocks(quads.quad, quads.vertex_count, source, crease)
    return coarse.blocks.count <= direct.count


def _fill_coarsely(surface, layout: Layout, settings, draft: Draft, cancelled) -> Filling:
    """The Filling of a coarse layout's fine quads."""
    placement = mend_worst_quads(surface, draft.placement, draft.layout.quad, cancelled)
    face_quad = quads_over_faces(surface, placement, draft.layout.quad)
    if draft.sheets is not None:
        placement = draft.sheets.joined(layout.gluing.charts, placement)
    filling = _collect(layout, draft.quads, draft.sheets, placement, face_quad, ())
    return _with_thin_blocks(surface, settings, filling, coarse=True)


def _with_thin_blocks(surface, settings, filling: Filling, coarse: bool) -> Filling:
    """The Filling with a sentence where blocks are thin; coarse: blocks have been joined."""
    size = settings.edge_length or np.sqrt(surface.face_area.sum() / settings.quad_count)
    mesh, blocks = filling.quads, _blocks(filling)
    if coarse:
        told = thin_rows_told(mesh, filling.placement.fixed, blocks, size)
    else:
        told = thin_as_traced(mesh, blocks, size)
    return replace(filling, warnings=(*filling.warnings, *told))


def _collect(layout, quads: QuadLayout, sheets, placement, face_quad, warnings) -> Filling:
    valence = np.bincount(quads.quad.ravel(), minlength=quads.vertex_count)
    mesh = QuadMesh(
        placement.point, quads.quad, quads.vertex_loop >= 0, valence,
        scaled_jacobian(placement.point, quads.quad),
    )
    if sheets is not None:
        mesh = replace(mesh, crease=crease_edges(layout.gluing, quads))
    source = source_vertices(quads, sheets)
    return Filling(mesh, quads, placement, source, face_quad, warnings)


def place_and_smooth(
    surface, layout: Layout, quads, length, mapped, sheets, edge_length, cancelled
) -> Placement:
    """The vertices of a QuadLayout on the whole surface, smoothed; on charts where it was cut.

    sheets  SheetQuads of the same quads, None where the surface was not cut
    """
    cells, gluing = layout.cell_mesh, layout.gluing
    if gluing is None:
        placement = place_vertices(surface, layout.complex, cells, quads, length, mapped)
        placement = smooth(surface, placement, quads.quad, edge_length, cancelled)
        return mend_worst_quads(surface, placement, quads.quad, cancelled)
    placement = place_vertices(
        surface, gluing.complex, cells, sheets.layout, length[gluing.arc], mapped
    )
    placement = synchronise(gluing.charts, placement, sheets.across)
    placement = smooth(
        surface, placement, sheets.layout.quad, edge_length, cancelled, sheets.across
    )
    placement = mend_worst_quads(surface, placement, sheets.layout.quad, cancelled)
    return sheets.joined(gluing.charts, placement)


def _verified_lengths(surface, layout: Layout, settings, lower, cancelled):
    """Lengths near the wanted size whose quads make the surface, and those quads."""
    complex_, lower = layout.complex, lower.copy()
    for _ in range(MOST_LENGTHENINGS):
        length = _wanted_lengths(surface, complex_, settings, lower, cancelled)
        quads, short = verify_lengths(complex_, length, *layout.topology)
        if layout.gluing is not None and not short.any():
            short = verify_sheets(layout.gluing, length)
        if not short.any():
            return length, quads
        lower[short] = length[short] + 1
    raise LayoutError("The wanted quads are too large for this surface; ask for more of them.")


def _wanted_lengths(surface, complex_, settings, lower, cancelled):
    if settings.edge_length is not None:
        wish = complex_.arc_length / settings.edge_length
        return solve_lengths(complex_, wish, lower, cancelled=cancelled)
    wish = complex_.arc_length / np.sqrt(surface.face_area.sum() / settings.quad_count)
    length, factor = scale_to_count(complex_, wish, settings.quad_count, lower, cancelled)
    if factor >= LEAST_FACTOR:
        return length
    return solve_lengths(complex_, LEAST_FACTOR * wish, lower, cancelled=cancelled)


def _quads_over_faces(surface, layout, quads: QuadLayout, mapped):
    """The quad in whose lattice square the middle of each triangle's largest piece was mapped."""
    place, live = mapped
    mesh = layout.cell_mesh
    cell = mesh.triangle_cell[live]
    m, n = quads.cell_shape[cell].T
    column, row = np.floor(place[mesh.triangle[live]].mean(1)).astype(np.int64).T
    first = np.concatenate([[0], np.cumsum(quads.cell_shape.prod(1))])
    quad = first[cell] + np.clip(row, 0, n - 1) * m + np.clip(column, 0, m - 1)
    corner = mesh.point[mesh.triangle[live]]
    size = np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    result = np.full(surface.face_count, -1, np.int64)
    ascending = np.argsort(size, kind="stable")
    result[mesh.triangle_face[live[ascending]]] = quad[ascending]
    return result
