"""Rest, stages, integration."""
