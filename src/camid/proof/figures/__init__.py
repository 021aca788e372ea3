"""Figures of the sealed proof, one module per figure: ``draw`` takes scores and returns the figure and its numbers."""
