"""One undo takes the results back, and redo brings them again."""

from tests.addon.blender_process import in_blender


@in_blender
def test_undo_and_redo_in_object_mode():
    import bpy

    from tests.addon.scenes import add_disc, snapshot

    add_disc()
    before = snapshot()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.crossfield.decompose("EXEC_DEFAULT", True, quad_count=200)
    after = snapshot()
    assert after != before
    bpy.ops.ed.undo()
    assert snapshot() == before
    bpy.ops.ed.redo()
    assert snapshot() == after


@in_blender
def test_undo_in_edit_mode():
    import bpy

    from tests.addon.scenes import add_disc, snapshot

    add_disc()
    before = snapshot()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="EDIT")
    bpy.ops.crossfield.decompose("EXEC_DEFAULT", True, quad_count=200)
    assert snapshot() != before
    bpy.ops.ed.undo()
    assert bpy.context.object.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert snapshot() == before
