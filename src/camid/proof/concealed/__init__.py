"""Recordings with a concealed effect, made from the mechanics by code that knows nothing of the tool it judges."""
