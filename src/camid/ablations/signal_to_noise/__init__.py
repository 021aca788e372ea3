"""Errors against the signal-to-noise ratio."""
