"""Blocks with T-junctions inside Blender."""

from tests.addon.blender_process import in_blender


@in_blender
def test_an_l_shape_is_two_blocks():
    import tempfile
    from pathlib import Path

    import bpy
    import numpy as np

    from tests.addon.scenes import add_mesh, result, values_of

    x, y = np.meshgrid(np.arange(9.0), np.arange(9.0))
    number = np.arange(81).reshape(9, 9)
    corners = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    polygons = np.stack(corners, axis=-1)[np.add.outer(np.arange(8) // 4, np.arange(8) // 4) < 2]
    used, polygons = np.unique(polygons, return_inverse=True)
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(81)])[used]
    source = add_mesh("L", points, polygons.reshape(-1, 4))

    assert bpy.ops.crossfield.decompose(quad_count=200) == {"FINISHED"}
    quads = result(source, "quads").data
    assert set(values_of(quads, "block")) == {0, 1, 2}
    before = len(quads.polygons)
    assert bpy.ops.crossfield.decompose(quad_count=200, t_junctions=True) == {"FINISHED"}
    quads = result(source, "quads").data
    assert len(quads.polygons) == before and set(values_of(quads, "block")) == {0, 1}
    assert set(values_of(source.data, "crossfield_block")) == {0, 1}
    assert len({polygon.material_index for polygon in quads.polygons}) == 2
    # Three conforming blocks have ten edges; the two have eight pieces of sides.
    assert len(result(source, "block boundaries").data.splines) == 8

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = folder / "g.xyz"
        assert bpy.ops.crossfield.export_plot3d(filepath=str(path)) == {"FINISHED"}
        assert path.read_text().split()[0] == "2"
        assert (folder / "g.nmf").read_text().count("ONE_TO_ONE") == 1
        try:
            bpy.ops.crossfield.export_open_foam(filepath=str(folder / "blockMeshDict"))
        except RuntimeError as error:
            assert "T-junctions" in str(error)
        else:
            raise AssertionError("a blockMeshDict was written")
        assert not (folder / "blockMeshDict").exists()
