"""Short formulas for learned laws: a dictionary of forms, the search among them, and the words for a curve."""
