"""Assessment of a machine by formulas: pressure, tipping, travel, load cases and utilisation."""
