"""Drawing: one module a figure, each with ``draw(...) -> (figure, table of the plotted numbers)``. Nothing is computed here."""
