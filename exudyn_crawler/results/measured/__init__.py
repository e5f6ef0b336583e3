"""Measured series: soils fitted to tests, and runs beside what was measured."""
