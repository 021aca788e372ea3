"""Bias under a wrong hold or sensor, and the warning of it."""
