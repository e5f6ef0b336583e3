"""Elastic body of tetrahedra: mesh, matrices, supports, loads and its Craig-Bampton reduction."""
