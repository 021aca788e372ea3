"""One module per command: load, call, write. :mod:`camid.cli` parses and prints; here nothing is computed."""
