"""Run of a built system up to its history: rest, stages, integration, checkpoints and the run's folder."""
