"""Figures, pictures, animations, tables and pages of results: this room draws and computes nothing."""
