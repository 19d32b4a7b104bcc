"""What a decomposition hands out, and its report in numbers and in words."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .blocks.blocks import Blocks
from .blocks.interfaces import interfaces
from .blocks.t_layout import TLayout, build_t_layout, conforming_edges
from .blocks.thin_blocks import find_thin_rows
from .cells.cells import CellComplex
from .cleaning.cleaning import CleanMesh
from .features.charts import Charts
from .field.cross_field import CrossField
from .field.singularities import Singularities
from .quads.placement import Placement
from .quads.quad_mesh import QuadMesh
from .settings import Settings
from .surface.surface import TriangleSurface


@dataclass(frozen=True)
class Decomposition:
    """All results of one run; later ones are None when the run was to stop before them.

    settings       Settings
    clean          CleanMesh, the given mesh as triangles, with the way back to the user's elements
    surface        TriangleSurface, the working surface, cut along feature edges; its first
                   len(clean.points) vertices are those of `clean`
    face_origin    (F,) int64, the user's polygon of each working triangle
    distance       (V,) float64, arrival distance from the constraints
    direction      (V, 3) float64, one unit direction of the cross at each working vertex
    field          CrossField
    singularities  Singularities
    complex        CellComplex, the four-sided cells between the lines
    quads          QuadMesh
    blocks         Blocks, the base complex of the quad mesh
    placement      Placement, where the vertices of the quad mesh lie on the surface
    polygon_index  (N,) int64, k of each of the user's polygons, 0 where it is not singular
    polygon_block  (N,) int64, block that the middle of each of the user's polygons lies in, or -1
    seconds        CPU seconds of each stage, and their "total"
    warnings       sentences for the user
    charts         Charts, the working surface before and after it was cut; None without features
    way            how the mesh was found, see `ways`: "direct" or what had to stand in for it
    t_edges        (E,) bool, block edges between the blocks of the T-layout; None: blocks conform
    """

    settings: Settings
    clean: CleanMesh
    surface: TriangleSurface
    face_origin: np.ndarray
    distance: np.ndarray
    direction: np.ndarray
    field: CrossField
    singularities: Singularities
    complex: CellComplex | None
    quads: QuadMesh | None
    blocks: Blocks | None
    placement: Placement | None
    polygon_index: np.ndarray
    polygon_block: np.ndarray
    seconds: dict
    warnings: list
    charts: Charts | None = None
    way: str = "direct"
    t_edges: np.ndarray | None = None

    @property
    def whole(self) -> TriangleSurface:
        """The working surface, not cut."""
        return self.surface if self.charts is None else self.charts.whole

    @cached_property
    def layout(self) -> Blocks | TLayout | None:
        """The blocks that were asked for: conforming ones, or joined to the T-layout."""
        if self.t_edges is None:
            return self.blocks
        return build_t_layout(self.quads.quads, self.blocks, self.t_edges)

    def singular_points(self) -> tuple:
        """Where to show the singularities: (position (n, 3) float64, valence (n,) int64).

        With a quad mesh these are its irregular vertices off boundary and creases, which smoothing
        has moved a little from where the field was singular; else, or where they are not the
        field's, the places in the field.
        """
        if self.quads is not None:
            plain = ~self.quads.on_boundary & (self.quads.valence != 4)
            plain[self.quads.crease.ravel()] = False
            valence = self.quads.valence[plain]
            if np.array_equal(np.sort(valence), np.sort(self.singularities.valence)):
                return self.quads.points[plain], valence
        return self.singularities.position, self.singularities.valence

    def report(self) -> dict:
        """The figures of the run as plain numbers, ready for JSON."""
        surface, singular = self.whole, self.singularities
        report = {
            "input": {
                "vertices": len(self.clean.points),
                "triangles": len(self.clean.triangles),
                "euler_characteristic": surface.euler_characteristic,
                "boundary_loops": surface.loop_count,
                "components": surface.component_count,
            },
            "singularities": [
                {"k": int(k), "valence": int(valence), "position": position.tolist()}
                for k, valence, position in zip(singular.k, singular.valence, singular.position)
            ],
            "index_sum": singular.index_sum,
            "expected_index_sum": singular.expected_index_sum,
            "seconds": {stage: round(value, 4) for stage, value in self.seconds.items()},
            "way": self.way,
            "warnings": list(self.warnings),
        }
        if self.complex is not None:
            report["cells"] = {"count": self.complex.cell_count}
        if self.quads is not None:
            report["blocks"] = self._block_report()
            report["thin_rows"] = self._thin_rows()
            report["quads"] = {
                "count": len(self.quads.quads),
                "min_scaled_jacobian": float(self.quads.scaled_jacobian.min()),
                "mean_scaled_jacobian": float(self.quads.scaled_jacobian.mean()),
            }
        return report

    def _block_report(self) -> dict:
        # An unfit layout raises before this point: what is handed out is what it says.
        if self.t_edges is None:
            return {"count": self.blocks.count, "conforming": True}
        return {
            "count": self.layout.count,
            "conforming": False,
            "conforming_count": self.blocks.count,
            "divisions": self.layout.shape.tolist(),
            "t_junctions": self.layout.junction_count,
            "interfaces": [
                join | {"conforming_edges": edges}
                for join, edges in zip(
                    interfaces(self.layout),
                    conforming_edges(self.layout, self.blocks, self.t_edges),
                )
            ],
        }

    def _thin_rows(self) -> list:
        """Rows of conforming blocks with edges below half the wanted length, and what keeps them."""
        size = self.settings.edge_length
        if size is None:
            size = np.sqrt(self.whole.face_area.sum() / self.settings.quad_count)
        rows = find_thin_rows(self.quads, self.placement.fixed, self.blocks, size)
        return [
            {
                "edges": row.edges.tolist(),
                "gap": row.gap,
                "between": self.quads.points[row.ends].tolist(),
                "kept_by": None if row.names is None else list(row.names),
            }
            for row in rows
        ]

    def sentence(self) -> str:
        """The result in words, for a panel or a terminal."""
        count = len(self.singularities)
        balanced = self.singularities.index_sum == self.singularities.expected_index_sum
        parts = [
            f"{_number(count, 'singularity', 'singularities')}, index sum "
            + ("as topology asks" if balanced else "not as topology asks")
        ]
        if self.quads is not None:
            parts.append(_number(self.layout.count, "block", "blocks") + self._manner())
            parts.append(_number(len(self.quads.quads), "quad", "quads"))
        elif self.complex is not None:
            parts.append(_number(self.complex.cell_count, "four-sided cell", "four-sided cells"))
        return "; ".join(parts)

    def _manner(self) -> str:
        if self.t_edges is None:
            return ""
        return f" with T-junctions ({self.blocks.count:,} conforming)"


def _number(count, one, many):
    return f"{count:,} {one if count == 1 else many}"
