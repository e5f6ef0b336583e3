"""Shoes of makers' files: bores, axes, unit and surfaces, by the shape of the boundary alone."""
