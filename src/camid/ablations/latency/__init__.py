"""Bias against a latency that is not declared."""
