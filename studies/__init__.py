"""A script a paper: its cases, their runs, its reported numbers beside the computed ones, its figures."""

DURATION = 10.0  # s, simulated in the rigid studies of the papers; the track travels 0.75 m in it
CYCLE_DURATION = 40.0  # s, propel and one loading cycle of the S-paper
