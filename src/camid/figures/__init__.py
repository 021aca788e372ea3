"""Drawing: a module a figure, with ``draw(...)`` returning figure and plotted numbers. Nothing is computed here."""
