"""What acts on a shoe, and what that loads."""
