"""Fig. 6: Bode diagrams of the three camera models."""
