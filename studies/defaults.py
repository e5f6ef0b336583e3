"""What studies take where nothing else is said; command lines show it without loading the engine."""

from pathlib import Path

DURATION = 10.0
"""s, simulated in the rigid studies of the papers."""
CYCLE_DURATION = 40.0
"""s, propel and one loading cycle of the S-paper."""
RESULTS = Path("results")
"""Folder of the studies' folders."""
