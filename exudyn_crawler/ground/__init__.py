"""Ground contact as pure, compiled functions of numbers and arrays; nothing here knows Exudyn."""
