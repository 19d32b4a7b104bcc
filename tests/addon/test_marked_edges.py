"""Edges marked in Blender stay edges of the quad mesh."""

from tests.addon.blender_process import in_blender


@in_blender
def test_each_kind_of_mark_becomes_a_chain_of_quad_edges():
    import bpy

    from tests.addon.scenes import add_grid, result

    def is_marked_line(*points):
        return all(abs(p.x - 0.75) < 1e-5 for p in points)

    def kept_length(marks, mark):
        source = add_grid(columns=12, rows=8)
        mesh = source.data
        vertices = mesh.vertices
        mark(mesh, [e for e in mesh.edges if is_marked_line(*(vertices[v].co for v in e.vertices))])
        assert bpy.ops.crossfield.decompose(quad_count=150, marks=marks) == {"FINISHED"}
        quads = result(source, "quads").data
        ends = [[quads.vertices[v].co for v in e.vertices] for e in quads.edges]
        return sum((a - b).length for a, b in ends if is_marked_line(a, b))

    def sharp(mesh, edges):
        for edge in edges:
            edge.use_edge_sharp = True

    def seam(mesh, edges):
        for edge in edges:
            edge.use_seam = True

    def crease(mesh, edges):
        weights = mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
        for edge in edges:
            weights.data[edge.index].value = 1.0

    def material(mesh, edges):
        for name in ("left", "right"):
            mesh.materials.append(bpy.data.materials.new(name))
        for polygon in mesh.polygons:
            polygon.material_index = int(polygon.center.x > 0.75)

    for kind, mark in (("SHARP", sharp), ("SEAM", seam), ("CREASE", crease), ("MATERIAL", material)):
        assert abs(kept_length({kind}, mark) - 2.0) < 1e-4, kind
        assert kept_length(set(), mark) < 0.1, kind


@in_blender
def test_marks_are_read_in_edit_mode_too():
    import bpy

    from tests.addon.scenes import add_grid, result

    source = add_grid(columns=12, rows=8)
    for edge in source.data.edges:
        points = [source.data.vertices[v].co for v in edge.vertices]
        edge.use_seam = all(abs(p.x - 0.75) < 1e-5 for p in points)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.crossfield.decompose(quad_count=150, marks={"SEAM"}) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    points = [v.co.x for v in result(source, "quads").data.vertices]
    assert sum(abs(x - 0.75) < 1e-5 for x in points) >= 5
