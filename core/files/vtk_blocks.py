"""VTK multi-block files: a .vtm that refers to a folder of structured grids (.vts).

The first group, "blocks", holds a grid for each block; the second, "patches", holds for each
boundary patch a group of its block edges. Arrays are 8-byte reals and 4-byte integers in base64,
little-endian.
"""

from __future__ import annotations

from base64 import b64encode
from xml.sax.saxutils import quoteattr

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.t_layout import TLayout
from ..divisions.regridding import block_grid, edge_chain
from ..quads.quads import grid_quads
from .boundary_patches import Patches

_OPEN = '<?xml version="1.0"?>\n<VTKFile type="{}" version="1.0" byte_order="LittleEndian"'
_KINDS = {"f": ("Float64", "<f8"), "i": ("Int32", "<i4")}


def vtk_files(
    points, quads, blocks: Blocks | TLayout, patches: Patches, folder: str, values=None, back=None
):
    """The content of a .vtm, and of the files in its folder: (bytes, dict of name -> bytes).

    points  (P, 3) float64
    quads   (Q, 4) int64
    folder  name of the folder beside the .vtm
    values  name -> (Q,) array, values of the quads besides their block
    back    (P, 3) float64 or None; the second sheet of extruded blocks
    """
    sheets = [points] if back is None else [points, back]
    values = {"block": blocks.quad_block, **(values or {})}
    order = _quads_in_grids(blocks, quads)
    start = np.concatenate([[0], np.cumsum(blocks.shape.prod(1))])
    files, entries = {}, ["  <vtkMultiBlockDataSet>", '    <Block index="0" name="blocks">']
    for block in range(blocks.count):
        grid = np.stack([sheet[block_grid(blocks, block)] for sheet in sheets])
        cells = order[start[block] : start[block + 1]]
        name = f"block_{block:04d}.vts"
        files[name] = _structured(grid, {key: value[cells] for key, value in values.items()})
        entries.append(_entry("      ", block, f"block_{block:04d}", f"{folder}/{name}"))
    entries += ["    </Block>", '    <Block index="1" name="patches">']
    for number, patch in enumerate(patches.name):
        entries.append(f'      <Block index="{number}" name={quoteattr(patch)}>')
        for place, edge in enumerate(np.flatnonzero(patches.edge_patch == number).tolist()):
            line = np.stack([sheet[edge_chain(blocks, edge)][None] for sheet in sheets])
            count = line.shape[2] - 1
            name = f"edge_{edge:04d}.vts"
            files[name] = _structured(line, {
                "edge": np.full(count, edge), "patch": np.full(count, number),
            })
            entries.append(_entry("        ", place, f"edge_{edge:04d}", f"{folder}/{name}"))
        entries.append("      </Block>")
    entries += ["    </Block>", "  </vtkMultiBlockDataSet>", "</VTKFile>", ""]
    head = _OPEN.format("vtkMultiBlockDataSet") + ">"
    return "\n".join([head, *entries]).encode("utf-8"), files


def _quads_in_grids(blocks, quads):
    """(Q,) int64, the quad of each cell of the grids, block after block, row after row."""
    cells, _ = grid_quads(blocks.shape, blocks.grid_offset, blocks.grid_vertex)
    by_vertices = [np.lexsort(np.sort(some, axis=1).T) for some in (cells, quads)]
    result = np.empty(len(quads), np.int64)
    result[by_vertices[0]] = by_vertices[1]
    return result


def _entry(indent, index, name, file):
    return f'{indent}<DataSet index="{index}" name={quoteattr(name)} file={quoteattr(file)}/>'


def _structured(grid, values) -> bytes:
    """A .vts of a grid (k, j, i, 3), with values of its cells."""
    extent = " ".join(f"0 {count - 1}" for count in grid.shape[2::-1])
    return "\n".join([
        _OPEN.format("StructuredGrid") + ' header_type="UInt64">',
        f'  <StructuredGrid WholeExtent="{extent}">',
        f'    <Piece Extent="{extent}">',
        "      <Points>", _array("points", grid.reshape(-1, 3)), "      </Points>",
        "      <CellData>", *(_array(name, value) for name, value in values.items()),
        "      </CellData>",
        "    </Piece>", "  </StructuredGrid>", "</VTKFile>", "",
    ]).encode("ascii")


def _array(name, value):
    kind, code = _KINDS[value.dtype.kind]
    data = np.ascontiguousarray(value, code).tobytes()
    text = b64encode(len(data).to_bytes(8, "little") + data).decode("ascii")
    components = f' NumberOfComponents="{value.shape[1]}"' if value.ndim > 1 else ""
    return f'        <DataArray type="{kind}" Name="{name}"{components} format="binary">{text}</DataArray>'
