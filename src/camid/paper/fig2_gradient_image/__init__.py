"""Fig. 2: gradient image and centre of mass."""
