"""Force elements of the compiled equations, a file a kind."""
