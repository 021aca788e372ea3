"""report.html and what is printed of a diagnosis."""
