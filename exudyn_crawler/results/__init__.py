"""What a run leaves, as named arrays: the history and all that is computed from it."""
