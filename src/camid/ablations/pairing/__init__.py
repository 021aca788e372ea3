"""Bias under wrong pairings of input and output samples."""
