"""Many runs of a case with some of its values varied: planned, run on Dask, gathered in a table."""
