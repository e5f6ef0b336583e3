"""Results of a run as named arrays: the history and all that is computed from it."""
