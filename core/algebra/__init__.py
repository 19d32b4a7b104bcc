"""Sparse linear systems, minimisation, choices: what knows nothing of surfaces."""
