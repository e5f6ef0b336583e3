"""A script a paper: its cases, their runs, its reported numbers beside the computed ones, its figures."""
