"""Case files: reading, writing, changing and comparing cases."""
