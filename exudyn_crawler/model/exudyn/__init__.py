"""The tables of a case as Exudyn's own bodies, joints, loads and contacts."""
