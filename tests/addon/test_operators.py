"""The operators inside Blender, on small meshes."""

from tests.addon.blender_process import in_blender


@in_blender
def test_decompose_writes_documented_attributes_and_objects():
    import bpy
    import numpy as np

    from tests.addon.scenes import add_disc, collection_of, empties, result, values_of

    source = add_disc()
    assert bpy.ops.crossfield.decompose(quad_count=200) == {"FINISHED"}
    mesh = source.data
    kinds = {a.name: (a.data_type, a.domain) for a in mesh.attributes if "crossfield" in a.name}
    assert kinds == {
        "crossfield_direction": ("FLOAT_VECTOR", "POINT"),
        "crossfield_distance": ("FLOAT", "POINT"),
        "crossfield_index": ("INT", "FACE"),
        "crossfield_block": ("INT", "FACE"),
    }
    direction = np.array([d.vector[:] for d in mesh.attributes["crossfield_direction"].data])
    assert np.allclose(np.linalg.norm(direction, axis=1), 1, atol=1e-5)
    distance = values_of(mesh, "crossfield_distance")
    assert distance.argmax() == 0 and abs(distance[0] - 1) < 0.2 and distance.min() == 0
    index = values_of(mesh, "crossfield_index")
    assert sorted(index[index != 0]) == [-1, -1, -1, -1]
    assert values_of(mesh, "crossfield_block").min() >= 0

    assert len(empties(source)) == 4
    for empty in empties(source):
        assert (empty["k"], empty["valence"]) == (-1, 3)
        assert empty.color[0] > 0.5 > empty.color[2]
    quads = result(source, "quads")
    assert all(len(p.vertices) == 4 for p in quads.data.polygons)
    assert 170 <= len(quads.data.polygons) <= 230
    assert quads.data.attributes["block"].domain == "FACE"
    assert values_of(quads.data, "scaled_jacobian").min() > 0
    blocks = set(values_of(quads.data, "block").tolist())
    assert blocks == set(range(len(blocks)))
    curve = result(source, "block boundaries")
    assert curve.type == "CURVE" and {s.type for s in curve.data.splines} == {"POLY"}
    assert collection_of(source).name in bpy.context.scene.collection.children


@in_blender
def test_stages_alone():
    import bpy

    from tests.addon.scenes import add_disc, collection_of, empties, result

    source = add_disc()
    assert bpy.ops.crossfield.cross_field() == {"FINISHED"}
    assert len(empties(source)) == len(collection_of(source).objects) == 4
    assert "crossfield_index" in source.data.attributes
    assert "crossfield_block" not in source.data.attributes
    assert bpy.ops.crossfield.trace() == {"FINISHED"}
    assert result(source, "lines").type == "CURVE"
    assert len(collection_of(source).objects) == 5
    assert bpy.ops.crossfield.trace(lines="full") == {"FINISHED"}
    assert len(result(source, "lines").data.splines) >= 12


@in_blender
def test_running_again_replaces_the_results_and_keeps_what_the_user_added():
    import bpy

    from tests.addon.scenes import add_disc, collection_of

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200, keep_lines=True)
    names = sorted(o.name for o in bpy.data.objects)
    counts = len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.materials)
    mine = bpy.data.objects.new("Mine", None)
    collection_of(source).objects.link(mine)
    bpy.ops.crossfield.decompose(quad_count=200, keep_lines=True)
    assert sorted(o.name for o in bpy.data.objects) == sorted([*names, "Mine"])
    assert (len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.materials)) == counts
    bpy.ops.crossfield.cross_field()
    assert "crossfield_block" not in source.data.attributes
    assert "Disc quads" not in bpy.data.objects and "Mine" in bpy.data.objects
    bpy.ops.crossfield.clear()
    assert sorted(o.name for o in bpy.data.objects) == ["Disc", "Mine"]
    assert mine.name in collection_of(source).objects


@in_blender
def test_clear_removes_all_traces():
    import bpy

    from tests.addon.scenes import add_grid, snapshot

    add_grid()
    before = snapshot()
    assert bpy.ops.crossfield.clear() == {"CANCELLED"}
    bpy.ops.crossfield.decompose(quad_count=100, keep_lines=True)
    assert snapshot() != before
    assert bpy.ops.crossfield.clear() == {"FINISHED"}
    assert snapshot() == before


