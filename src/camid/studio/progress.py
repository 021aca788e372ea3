"""How a command says its progress to the program that started it."""

from __future__ import annotations

# With this variable set to "lines", each step is a line on the error stream that starts with the prefix.
VARIABLE, LINES = "CAMID_PROGRESS", "lines"
PREFIX = "camid: progress: "
