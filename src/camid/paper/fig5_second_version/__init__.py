"""Fig. 5: Model #1, second version."""
