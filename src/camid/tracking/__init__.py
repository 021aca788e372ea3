"""Marker positions from video: decode → choose the marker → follow it → measure it → report, a module a step."""
