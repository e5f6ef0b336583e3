"""Actions on a shoe, and the coordinates that they load."""
