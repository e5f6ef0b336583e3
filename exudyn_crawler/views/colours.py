"""Colours that all pictures share: one thing has one colour everywhere."""

GROUND, GROUND_EDGE = "#e2d3b3", "#8a7748"
SHOE, FLEXIBLE_SHOE, SHOE_EDGE = "#9fb1bd", "#d98c3f", "#3c4a54"
CONTACT_FORCE = "#1f4fd8"
STRESS_MAP = "YlOrRd"
"""Colour map of stresses: pale where there is little, so that shading shows the shape."""
HEAVE_MAP = "cividis"
"""Colour map of the units' heave."""
