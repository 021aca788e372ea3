"""Grey-level against gradient centroid, from ideal to bad images."""
