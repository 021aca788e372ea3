"""What is left of a residual: where it sits, whether it is noise, and which."""
