"""Equations of motion of a whole track as compiled functions, and Newton's method for them."""
