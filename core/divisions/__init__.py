"""Blocks divided anew: locked counts, grading to walls, the coarse block mesh."""
