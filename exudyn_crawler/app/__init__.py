"""Page to work in: a machine is assembled, shown, run and evaluated with the code of the commands."""
