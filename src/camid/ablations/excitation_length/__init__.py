"""Errors against the length of the excitation."""
