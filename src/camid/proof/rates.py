"""Rates, medians and their intervals over many scores."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.proof.scoring import COVERAGE

STRENGTHS = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0)  # edges of the bins, multiples of the detectable size
WEIGHTS = tuple(i / 10.0 for i in range(11))  # edges of the bins of stated weights


def rate(successes: int, trials: int) -> tuple[float, float, float]:
    """Share with its 95 % interval by Wilson (J. Am. Stat. Assoc. 22, 1927); NaN without trials."""
    from scipy.stats import binomtest

    if trials == 0:
        return np.nan, np.nan, np.nan
    interval = binomtest(successes, trials).proportion_ci(COVERAGE, method="wilson")
    return successes / trials, float(interval.low), float(interval.high)


def median(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Median with its 95 % interval by order statistics (Conover 1999, section 3.2); NaN bounds where data are few."""
    from scipy.stats import quantile_test

    values = values[~np.isnan(values)]
    if not len(values):
        return np.nan, np.nan, np.nan
    interval: Any = quantile_test(values, p=0.5).confidence_interval(COVERAGE)
    return float(np.median(values)), float(interval.low), float(interval.high)


def by_strength(scores: pd.DataFrame) -> pd.DataFrame:
    """Rates of detection, naming and placing against the multiple of the detectable size, single effects only.

    Returns
    -------
    DataFrame
        One row per bin and rate: ``low``, ``high`` (edges), ``multiple`` (geometric mean of those in the bin), ``rate``
        (its name), ``share``, ``from``, ``to``, ``recordings``.
    """
    single = scores[(scores["kind"] == "single") & scores["multiple"].notna()]
    rows = []
    for low, high in pairwise(STRENGTHS):
        # A solved strength may end a little outside the range that it was drawn from: the outer bins are open.
        start = low if low != STRENGTHS[0] else -np.inf
        end = high if high != STRENGTHS[-1] else np.inf
        part = single[(single["multiple"] >= start) & (single["multiple"] < end)]
        if part.empty:
            continue
        for name in ("detected", "in_class", "top", "place_in_class"):
            share, lower, upper = rate(int(part[name].sum()), len(part))
            middle = float(np.exp(np.log(part["multiple"]).mean()))
            rows.append(
                {"low": low, "high": high, "multiple": middle, "rate": name}
                | {"share": share, "from": lower, "to": upper, "recordings": len(part)}
            )
    return pd.DataFrame(rows, columns=["low", "high", "multiple", "rate", "share", "from", "to", "recordings"])


def reliability(weights: pd.DataFrame) -> pd.DataFrame:
    """Frequency of being the truth against the stated weight, all class members.

    Returns
    -------
    DataFrame
        ``low``, ``high`` (edges), ``weight`` (mean of those in the bin), ``share``, ``from``, ``to``, ``members``.
    """
    rows = []
    for low, high in pairwise(WEIGHTS):
        last = high == WEIGHTS[-1]
        part = weights[(weights["weight"] >= low) & ((weights["weight"] < high) | last)]
        if part.empty:
            continue
        share, start, end = rate(int(part["right"].sum()), len(part))
        rows.append(
            {"low": low, "high": high, "weight": float(part["weight"].mean())}
            | {"share": share, "from": start, "to": end, "members": len(part)}
        )
    return pd.DataFrame(rows, columns=["low", "high", "weight", "share", "from", "to", "members"])


def largest_difference_by_chance(table: pd.DataFrame, level: float = 0.95) -> float:
    """Largest difference of stated and true over all bins that weights which are exactly right keep below.

    How many of a bin are right is binomial with the bin's mean weight then, which spreads a little more than the sum of
    the single draws does.

    Parameters
    ----------
    table : DataFrame
        From :func:`reliability`, the bins that count.
    level : float
        Probability with which they keep below.

    Returns
    -------
    float
        In units of the weights; not a number without a bin.
    """
    from scipy.optimize import brentq
    from scipy.stats import binom

    if table.empty:
        return float("nan")
    members, weight = table["members"].to_numpy(), table["weight"].to_numpy()

    def excess(difference: float) -> float:
        low, high = members * (weight - difference), members * (weight + difference)
        inside = binom.cdf(np.floor(high), members, weight) - binom.cdf(np.ceil(low) - 1, members, weight)
        return float(np.prod(inside)) - level

    return float(brentq(excess, 0.0, 1.0, xtol=1e-4))


def coverage(parameters: pd.DataFrame) -> pd.DataFrame:
    """Coverage of the 95 % intervals, one row per parameter: ``id``, ``parameter``, ``share``, …, ``intervals``."""
    rows = []
    for (identifier, name), part in parameters.groupby(["id", "parameter"], sort=True):
        share, start, end = rate(int(part["covered"].sum()), len(part))
        error = (part["value"] - part["true"]).abs() / part["true"].abs()
        rows.append(
            {"id": identifier, "parameter": name, "share": share, "from": start, "to": end, "intervals": len(part)}
            | {"median_relative_error": float(error.median())}
        )
    columns = ["id", "parameter", "share", "from", "to", "intervals", "median_relative_error"]
    return pd.DataFrame(rows, columns=columns)
