"""Solution of a run: rest, stages and integration."""
