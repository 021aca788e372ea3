"""The excitation of section 3.2 of the paper."""

from __future__ import annotations

import numpy as np
import pandas as pd

from camid.chain.excitation import pseudo_random_binary_sequence


def excitation_table(order: int, amplitude: float) -> pd.DataFrame:
    """The pseudo-random binary sequence of section 3.2.

    Returns
    -------
    DataFrame
        Columns ``k`` and ``u``.
    """
    signal = pseudo_random_binary_sequence(order, amplitude=amplitude)
    return pd.DataFrame({"k": np.arange(len(signal)), "u": signal})
