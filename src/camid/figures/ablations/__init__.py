"""Drawings of the ablations: one module each, with ``draw(table)`` that returns the figure and the plotted numbers."""