@in_blender
def test_input_is_untouched_beyond_its_attributes():
    import bpy
    import numpy as np

    from tests.addon.scenes import add_disc, points_of

    source = add_disc()
    source.data.materials.append(bpy.data.materials.new("Steel"))
    source.data.attributes.new("mine", "FLOAT", "POINT").data[3].value = 7.0
    points = points_of(source.data)
    polygons = [tuple(p.vertices) for p in source.data.polygons]
    bpy.ops.crossfield.decompose(quad_count=200)
    assert np.array_equal(points_of(source.data), points)
    assert [tuple(p.vertices) for p in source.data.polygons] == polygons
    assert source.data.materials.keys() == ["Steel"] and not source.keys()
    assert source.data.attributes["mine"].data[3].value == 7.0
    assert bpy.context.object == source and source.select_get()


@in_blender
def test_edit_mode():
    import bpy
    import numpy as np

    from tests.addon.scenes import add_disc, result, values_of

    source = add_disc()
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.crossfield.decompose(quad_count=200) == {"FINISHED"}
    assert bpy.ops.crossfield.decompose(quad_count=200) == {"FINISHED"}
    assert source.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    edited = {n: values_of(source.data, n) for n in ("crossfield_distance", "crossfield_index")}
    faces = len(result(source, "quads").data.polygons)
    bpy.ops.crossfield.decompose(quad_count=200)
    for name, values in edited.items():
        assert np.array_equal(values, values_of(source.data, name)), name
    assert len(result(source, "quads").data.polygons) == faces
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.crossfield.clear() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not [a for a in source.data.attributes.keys() if "crossfield" in a]


@in_blender
def test_edit_mode_takes_unsaved_edits():
    import bmesh
    import bpy

    from tests.addon.scenes import add_grid, points_of, result

    source = add_grid(width=3.0)
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(source.data)
    for vertex in edited.verts:
        vertex.co.x *= 2
    bmesh.update_edit_mesh(source.data)
    bpy.ops.crossfield.decompose(quad_count=100)
    assert abs(points_of(result(source, "quads").data)[:, 0].max() - 6.0) < 1e-5


@in_blender
def test_modifiers_that_keep_the_topology():
    import bpy

    from tests.addon.scenes import add_grid, points_of, result

    source = add_grid()
    cast = source.modifiers.new("Lift", "DISPLACE")
    cast.direction, cast.strength, cast.mid_level = "Z", 2.0, 0.0
    bpy.ops.crossfield.decompose(quad_count=100)
    heights = points_of(result(source, "quads").data)[:, 2]
    assert abs(heights - 2.0).max() < 1e-5
    assert "crossfield_block" in source.data.attributes
    assert points_of(source.data)[:, 2].max() == 0.0 and len(source.modifiers) == 1


@in_blender
def test_modifiers_that_change_the_topology():
    import bpy

    from tests.addon.scenes import add_grid, collection_of, result

    source = add_grid()
    bpy.ops.crossfield.decompose(quad_count=100)
    source.modifiers.new("Finer", "SUBSURF").levels = 1
    bpy.ops.crossfield.decompose(quad_count=100)
    assert not [a for a in source.data.attributes.keys() if "crossfield" in a]
    assert len(result(source, "quads").data.polygons) > 50
    assert "Modifiers change the faces" in collection_of(source)["crossfield_notes"]


@in_blender
def test_place_and_scale():
    import bpy
    import numpy as np
    from mathutils import Matrix

    from tests.addon.scenes import add_disc, empties, result

    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale, parent.rotation_euler = (3, 1, 1), (0.3, 0.2, 0.1)
    source = add_disc()
    source.parent = parent
    source.location, source.rotation_euler, source.scale = (5, 6, 7), (0.4, 1, 2), (1, 2, -0.5)
    bpy.ops.crossfield.decompose(quad_count=200)
    bpy.context.view_layer.update()
    place = np.array(source.matrix_world)
    for ending in ("quads", "block boundaries"):
        assert np.allclose(np.array(result(source, ending).matrix_world), place, atol=1e-6)
    for empty in empties(source):
        local = np.array(empty.location)
        assert np.linalg.norm(local) < 1 and abs(local[2]) < 1e-6
        expected = place @ np.append(local, 1)
        assert np.allclose(np.array(empty.matrix_world.translation), expected[:3], atol=1e-5)
    source.matrix_world = Matrix.Translation((1, 0, 0))
    bpy.context.view_layer.update()
    assert np.allclose(result(source, "quads").matrix_world.translation, (1, 0, 0), atol=1e-6)


@in_blender
def test_two_objects_and_renaming():
    import bpy

    from tests.addon.scenes import add_disc, add_grid, collection_of, empties

    disc, grid = add_disc(), add_grid()
    bpy.ops.crossfield.decompose(quad_count=100)
    bpy.context.view_layer.objects.active = disc
    bpy.ops.crossfield.decompose(quad_count=200)
    assert len(empties(disc)) == 4 and not empties(grid)
    disc.name = "Wheel"
    bpy.ops.crossfield.cross_field()
    assert collection_of(disc) is None and "Crossfield Disc" in bpy.data.collections
    assert len(bpy.data.collections["Crossfield Disc"].objects) == 4


