"""Locks on block edges, wall spacing and new divisions, with the blocks as they are."""

from tests.addon.blender_process import in_blender


@in_blender
def test_locking_an_edge_in_edit_mode_and_all_that_must_follow():
    import bpy
    import numpy as np

    from tests.addon.scenes import add_disc, edge_values, refused, result, select_block_edges

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200)
    blocks, quads = result(source, "blocks"), result(source, "quads")
    before = edge_values(blocks)
    faces = len(quads.data.polygons)
    assert blocks.hide_get() and not quads.hide_get()
    assert bpy.ops.crossfield.edit_block_edges() == {"FINISHED"}
    assert bpy.context.object == blocks and blocks.mode == "EDIT"
    assert bpy.context.tool_settings.mesh_select_mode[:] == (False, True, False)
    assert refused(lambda: bpy.ops.crossfield.lock_divisions(divisions=9), "No block edge")
    select_block_edges(blocks, [0])
    assert bpy.ops.crossfield.lock_divisions(divisions=17) == {"FINISHED"}
    assert blocks.mode == "EDIT" and blocks.data.total_edge_sel == 1
    bpy.ops.object.mode_set(mode="OBJECT")
    after = edge_values(blocks)
    follows = after["chord"] == after["chord"][after["block_edge"] == 0]
    assert (after["divisions"][follows] == 17).all() and follows.sum() >= 3
    assert after["lock"].sum() == 17
    assert (after["lock_state"] == np.where(follows, 1 + (after["block_edge"] == 0), 0)).all()
    assert [e.use_seam for e in blocks.data.edges] == (after["lock_state"] == 2).tolist()
    assert result(source, "quads") == quads and len(quads.data.polygons) != faces
    spline = result(source, "block boundaries").data.splines[0]
    assert len(spline.points) == 18 and spline.material_index == 2
    for name in ("block_edge", "chord"):
        assert np.array_equal(before[name], after[name])
    assert bpy.ops.crossfield.unlock_divisions(edge=int(after["block_edge"][follows][-1]))
    assert np.array_equal(edge_values(blocks)["divisions"], before["divisions"])
    assert len(quads.data.polygons) == faces


@in_blender
def test_contradictions_are_refused_and_change_nothing():
    import bpy
    import numpy as np

    from tests.addon.scenes import add_grid, edge_values, points_of, refused, result, snapshot

    source = add_grid()
    before = snapshot()
    assert refused(lambda: bpy.ops.crossfield.lock_divisions(divisions=9), "has no blocks", "run")
    assert snapshot() == before
    bpy.ops.crossfield.decompose(quad_count=100)
    blocks = result(source, "blocks")
    values = edge_values(blocks)
    pair = values["block_edge"][values["chord"] == values["chord"][0]].tolist()
    assert bpy.ops.crossfield.lock_divisions(edge=pair[0], divisions=7) == {"FINISHED"}
    seen = edge_values(blocks), points_of(result(source, "quads").data), snapshot()
    lock = bpy.ops.crossfield.lock_divisions
    assert refused(lambda: lock(edge=pair[1], divisions=8), "face each other", "7", "8")
    assert refused(lambda: lock(edge=99, divisions=8), "no block edge 99")
    assert refused(lambda: bpy.ops.crossfield.regrid(first_height=50.0), "regular spacing")
    now = edge_values(blocks), points_of(result(source, "quads").data), snapshot()
    assert all(np.array_equal(seen[0][name], now[0][name]) for name in seen[0])
    assert np.array_equal(seen[1], now[1]) and seen[2] == now[2]
    assert lock(edge=pair[0], divisions=8) == {"FINISHED"}
    assert bpy.ops.crossfield.unlock_divisions(every=True) == {"FINISHED"}
    assert refused(lambda: bpy.ops.crossfield.unlock_divisions(edge=pair[0]), "locked")
    # Without the block mesh's edges and numbers there is no place for locks.
    bpy.ops.crossfield.edit_block_edges()
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.delete(type="EDGE")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert refused(lambda: lock(edge=0, divisions=5), "edge 0 was deleted")
    assert bpy.ops.crossfield.regrid(quad_count=150) == {"FINISHED"}
    blocks.data.attributes.remove(blocks.data.attributes["lock"])
    assert refused(lambda: lock(edge=0, divisions=5), "decompose the mesh again")


@in_blender
def test_a_boundary_curve_can_be_locked_too():
    import bpy

    from tests.addon.scenes import activate, add_disc, edge_values, result

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200)
    curve = result(source, "block boundaries")
    activate(curve)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.curve.select_all(action="DESELECT")
    curve.data.splines[3].points[1].select = True
    assert bpy.ops.crossfield.lock_divisions(divisions=5) == {"FINISHED"}
    assert curve.mode == "EDIT" and len(curve.data.splines[3].points) == 6
    assert [s.points[1].select for s in curve.data.splines].index(True) == 3
    bpy.ops.object.mode_set(mode="OBJECT")
    values = edge_values(result(source, "blocks"))
    assert values["lock"][values["block_edge"] == 3] == 5


@in_blender
def test_undo_and_redo_of_locks_in_edit_mode():
    import bpy

    from tests.addon.scenes import add_disc, points_of, result, select_block_edges

    source = add_disc()
    name = source.name
    bpy.ops.crossfield.decompose(quad_count=200)
    bpy.ops.ed.undo_push(message="decomposed")
    bpy.ops.crossfield.edit_block_edges("EXEC_DEFAULT", True)

    def seen():
        source = bpy.data.objects[name]
        blocks = result(source, "blocks")
        blocks.update_from_editmode()
        locks = [value.value for value in blocks.data.attributes["lock"].data] or "edited"
        return points_of(result(source, "quads").data).tobytes(), blocks.mode, locks

    select_block_edges(result(source, "blocks"), [1])
    states = [seen()]
    for count in (12, 3):
        bpy.ops.crossfield.lock_divisions("EXEC_DEFAULT", True, divisions=count)
        states.append(seen())
    assert len({state[0] for state in states}) == 3
    bpy.ops.ed.undo()
    assert seen() == states[1]
    bpy.ops.ed.undo()
    assert seen() == states[0]
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert seen() == states[2]


