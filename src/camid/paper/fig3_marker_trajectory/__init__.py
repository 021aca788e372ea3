"""Fig. 3: measured and modelled trajectories."""