@in_blender
def test_settings_come_from_the_scene_unless_given():
    import bpy

    from tests.addon.scenes import add_grid, result

    source = add_grid()

    def faces(**given):
        bpy.ops.crossfield.decompose(**given)
        return len(result(source, "quads").data.polygons)

    bpy.context.scene.crossfield.quad_count = 600
    assert 500 < faces() < 700
    assert 80 < faces(quad_count=100) < 120
    assert 500 < faces() < 700
    assert 19 < faces(edge_length=0.5) < 30
    bpy.context.scene.crossfield.size = "LENGTH"
    bpy.context.scene.crossfield.edge_length = 0.25
    assert 80 < faces() < 120
    assert 500 < faces(quad_count=600) < 700


@in_blender
def test_results_survive_saving_and_loading():
    import tempfile

    import bpy

    from tests.addon.scenes import add_disc, empties, result

    add_disc()
    bpy.context.scene.crossfield.quad_count = 250
    bpy.ops.crossfield.decompose()
    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/disc.blend")
        bpy.ops.wm.open_mainfile(filepath=f"{folder}/disc.blend")
    source = bpy.data.objects["Disc"]
    assert bpy.context.scene.crossfield.quad_count == 250
    assert len(empties(source)) == 4
    bpy.context.view_layer.objects.active = source
    bpy.ops.crossfield.decompose()
    assert len(empties(source)) == 4 and result(source, "quads")


@in_blender
def test_the_result_in_words():
    import importlib

    import bpy

    from tests.addon.blender_process import EXTENSION
    from tests.addon.scenes import add_disc

    results = importlib.import_module(f"{EXTENSION}.crossfield_addon.results")
    source = add_disc()
    assert results.result_text(source) == ("", [])
    bpy.ops.crossfield.decompose(quad_count=200)
    sentence, notes = results.result_text(source)
    assert sentence.startswith("4 singularities, index sum as topology asks; ")
    assert " blocks; " in sentence and sentence.endswith(" quads") and notes == []


@in_blender
def test_linked_mesh_keeps_its_file_and_gets_results():
    import tempfile

    import bpy

    from tests.addon.scenes import add_grid, collection_of, result

    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/library.blend"
        bpy.data.libraries.write(path, {add_grid()})
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with bpy.data.libraries.load(path, link=True) as (_, wanted):
            wanted.objects = ["Grid"]
    source = bpy.data.objects["Grid"]
    bpy.context.scene.collection.objects.link(source)
    bpy.context.view_layer.objects.active = source
    assert bpy.ops.crossfield.decompose(quad_count=100) == {"FINISHED"}
    assert "linked" in collection_of(source)["crossfield_notes"]
    assert len(result(source, "quads").data.polygons) > 10
    assert not [a for a in source.data.attributes.keys() if "crossfield" in a]
    assert bpy.ops.crossfield.clear() == {"FINISHED"}


@in_blender
def test_an_active_result_stands_for_the_mesh_it_was_made_from():
    import bpy

    from tests.addon.scenes import activate, add_disc, collection_of, result, values_of

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200)
    bpy.ops.crossfield.edit_block_edges()
    blocks = bpy.context.object
    assert bpy.ops.crossfield.decompose(quad_count=400) == {"FINISHED"}
    assert bpy.context.object == blocks and blocks.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert 300 < len(result(source, "quads").data.polygons) < 500
    assert len(collection_of(source).objects) == 3 + 4
    assert values_of(blocks.data, "divisions").min() > 0
    activate(result(source, "block boundaries"))
    assert bpy.ops.crossfield.clear() == {"FINISHED"}
    assert collection_of(source) is None and bpy.data.objects.keys() == ["Disc"]


@in_blender
def test_products_are_chosen_and_copies_of_them_are_the_users_own():
    import bpy

    from tests.addon.scenes import add_disc, collection_of, result

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200)
    mine = result(source, "quads").copy()
    mine.data = mine.data.copy()
    collection_of(source).objects.link(mine)
    faces = len(mine.data.polygons)
    assert bpy.ops.crossfield.decompose(quad_count=400, products={"QUADS"}) == {"FINISHED"}
    assert len(mine.data.polygons) == faces < len(result(source, "quads").data.polygons)
    names = sorted(o.name for o in collection_of(source).objects)
    assert names == ["Disc blocks", "Disc quads", mine.name]
    assert bpy.ops.crossfield.decompose(quad_count=400, products={"BOUNDARIES"}) == {"FINISHED"}
    assert bpy.ops.crossfield.clear() == {"FINISHED"}
