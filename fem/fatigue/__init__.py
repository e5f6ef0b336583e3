"""Fatigue: cycles, S-N curves, damage, critical planes, casting defects, rolling contact."""
