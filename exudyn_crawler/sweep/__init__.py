"""Sweeps: many runs of a case with varied values, planned, run on Dask and collected in a table."""
