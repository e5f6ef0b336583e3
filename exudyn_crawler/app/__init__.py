"""Page to work in: a machine is put together, seen, run and asked; it calls what the commands call."""
