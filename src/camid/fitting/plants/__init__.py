"""Kinds of plant, one class each: what differs between them in simulating, fitting, diagnosing and writing back."""
