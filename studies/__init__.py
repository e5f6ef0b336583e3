"""Studies, a script for each paper: cases, runs, reported numbers beside computed ones, figures."""

DURATION = 10.0  # s, duration of the papers' rigid studies; the track travels 0.75 m
CYCLE_DURATION = 40.0  # s, duration of propel and one loading cycle of the S-paper
