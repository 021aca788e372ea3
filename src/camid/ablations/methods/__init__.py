"""Error over the Cramér–Rao bound and failures of every method."""
