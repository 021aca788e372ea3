"""Fig. 4: Model #1, first version."""
