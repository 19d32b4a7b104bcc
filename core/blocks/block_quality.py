"""Grid quality of blocks: scaled Jacobian, skewness, aspect ratio, as arrays and as a table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..quads.quality import aspect_ratio, skewness
from .blocks import Blocks
from .t_layout import TLayout


@dataclass(frozen=True)
class BlockQuality:
    """Quality of every quad (Q,) and of every block (B,), float64.

    scaled_jacobian       of a quad: the worst of its corners, 1 is a rectangle, below 0 inverted
    skewness              of a quad: largest deviation of a corner from 90 degrees, over 90 degrees
    aspect_ratio          of a quad: longest over shortest edge
    min_scaled_jacobian, mean_scaled_jacobian, max_skewness, max_aspect_ratio   of the blocks
    """

    scaled_jacobian: np.ndarray
    skewness: np.ndarray
    aspect_ratio: np.ndarray
    min_scaled_jacobian: np.ndarray
    mean_scaled_jacobian: np.ndarray
    max_skewness: np.ndarray
    max_aspect_ratio: np.ndarray


def block_quality(points, quads, blocks: Blocks | TLayout, scaled_jacobian) -> BlockQuality:
    """Quality of the quads and blocks; scaled_jacobian (Q,) float64 as the quad mesh has it."""
    skew, aspect = skewness(points, quads), aspect_ratio(points, quads)

    def worst(combine, value, start):
        result = np.full(blocks.count, start)
        combine.at(result, blocks.quad_block, value)
        return result

    total = np.bincount(blocks.quad_block, scaled_jacobian, blocks.count)
    return BlockQuality(
        scaled_jacobian, skew, aspect,
        worst(np.minimum, scaled_jacobian, np.inf),
        total / np.bincount(blocks.quad_block, minlength=blocks.count),
        worst(np.maximum, skew, 0.0), worst(np.maximum, aspect, 1.0),
    )


def quality_rows(blocks: Blocks | TLayout, quality: BlockQuality) -> list:
    """One dict for each block, ready for JSON; None for an aspect ratio that is not finite.

    "edges" are those along its sides, counter-clockwise from the first corner.
    """
    edges = np.split(blocks.side_edge, blocks.side_offset[4:-1:4])
    return [
        {
            "block": block,
            "divisions": blocks.shape[block].tolist(),
            "quads": int(blocks.shape[block].prod()),
            "edges": edges[block].tolist(),
            "min_scaled_jacobian": float(quality.min_scaled_jacobian[block]),
            "mean_scaled_jacobian": float(quality.mean_scaled_jacobian[block]),
            "max_skewness": float(quality.max_skewness[block]),
            "max_aspect_ratio": _finite(quality.max_aspect_ratio[block]),
        }
        for block in range(blocks.count)
    ]


def _finite(value):
    return float(value) if np.isfinite(value) else None


def quality_text(rows: list) -> str:
    """The table for a terminal, one line a block, a heading above and the worst values below."""
    lines = ["block  divisions  quads  min SJ  mean SJ  max skew  max aspect  edges"]
    for row in rows:
        aspect = row["max_aspect_ratio"]
        lines.append(
            f"{row['block']:5d}  {row['divisions'][0]:4d} x{row['divisions'][1]:3d}"
            f"  {row['quads']:5d}  {row['min_scaled_jacobian']:6.3f}"
            f"  {row['mean_scaled_jacobian']:7.3f}  {row['max_skewness']:8.3f}"
            f"  {'inf' if aspect is None else format(aspect, '.1f'):>10}"
            f"  {' '.join(map(str, row['edges']))}"
        )
    aspects = [row["max_aspect_ratio"] for row in rows]
    worst = max((a for a in aspects if a is not None), default=1.0)
    lines.append(
        f"worst             {sum(row['quads'] for row in rows):7d}"
        f"  {min(row['min_scaled_jacobian'] for row in rows):6.3f}           "
        f"{max(row['max_skewness'] for row in rows):8.3f}"
        f"  {'inf' if None in aspects else format(worst, '.1f'):>10}"
    )
    return "\n".join(lines)


def quality_csv(rows: list) -> str:
    """The table for a spreadsheet: a line for each block, lists with spaces between."""
    lines = [",".join(rows[0])]
    for row in rows:
        cells = [" ".join(map(str, c)) if isinstance(c, list) else c for c in row.values()]
        lines.append(",".join("inf" if cell is None else str(cell) for cell in cells))
    return "\n".join(lines) + "\n"
