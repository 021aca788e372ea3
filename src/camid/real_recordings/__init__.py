"""Published recordings of real rigs, diagnosed."""
