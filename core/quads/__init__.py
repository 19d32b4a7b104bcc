"""The quad mesh: lengths in quads, connectivity, places on the surface, smoothing, quality."""
