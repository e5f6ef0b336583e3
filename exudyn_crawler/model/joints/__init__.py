"""Kinds of joints, a file each, which give their constraints as rows of one type."""
