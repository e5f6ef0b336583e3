"""Force elements of the compiled equations, one file for each kind."""
