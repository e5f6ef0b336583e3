"""Studies from the case to the files they leave; scripts and the command line call these."""
