"""Bias against the exposure under five declarations of the sensor."""
