"""Files of meshes, reduced bodies and results, and the cache of reductions."""
