"""Any polygons become an oriented manifold of triangles in an order of its own."""
