"""What cannot be decomposed: one sentence, CANCELLED, nothing changed."""

from tests.addon.blender_process import in_blender


@in_blender
def test_objects_that_are_no_mesh():
    import bpy

    from tests.addon.scenes import add_grid, snapshot

    def refused(*words):
        before = snapshot()
        try:
            bpy.ops.crossfield.decompose()
        except RuntimeError as error:
            assert all(word in str(error) for word in words), error
            return snapshot() == before
        return False

    bpy.context.view_layer.objects.active = None
    assert refused("no active object", "select a mesh")
    bpy.ops.curve.primitive_bezier_circle_add()
    assert refused("is not a mesh", "convert")
    add_grid()
    bpy.ops.object.mode_set(mode="SCULPT")
    assert refused("object mode and in edit mode")


@in_blender
def test_meshes_that_cannot_be_decomposed():
    import bpy

    from tests.addon.scenes import add_grid, add_mesh, snapshot

    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    fan = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]]
    flipped = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    cases = {
        "Nothing": ([], [], ["no faces"]),
        "Points": (square, [], ["no faces"]),
        "Number": ([*square[:2], [1, float("nan"), 0], square[3]], [[0, 1, 2, 3]], ["2"]),
        "Endless": ([*square[:3], [float("inf"), 1, 0]], [[0, 1, 2, 3]], ["3"]),
        "Fan": (fan, [[0, 1, 2], [1, 0, 3], [0, 1, 4]], ["0", "1"]),
        "Flipped": (flipped, [[0, 1, 2], [0, 2, 3][::-1]], ["0 and 1"]),
    }
    for name, (points, polygons, words) in cases.items():
        add_mesh(name, points, polygons)
        for mode in ("EDIT", "OBJECT"):
            bpy.ops.object.mode_set(mode=mode)
            before = snapshot()
            try:
                bpy.ops.crossfield.decompose(quad_count=100, repair=False)
            except RuntimeError as error:
                text = str(error)
            else:
                raise AssertionError(f"{name} was not refused")
            assert all(word in text for word in words), (name, text)
            assert "Traceback" not in text and len(text.strip().splitlines()) == 1, (name, text)
            assert snapshot() == before, (name, mode)
    add_grid("Fine")
    assert bpy.ops.crossfield.decompose(quad_count=100) == {"FINISHED"}


@in_blender
def test_a_failure_keeps_earlier_results():
    import bpy

    from tests.addon.scenes import add_grid, result, snapshot

    source = add_grid()
    bpy.ops.crossfield.decompose(quad_count=100)
    before = snapshot()
    faces = len(result(source, "quads").data.polygons)
    kept = source.data.vertices[0].co.copy()
    source.data.vertices[0].co.x = float("nan")
    try:
        bpy.ops.crossfield.decompose(quad_count=400)
    except RuntimeError as error:
        assert "0" in str(error)
    else:
        raise AssertionError("a vertex without a place was not refused")
    assert snapshot() == before and len(result(source, "quads").data.polygons) == faces
    source.data.vertices[0].co = kept
    assert bpy.ops.crossfield.decompose(quad_count=400) == {"FINISHED"}
