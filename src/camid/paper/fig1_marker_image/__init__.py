"""Fig. 1: exposed image of the fast marker and its trajectory."""
