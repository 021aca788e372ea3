"""Identification past the Shannon limit."""
