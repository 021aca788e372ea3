"""Fig. 7: errors against the sampling period."""
