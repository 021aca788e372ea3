"""Errors over the Cramér–Rao bound, many noise seeds a period."""
