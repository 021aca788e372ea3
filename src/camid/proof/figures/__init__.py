"""Figures of the sealed proof, a module each: ``draw`` takes scores and returns the figure and its numbers."""
