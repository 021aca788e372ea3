"""Benchmarks: time and error of camid side by side with other tools, in one run (`make bench`)."""
