"""A decomposition as plain arrays to keep in a file, and back again without computing anew.

What comes back can be divided anew and exported; what these do not need (the given mesh, the field,
the cells) is not kept and None.
"""

from __future__ import annotations

import json
from dataclasses import asdict, fields

import numpy as np

from .blocks.blocks import Blocks, verify_blocks
from .blocks.t_layout import verify_t_layout
from .decomposition import Decomposition
from .errors import CrossfieldError, InputError
from .features.charts import Charts
from .field.singularities import Singularities
from .quads.placement import Placement
from .quads.quad_mesh import QuadMesh
from .settings import Settings
from .surface.surface import build_surface

_PARTS = {"blocks": Blocks, "placement": Placement, "quads": QuadMesh}
_BOOLEAN = {"t_edges", "blocks.edge_on_boundary", "placement.fixed", "quads.on_boundary"}


def to_arrays(decomposition: Decomposition) -> dict:
    """The decomposition as a dict of name -> array, float64 or int32, or str; it must have blocks.

    All arrays are flat: file formats know no shapes.
    """
    whole, singular = decomposition.whole, decomposition.singularities
    kept = {
        "settings": json.dumps(asdict(decomposition.settings)),
        "warnings": json.dumps([str(warning) for warning in decomposition.warnings]),
        "way": decomposition.way,
        "surface.points": whole.points,
        "surface.triangles": whole.triangles,
        "surface.polygon": decomposition.face_origin,
        "polygon_index": decomposition.polygon_index,
        "singularities.face": singular.face,
        "singularities.index": singular.index,
        "singularities.position": singular.position,
        "singularities.sums": np.array([singular.index_sum, singular.expected_index_sum]),
    }
    if decomposition.t_edges is not None:
        kept["t_edges"] = decomposition.t_edges
    if decomposition.charts is not None:
        kept["surface.across"] = decomposition.charts.across
    for part, kind in _PARTS.items():
        value = getattr(decomposition, part)
        kept |= {f"{part}.{field.name}": getattr(value, field.name) for field in fields(kind)}
    return {name: value if isinstance(value, str) else _plain(value) for name, value in kept.items()}


def _plain(array):
    array = np.asarray(array)
    return array.astype(np.float64 if array.dtype.kind == "f" else np.int32).ravel()


def from_arrays(kept: dict) -> Decomposition:
    """The reverse of `to_arrays`, arrays in any form that NumPy takes.

    Raises InputError where something is missing or does not fit together.
    """
    try:
        result = _restored(kept)
        verify_blocks(result.blocks, result.quads.quads)
        if result.t_edges is not None:
            verify_t_layout(result.layout, result.quads.quads, result.quads.crease)
    except (KeyError, IndexError, TypeError, ValueError, CrossfieldError):
        raise InputError(
            "The blocks that were kept with these results are damaged; decompose the mesh again."
        ) from None
    return result


def _restored(kept) -> Decomposition:
    known = {field.name for field in fields(Settings)}
    settings = json.loads(kept["settings"])
    settings = Settings(**{name: value for name, value in settings.items() if name in known})
    surface = build_surface(_rows(kept, "surface.points", 3), _rows(kept, "surface.triangles", 3))
    charts = None
    if "surface.across" in kept:
        own = np.arange(surface.vertex_count)
        charts = Charts(surface, surface, own, _rows(kept, "surface.across"))
    sums = _rows(kept, "singularities.sums").tolist()
    singular = Singularities(
        _rows(kept, "singularities.face"), _rows(kept, "singularities.index"),
        _rows(kept, "singularities.position", 3), *sums,
    )
    blocks = _part(kept, "blocks", {"shape": 2, "corner": 4, "block_edge": 4})
    placement = _part(kept, "placement", {"point": 3})
    quads = _part(kept, "quads", {"points": 3, "quads": 4, "crease": 2})
    return Decomposition(
        settings=settings, clean=None, surface=surface,
        face_origin=_rows(kept, "surface.polygon"), distance=None, direction=None, field=None,
        singularities=singular, complex=None, quads=quads, blocks=blocks, placement=placement,
        polygon_index=_rows(kept, "polygon_index"), polygon_block=None, seconds={}, charts=charts, way=str(kept["way"]),
        warnings=json.loads(kept["warnings"]),
        t_edges=_rows(kept, "t_edges") if "t_edges" in kept else None,
    )


def _part(kept, part, columns):
    return _PARTS[part](**{
        field.name: _rows(kept, f"{part}.{field.name}", columns.get(field.name))
        for field in fields(_PARTS[part])
    })


def _rows(kept, name, columns=None):
    """One array, float64, int64 or bool, in rows of so many columns."""
    array = np.asarray(kept[name])
    if name in _BOOLEAN:
        array = array.astype(bool)
    elif array.dtype.kind != "f":
        array = array.astype(np.int64)
    return array if columns is None else array.reshape(-1, columns)
