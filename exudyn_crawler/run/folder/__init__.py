"""Folder of a run: checkpoints, history, record, log."""
