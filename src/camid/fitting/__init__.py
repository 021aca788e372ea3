"""Coefficients and effects fitted together: what simulate, identify and diagnose share."""
