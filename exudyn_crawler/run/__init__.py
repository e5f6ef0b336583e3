"""From a built system to a history: rest, stages, integration, checkpoints and the run's folder."""
