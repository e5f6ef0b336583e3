"""Life of shoes in machine hours."""
