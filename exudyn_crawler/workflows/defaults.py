"""What studies take where nothing else is said; command lines show it without loading the engine."""

from pathlib import Path

DURATION = 10.0
"""s, simulated in the rigid studies of the papers."""
RESULTS = Path("results")
"""Folder of the studies' folders."""
