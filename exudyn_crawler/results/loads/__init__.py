"""Actions on a shoe, and coordinates of its unit loads."""
