"""Assumption A4: a speed that changes within the exposure."""
