"""Assumption A2: a path that crosses or covers itself in an exposure."""
