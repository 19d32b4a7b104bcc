"""Grid quality in Blender: attributes, colours, and the table."""

from tests.addon.blender_process import in_blender


@in_blender
def test_quality_attributes_and_numbers_that_link_the_products():
    import bpy
    import numpy as np

    from tests.addon.scenes import add_disc, points_of, result, values_of

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200)
    quads, blocks = result(source, "quads").data, result(source, "blocks").data
    jacobian, block = values_of(quads, "scaled_jacobian"), values_of(quads, "block")
    assert 0 < jacobian.min() < jacobian.max() <= 1
    assert 0 <= values_of(quads, "skewness").min() and values_of(quads, "aspect_ratio").min() >= 1
    worst = [jacobian[block == b].min() for b in values_of(blocks, "block")]
    assert np.allclose(values_of(blocks, "min_scaled_jacobian"), worst)
    # Corners of the block mesh are vertices of the quad mesh, its edges chains of mesh edges.
    corner = values_of(blocks, "vertex")
    assert np.allclose(points_of(blocks), points_of(quads)[corner], atol=1e-6)
    of_edge, number = values_of(quads, "block_edge"), values_of(blocks, "block_edge")
    count = np.bincount(of_edge[of_edge >= 0])
    assert np.array_equal(count[number], values_of(blocks, "divisions"))
    assert sorted(number) == list(range(len(result(source, "block boundaries").data.splines)))
    for edge, n in zip(blocks.edges, number, strict=True):
        joined = [v for e, m in zip(quads.edges, of_edge, strict=True) if m == n for v in e.vertices]
        ends = [v for v in set(joined) if joined.count(v) == 1]
        assert set(ends) == {corner[v] for v in edge.vertices}


@in_blender
def test_colours_follow_the_measure_and_new_divisions():
    import bpy
    import numpy as np

    from tests.addon.scenes import activate, add_disc, refused, result, values_of

    assert refused(lambda: bpy.ops.crossfield.show_quality(), "no active object")
    source = add_disc()
    assert refused(lambda: bpy.ops.crossfield.show_quality(), "no blocks")
    bpy.ops.crossfield.decompose(quad_count=200)
    quads = result(source, "quads")

    def colours():
        colour = quads.data.color_attributes.active_color
        values = np.zeros(16 * len(quads.data.polygons), np.float32)
        colour.data.foreach_get("color", values)
        values = values.reshape(-1, 4, 4)
        assert (values == values[:, :1]).all()
        return values[:, 0, :3]

    activate(quads)
    for measure in ("SCALED_JACOBIAN", "SKEWNESS", "ASPECT_RATIO"):
        assert bpy.ops.crossfield.show_quality(measure=measure) == {"FINISHED"}
        assert len(quads.data.color_attributes) == 1
        value = values_of(quads.data, measure.lower())
        value = value if measure == "SCALED_JACOBIAN" else -value
        light = colours() @ [0.2126, 0.7152, 0.0722]
        order = np.argsort(value)
        assert (np.diff(light[order]) >= -1e-6).all() and light.min() < 0.05 and light.max() > 0.7
        bpy.ops.crossfield.show_quality(measure=measure, fit_range=False)
        assert (colours() @ [0.2126, 0.7152, 0.0722]).min() > light.min()
    bpy.ops.crossfield.lock_divisions(edge=0, divisions=12)
    assert quads.data.color_attributes.active_color.name == "crossfield_colour" and len(colours())
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.crossfield.show_quality(measure="BLOCKS") == {"FINISHED"}
    assert quads.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert 2 <= len(np.unique(colours(), axis=0)) <= 8
    assert bpy.ops.crossfield.show_quality(measure="NONE") == {"FINISHED"}
    assert not len(quads.data.color_attributes)


@in_blender
def test_the_quality_table():
    import csv

    import bpy
    import numpy as np

    from tests.addon.scenes import add_disc, result, values_of

    source = add_disc()
    bpy.ops.crossfield.decompose(quad_count=200)
    for _ in range(2):
        assert bpy.ops.crossfield.quality_table() == {"FINISHED"}
    assert [text.name for text in bpy.data.texts] == ["crossfield quality.csv"]
    rows = list(csv.DictReader(bpy.data.texts[0].as_string().splitlines()))
    blocks = result(source, "blocks").data
    assert [int(row["block"]) for row in rows] == values_of(blocks, "block").tolist()
    for measure in ("min_scaled_jacobian", "max_skewness", "max_aspect_ratio"):
        listed = [float(row[measure]) for row in rows]
        assert np.allclose(listed, values_of(blocks, measure), rtol=1e-5), measure
    assert all(len(row["edges"].split()) == 4 for row in rows)


def test_the_ramp_is_even_to_the_eye():
    """Lightness in Oklab rises in even steps from dark to light."""
    import numpy as np
    import pytest

    pytest.importorskip("bpy")
    from crossfield_addon import palette

    linear = palette.ramp(np.linspace(0, 1, 101))
    assert linear.min() >= 0 and linear.max() <= 1
    cone = np.cbrt(linear @ np.array([
        [0.4122214708, 0.2119034982, 0.0883024619],
        [0.5363325363, 0.6806995451, 0.2817188376],
        [0.0514459929, 0.1073969566, 0.6299787005],
    ]))
    step = np.diff(cone @ [0.2104542553, 0.7936177850, -0.0040720468])
    assert step.min() > 0.7 * step.mean() and step.max() < 1.3 * step.mean()
