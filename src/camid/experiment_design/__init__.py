"""The next experiment: it tells apart what a diagnosis leaves possible, or determines what is undetermined."""
