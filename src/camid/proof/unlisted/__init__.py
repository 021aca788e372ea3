"""Rigs under laws that the catalogue does not hold, made by code that shares nothing with the tool, and its answers."""
