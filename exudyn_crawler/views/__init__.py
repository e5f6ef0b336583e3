"""Figures, pictures, animations, tables and the report: they draw and print, and compute nothing."""
