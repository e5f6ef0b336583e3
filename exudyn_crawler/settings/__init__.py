"""Typed values in TOML for any class: fields, units, reading, errors, constraints. Knows no crawler."""
