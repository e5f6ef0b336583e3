"""Parameters of a case, with units and bounds."""
