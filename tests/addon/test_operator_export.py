"""Exports of the active result: complete files, the same after saving and loading."""

from tests.addon.blender_process import in_blender


@in_blender
def test_exports_are_the_same_after_saving_and_loading():
    import tempfile
    from pathlib import Path

    import bpy

    from tests.addon.scenes import activate, add_ring, edge_values, result

    source = add_ring()
    for name in ("inlet", "wall"):
        source.data.materials.append(bpy.data.materials.new(name))
    for polygon in source.data.polygons:
        polygon.material_index = int(polygon.center.x > 0)
    bpy.ops.crossfield.decompose(quad_count=200, first_height=0.01)
    # Edges round the ring do not leave the walls, so that any count goes with the first height.
    values = edge_values(result(source, "blocks"))
    chord = values["chord"].tolist()
    around = next(e for e, c in zip(values["block_edge"], chord, strict=True) if chord.count(c) == 2)
    bpy.ops.crossfield.lock_divisions(edge=int(around), divisions=23)

    def export(folder):
        folder.mkdir()
        operators = bpy.ops.crossfield
        for form in ("ascii", "binary", "unformatted"):
            path = str(folder / f"{form}.xyz")
            assert operators.export_plot3d(filepath=path, form=form) == {"FINISHED"}
        for depth in (0.0, 0.3):
            path = str(folder / f"deep{depth}.xyz")
            operators.export_plot3d(filepath=path, extrude=True, thickness=depth)
        assert operators.export_open_foam(filepath=str(folder / "blockMeshDict")) == {"FINISHED"}
        assert operators.export_vtk(filepath=str(folder / "g.vtm")) == {"FINISHED"}
        assert operators.export_obj(filepath=str(folder / "q.obj")) == {"FINISHED"}
        assert operators.export_obj(filepath=str(folder / "b.obj"), mesh="BLOCKS") == {"FINISHED"}
        return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}

    with tempfile.TemporaryDirectory() as folder:
        first = export(Path(folder) / "first")
        bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/ring.blend", compress=True)
        bpy.ops.wm.open_mainfile(filepath=f"{folder}/ring.blend")
        source = bpy.data.objects["Ring"]
        activate(source)
        second = export(Path(folder) / "second")
    assert first == second
    blocks = edge_values(result(source, "blocks"))
    assert blocks["lock"].max() == 23
    assert b"inlet" in first["blockMeshDict"] and b"wall" in first["ascii.nmf"]
    assert first["q.obj"].count(b"\ng block_") == len(result(source, "blocks").data.polygons)
    assert first["q.obj"].count(b"\nf ") == len(result(source, "quads").data.polygons)
    assert b"0.3\n" in first["deep0.3.xyz"] or b" 0.3 " in first["deep0.3.xyz"]
    assert len([name for name in first if name.endswith(".vts")]) > 5
    # And everything can still be divided anew.
    assert bpy.ops.crossfield.unlock_divisions(every=True) == {"FINISHED"}


@in_blender
def test_what_is_seen_is_what_is_written():
    import tempfile
    from pathlib import Path

    import bpy
    import numpy as np

    from tests.addon.scenes import activate, add_grid, refused, result

    source = add_grid()
    bpy.ops.crossfield.decompose(quad_count=100)
    quads = result(source, "quads")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "q.obj"

        def points(**given):
            assert bpy.ops.crossfield.export_obj(filepath=str(path), **given) == {"FINISHED"}
            lines = path.read_text().splitlines()
            return np.array([line.split()[1:] for line in lines if line.startswith("v ")], float)

        flat = points()
        quads.data.vertices[5].co.z = 0.5
        moved = points()
        assert moved[5, 2] == 0.5 and (moved != flat).any(1).sum() == 1
        source.location, source.scale = (0, 0, 7), (2, 2, 2)
        bpy.context.view_layer.update()
        assert np.allclose(points(), 2 * moved + [0, 0, 7])
        assert np.array_equal(points(in_world=False), moved)
        source.scale = (-1, 1, 1)
        bpy.context.view_layer.update()
        export = bpy.ops.crossfield.export_obj
        kept = path.read_bytes()
        assert refused(lambda: export(filepath=str(path)), "mirrored", "apply the scale")
        source.scale = (1, 1, 1)
        quads.modifiers.new("Finer", "SUBSURF").levels = 1
        assert refused(lambda: export(filepath=str(path)), "no longer those of the blocks")
        quads.modifiers.clear()
        assert refused(lambda: export(filepath=folder), "directory")
        missing = str(Path(folder) / "none" / "q.obj")
        assert refused(lambda: export(filepath=missing), "does not exist")
        assert path.read_bytes() == kept and [p.name for p in Path(folder).iterdir()] == ["q.obj"]
    # The mesh that was decomposed is not needed for it.
    activate(quads)
    bpy.data.objects.remove(source)
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "blockMeshDict")
        assert bpy.ops.crossfield.export_open_foam(filepath=path, thickness=0.1) == {"FINISHED"}
        assert "loop_0" in Path(path).read_text()


@in_blender
def test_the_menu_and_the_polls():
    import bpy

    from tests.addon.scenes import add_grid, refused

    menu = bpy.types.TOPBAR_MT_file_export
    assert any("crossfield" in draw.__module__ for draw in menu._dyn_ui_initialize())
    for name in ("plot3d", "open_foam", "vtk", "obj"):
        operator = getattr(bpy.ops.crossfield, f"export_{name}")
        assert refused(lambda operator=operator: operator(filepath="/x"), "no active object")
    add_grid()
    assert not bpy.ops.crossfield.export_vtk.poll()
