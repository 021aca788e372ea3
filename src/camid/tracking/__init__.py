"""Marker positions from video: decode → choose the marker → follow it → measure it → report, one module per step."""
