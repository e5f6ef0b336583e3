"""Stresses of flexible shoes of a history."""
