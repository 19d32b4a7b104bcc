"""How good the worst quad of a surface can be: sharp corners allow no better. (method section 8)"""

from __future__ import annotations

import numpy as np

from ..cells.cells import CellComplex, NodeKind
from ..surface.surface import TriangleSurface


def corner_shape(surface: TriangleSurface, complex: CellComplex) -> float:
    """The least sine of the angles of the quads at the corners, shared out evenly; 1 without corners.

    complex  the cells on the surface. Where it was cut along feature edges, the angles of its charts
             say little of the quads on both sides: ask for whole surfaces only.

    No mesh with these cells has a better worst scaled Jacobian: sin(angle / number of quads).
    """
    corner = np.flatnonzero(complex.node_kind == NodeKind.CORNER)
    vertex = surface.triangles[complex.node_face[corner]]
    away = surface.points[vertex] - complex.node_position[corner][:, None]
    nearest = np.linalg.norm(away, axis=2).argmin(1)
    angle = surface.angle_sum[vertex[np.arange(len(corner)), nearest]]
    return float(np.sin(angle / complex.node_valence[corner]).min(initial=1.0))
