"""Wear of an undercarriage: work of its pairs over a duty, laws of wear, inspections, residual hours."""
