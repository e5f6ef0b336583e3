"""Kinds of joints, one file each; their constraints are rows of one type."""
