"""Creases, charts, curvature and jagged boundaries: what binds the field besides boundaries."""
