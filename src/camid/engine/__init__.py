"""The compiled simulation of a whole chain with any effects."""
