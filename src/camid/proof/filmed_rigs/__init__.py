"""Rendered clips of rigs with something concealed, by code that shares nothing with the tool, and what that finds."""
