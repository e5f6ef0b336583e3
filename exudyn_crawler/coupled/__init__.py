"""Tracks in a user's own model of Exudyn: its bodies stand on a machine, one Newton's method solves both."""
