"""The only builders of Exudyn systems: shoes, links, ground, loads, drive and contact of a case."""
