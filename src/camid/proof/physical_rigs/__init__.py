"""Rigs of named physical constants, made by code that shares nothing with the tool, and what it states of them."""
