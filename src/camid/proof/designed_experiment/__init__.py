"""Rigs whose first recording leaves several names, made by code that shares nothing with the tool, and what it says."""
