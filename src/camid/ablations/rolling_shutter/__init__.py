"""Rolling shutter: the marker's row decides the time."""
