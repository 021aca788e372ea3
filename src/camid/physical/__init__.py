"""Plants as an engineer writes them down: named constants, expressions of them, and what a recording says of each."""
