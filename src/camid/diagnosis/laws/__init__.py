"""Laws without a name: learned, in the place of names, as formulas, and as files."""