@in_blender
def test_regridding_keeps_blocks_and_locks():
    import bpy

    from tests.addon.scenes import activate, add_disc, edge_values, result

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200)
    bpy.ops.crossfield.lock_divisions(edge=0, divisions=9)
    blocks = len(result(source, "blocks").data.polygons)
    mine = result(source, "quads").modifiers.new("Mine", "SMOOTH")
    for given in ({"quad_count": 800}, {"edge_length": 0.06}):
        assert bpy.ops.crossfield.regrid(**given) == {"FINISHED"}
        assert 700 < len(result(source, "quads").data.polygons) < 1000
        values = edge_values(result(source, "blocks"))
        assert values["divisions"][values["block_edge"] == 0] == 9
    assert len(result(source, "blocks").data.polygons) == blocks
    assert result(source, "quads").modifiers[0] == mine
    # From any object of the result, and the quads come back when they were deleted.
    bpy.data.objects.remove(result(source, "quads"))
    activate(result(source, "block boundaries"))
    assert bpy.ops.crossfield.regrid(quad_count=200) == {"FINISHED"}
    assert 150 < len(result(source, "quads").data.polygons) < 300
    # Decomposing again: the same blocks keep their locks, others drop them with a note.
    activate(source)
    assert bpy.ops.crossfield.decompose(quad_count=200) == {"FINISHED"}
    assert edge_values(result(source, "blocks"))["lock"].sum() == 9
    for vertex in source.data.vertices:
        vertex.co.x *= 4
    assert bpy.ops.crossfield.decompose(quad_count=200) == {"FINISHED"}
    assert edge_values(result(source, "blocks"))["lock"].sum() == 0


@in_blender
def test_wall_spacing_by_loop_and_by_material():
    import bpy
    import numpy as np

    from tests.addon.scenes import add_grid, add_ring, points_of, refused, result

    source = add_grid()
    assert bpy.ops.crossfield.decompose(quad_count=200, first_height=0.002) == {"FINISHED"}

    def first_heights():
        y = np.unique(points_of(result(source, "quads").data)[:, 1].round(5))
        return np.diff(y)[[0, -1]]

    assert np.allclose(first_heights(), 0.002, rtol=0.05)
    assert bpy.ops.crossfield.regrid(quad_count=200, use_walls=False) == {"FINISHED"}
    assert first_heights().min() > 0.05
    ring = add_ring(around=96)
    for name in ("skin", "air"):
        ring.data.materials.append(bpy.data.materials.new(name))
    for polygon in ring.data.polygons:
        polygon.material_index = int(np.hypot(*polygon.center[:2]) > 0.75)

    def gaps(**walls):
        bpy.ops.crossfield.decompose(quad_count=400, first_height=0.004, **walls)
        radius = np.linalg.norm(points_of(result(ring, "quads").data), axis=1)
        away = radius - 0.5, 1 - radius
        return [bool(((0.002 < off) & (off < 0.006)).sum() > 20) for off in away]

    assert gaps() == [True, True]
    by_number = [gaps(walls="LOOPS", wall_loops=str(loop)) for loop in (0, 1)]
    assert sorted(by_number) == [[False, True], [True, False]]
    assert gaps(walls="MATERIAL", wall_material="skin") == [True, False]
    assert gaps(walls="MATERIAL", wall_material="air") == [False, True]
    decompose = bpy.ops.crossfield.decompose
    material = {"first_height": 0.01, "walls": "MATERIAL", "wall_material": "rock"}
    assert refused(lambda: decompose(**material), "'rock'", "'skin'")
    loops = {"first_height": 0.01, "walls": "LOOPS"}
    assert refused(lambda: decompose(wall_loops="7", **loops), "loop 7")
    assert refused(lambda: decompose(wall_loops="two", **loops), "'two'")


@in_blender
def test_labels_at_the_block_edges_in_edit_mode():
    import importlib

    import bpy
    import numpy as np

    from tests.addon.blender_process import EXTENSION
    from tests.addon.scenes import add_ring, edge_values, result, select_block_edges

    overlay = importlib.import_module(f"{EXTENSION}.crossfield_addon.overlay")
    selection = importlib.import_module(f"{EXTENSION}.crossfield_addon.block_edge_selection")
    source = add_ring(around=96)
    bpy.ops.crossfield.decompose(quad_count=400)
    assert overlay.edge_labels(bpy.context.object) == []
    bpy.ops.crossfield.lock_divisions(edge=2, divisions=11)
    bpy.ops.crossfield.edit_block_edges()
    labels = overlay.edge_labels(bpy.context.object)
    select_block_edges(bpy.context.object, [2])
    assert selection.active_block_edge(bpy.context.object).sentence() == "Edge 2: 11 quads, locked"
    assert selection.present_divisions(bpy.context.object) == 11
    bpy.ops.object.mode_set(mode="OBJECT")
    values = edge_values(result(source, "blocks"))
    assert [text for _, text, _ in labels] == [str(n) for n in values["divisions"]]
    assert [state for _, _, state in labels] == values["lock_state"].tolist()
    # They stand on the curves: on the two circles, not on the chords inside them.
    radius = np.array([place.length for place, _, _ in labels])
    assert (np.abs(radius - 0.5) < 0.01).sum() == (np.abs(radius - 1) < 0.01).sum() == 3
