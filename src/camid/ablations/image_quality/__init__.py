"""Assumption A3: coarse pixels, few bits and noise."""
