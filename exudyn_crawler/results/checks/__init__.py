"""Check cases of a shoe: static loads in balance, without a run."""
