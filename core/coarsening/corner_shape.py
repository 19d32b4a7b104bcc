"""How good the worst quad of a layout can be: sharp corners allow no better. (method section 8)"""

from __future__ import annotations

import numpy as np

from ..cells.cells import NodeKind
from ..cells.layout import Layout
from ..surface.surface import TriangleSurface


def corner_shape(surface: TriangleSurface, layout: Layout) -> float:
    """The least sine of the angles of quads at corners, each shared out evenly; 1 without corners.

    No mesh of these cells has a better worst scaled Jacobian: sin(angle / number of quads). On
    surfaces cut along feature edges it is 1 too: angles of charts say little of the quads on both
    sides of a cut.
    """
    if layout.gluing is not None:
        return 1.0
    complex = layout.complex
    corner = np.flatnonzero(complex.node_kind == NodeKind.CORNER)
    vertex = surface.triangles[complex.node_face[corner]]
    away = surface.points[vertex] - complex.node_position[corner][:, None]
    nearest = np.linalg.norm(away, axis=2).argmin(1)
    angle = surface.angle_sum[vertex[np.arange(len(corner)), nearest]]
    return float(np.sin(angle / complex.node_valence[corner]).min(initial=1.0))
