"""Errors over the Cramér–Rao bound, many noise seeds per period."""
