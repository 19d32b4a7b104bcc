"""Small objects for the tests inside Blender, and what the tests look at."""

import bpy
import numpy as np


def add_mesh(name, points, polygons):
    """A new active mesh object."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(points, float).tolist(), [], [list(map(int, p)) for p in polygons])
    shown = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(shown)
    bpy.context.view_layer.objects.active = shown
    shown.select_set(True)
    return shown


def add_grid(name="Grid", columns=12, rows=8, width=3.0, height=2.0):
    """A flat rectangle of quads: no singularity, one block."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    number = np.arange(x.size).reshape(x.shape)
    corners = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    return add_mesh(name, points, np.stack(corners, axis=-1).reshape(-1, 4))


def add_disc(name="Disc", rings=8):
    """A flat disc of triangles: four singularities of valence 3."""
    points, triangles = [[0.0, 0.0, 0.0]], []
    for ring in range(1, rings + 1):
        angle = 2 * np.pi * np.arange(6 * ring) / (6 * ring)
        radius = ring / rings
        points += np.column_stack(
            [radius * np.cos(angle), radius * np.sin(angle), 0 * angle]
        ).tolist()
        triangles += _ring_triangles(ring)
    return add_mesh(name, points, triangles)


def _ring_triangles(ring):
    inner, outer = max(6 * (ring - 1), 1), 6 * ring
    first_inner = 0 if ring == 1 else 1 + 3 * (ring - 1) * (ring - 2)
    first_outer = 1 + 3 * ring * (ring - 1)
    triangles = []
    for sector in range(6):
        for step in range(ring):
            a = first_inner + (sector * (ring - 1) + step) % inner
            b = first_outer + sector * ring + step
            c = first_outer + (sector * ring + step + 1) % outer
            triangles.append((a, b, c))
            if step < ring - 1:
                d = first_inner + (sector * (ring - 1) + step + 1) % inner
                triangles.append((a, c, d))
    return triangles


def collection_of(source):
    """The collection of results, by its documented name."""
    return bpy.data.collections.get(f"Crossfield {source.name}")


def result(source, ending):
    """The result object whose name ends so."""
    (found,) = [o for o in collection_of(source).objects if o.name == f"{source.name} {ending}"]
    return found


def empties(source):
    """The empties at the singularities."""
    return [o for o in collection_of(source).objects if o.type == "EMPTY"]


def points_of(mesh):
    """(V, 3) float64."""
    points = np.zeros(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3).astype(float)


def values_of(mesh, name):
    """The values of an attribute with one number an element."""
    data = mesh.attributes[name].data
    return np.array([element.value for element in data])


def snapshot():
    """What must not change when an operator fails: all datablocks and attributes."""
    pools = "objects", "meshes", "curves", "collections", "materials", "scenes", "worlds"
    names = {pool: sorted(item.name for item in getattr(bpy.data, pool)) for pool in pools}
    attributes = {mesh.name: sorted(mesh.attributes.keys()) for mesh in bpy.data.meshes}
    return names, attributes


def add_ring(name="Ring", around=48, rings=8, inner=0.5):
    """A flat ring of quads between two circles."""
    angle = 2 * np.pi * np.arange(around) / around
    radius = np.linspace(inner, 1, rings + 1)[:, None]
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * radius * angle], -1)
    number = np.arange(around * (rings + 1)).reshape(-1, around)
    following = np.roll(number, -1, axis=1)
    corners = number[:-1], number[1:], following[1:], following[:-1]
    return add_mesh(name, points.reshape(-1, 3), np.stack(corners, axis=-1).reshape(-1, 4))


def activate(shown):
    """Make an object the only selected and the active one."""
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = shown
    shown.select_set(True)


def edge_values(blocks):
    """Name -> (E,) array, the edge attributes of a block mesh, not in edit mode."""
    names = "block_edge", "chord", "divisions", "lock", "lock_state"
    return {name: values_of(blocks.data, name) for name in names}


def select_block_edges(blocks, numbers):
    """Select edges of a block mesh in edit mode by the numbers of their block edges."""
    import bmesh

    edited = bmesh.from_edit_mesh(blocks.data)
    layer = edited.edges.layers.int["block_edge"]
    for edge in edited.edges:
        edge.select_set(edge[layer] in numbers)
    bmesh.update_edit_mesh(blocks.data)


def refused(action, *words):
    """Is it refused with an error report of one line that holds these words?"""
    try:
        action()
    except RuntimeError as error:
        text = str(error)
        assert all(word in text for word in words), text
        return "Traceback" not in text and len(text.strip().splitlines()) == 1
    return False
