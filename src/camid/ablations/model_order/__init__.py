"""Choice and consequences of the number of poles."""
