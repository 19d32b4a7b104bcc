"""Blocks of a quad mesh: conforming or with T-junctions, how they join, how good they are."""
