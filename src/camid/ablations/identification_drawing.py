"""What the figures of the ablations of identification have in common."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

# Percent; finer digits are those of the stopping rule and of the processor, and no table of a figure prints them.
RESOLUTION = 1e-5
PARAMETERS = ("b0", "a1", "a0")
SYMBOLS = {"b0": "$b_0$", "a1": "$a_1$", "a0": "$a_0$"}
ERROR_LABELS = {p: f"error in {symbol} (%)" for p, symbol in SYMBOLS.items()}


def printed(table: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """The table with the digits of some columns that belong to stopping rules and processors rounded away."""
    result = table.copy()
    result[list(columns)] = (result[list(columns)] / RESOLUTION).round() * RESOLUTION + 0.0
    return result
