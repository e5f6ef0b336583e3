"""History of a run: named variables, catalogue of quantities, files."""
