"""Assumption A1: shift of the centre of mass by a large marker."""
