"""Two tables on two clocks, such as a clip and the log of a drive, become one recording."""
