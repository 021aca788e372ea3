"""What the user believes of the chain: the simulation file, read, checked and written."""
