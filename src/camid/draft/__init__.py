"""A first simulation from a look at recordings: their layout, the roles of their columns, a plant to start from."""
