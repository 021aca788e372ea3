"""Clips and drive logs on two clocks, made by code that shares nothing with the tool, and what that states."""
