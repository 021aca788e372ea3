"""Rates, medians and their intervals over many scores, and the table that holds them against the targets."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.concealed.scoring import COLOURED_NOISE, COVERAGE, STRONG

STRENGTHS = (0.3, 1.0, 3.0, 10.0, 30.0, 101.0)  # edges of the bins, multiples of the detectable size
WEIGHTS = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0)  # edges of the bins of stated weights
HIGH_SNR = 30.0  # dB: between the 20 and the 40 dB of the recordings with an effect outside the catalogue


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
        A row a bin and rate: ``low``, ``high`` (edges), ``multiple`` (geometric mean of those in the bin), ``rate``
        (its name), ``share``, ``from``, ``to``, ``recordings``.
    """
    single = scores[(scores["kind"] == "single") & scores["multiple"].notna()]
    rows = []
    for low, high in pairwise(STRENGTHS):
        # A solved strength may end a little below the range that it was drawn from; it belongs to the first bin.
        above = single["multiple"] >= low if low != STRENGTHS[0] else True
        part = single[above & (single["multiple"] < high)]
        if part.empty:
            continue
        for name in ("detected", "in_class", "top", "place_in_class"):
            share, start, end = rate(int(part[name].sum()), len(part))
            middle = float(np.exp(np.log(part["multiple"]).mean()))
            rows.append(
                {"low": low, "high": high, "multiple": middle, "rate": name}
                | {"share": share, "from": start, "to": end, "recordings": len(part)}
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


def coverage(parameters: pd.DataFrame) -> pd.DataFrame:
    """Coverage of the stated 95 % intervals, a row a parameter: ``id``, ``parameter``, ``share``, …, ``intervals``."""
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


@dataclass(frozen=True)
class Line:
    """A line of the table of targets.

    Attributes
    ----------
    quantity, title, unit : str
        Name for tolerances, words for readers, unit of the values.
    value, low, high : float
        Measured, with its 95 % interval.
    count : int
        Recordings (or intervals, or effects) behind it.
    at_least, at_most : float or None
        The target.
    """

    quantity: str
    title: str
    unit: str
    value: float
    low: float
    high: float
    count: int
    at_least: float | None = None
    at_most: float | None = None

    @property
    def met(self) -> bool | None:
        """Whether the measured value meets the target; None without a target."""
        if self.at_least is None and self.at_most is None:
            return None
        high = np.inf if self.at_most is None else self.at_most
        return bool((-np.inf if self.at_least is None else self.at_least) <= self.value <= high)


def _share(quantity: str, title: str, successes: pd.Series, **target: float) -> Line:
    value, low, high = (100.0 * v for v in rate(int(successes.sum()), len(successes)))
    return Line(quantity, title, "%", value, low, high, len(successes), **target)


def _median(quantity: str, title: str, unit: str, values: pd.Series, **target: float) -> Line:
    known = values.dropna().to_numpy(float)
    return Line(quantity, title, unit, *median(known), len(known), **target)


def lines(scores: pd.DataFrame, parameters: pd.DataFrame, run_times: pd.DataFrame | None = None) -> list[Line]:
    """Every measured rate beside its target.

    Parameters
    ----------
    scores : DataFrame
        A row a recording: :func:`camid.concealed.scoring.score`, with ``share_same_kind`` and
        ``share_double_amplitude``.
    parameters : DataFrame
        From :func:`camid.concealed.scoring.parameter_rows`.
    run_times : DataFrame, optional
        ``seconds``.
    """
    kind = scores["kind"]
    coloured = (kind == "single") & (scores["truth"] == COLOURED_NOISE)
    single = scores[(kind == "single") & (scores["multiple"] >= STRONG)]
    both = scores[(kind == "several") & (scores["strong"] >= 2)]
    modelled = scores[kind.isin(["single", "several"]) & scores["repeatable"] & (scores["multiple"] >= STRONG)]
    outside = scores[kind == "outside"]
    above = f"above {STRONG:g} × the detectable size"
    found = [
        _share(
            "false_alarms",
            "nothing missing: false alarms",
            scores[kind == "none"]["false_alarm"],
            at_most=100.0 / 200.0,
        ),
        _share(
            "false_alarms_invisible",
            "effect that cannot show: false alarms",
            scores[kind == "invisible"]["false_alarm"],
        ),
        _share(
            "coloured_noise_alone", "coloured noise alone: taken for something else", scores[coloured]["false_alarm"]
        ),
        _share("detected", f"{above}: detected", single["detected"]),
        _share("named_top", f"{above}: named first", single["top"]),
        _share("named_in_class", f"{above}: named or in a class of at most four", single["in_class"], at_least=95.0),
        _share("place_top", f"{above}: place right, strictly", single["place_top"]),
        _share("place", f"{above}: place right", single["place_in_class"], at_least=95.0),
        _share("wrong_names", f"{above}: with a wrong name besides or instead", single["wrong_names"] > 0),
        _share("several_top", "two or more above that size: all named first", both["strong_top"] == both["strong"]),
        _share(
            "several_in_class",
            "two or more above that size: all named or in a class",
            both["strong_in_class"] == both["strong"],
            at_least=80.0,
        ),
        *(
            _share(
                f"outside_{level}",
                f"outside the catalogue, {level} dB: confidently wrong",
                outside[(outside["snr_db"] >= HIGH_SNR) == (level == 40)]["confidently_wrong"],
                at_most=limit,
            )
            for level, limit in ((40, 20.0), (20, 40.0))
        ),
        *(
            _median(
                f"recovered_share_{name}",
                f"{above}: share of the error recovered, held out, {words} (median)",
                "1",
                modelled[f"share_{name}"],
                at_least=0.95,
            )
            for name, words in (("same_kind", "same kind"), ("double_amplitude", "twice the amplitude"))
        ),
        _share(
            "coverage",
            "95 % intervals of parameters that hold the truth",
            parameters["covered"],
            at_least=90.0,
            at_most=98.0,
        ),
    ]
    if run_times is not None:
        seconds = run_times["seconds"]
        largest = float(seconds.max())
        found += [
            _median("run_time", "run time a recording (median)", "s", seconds, at_most=3.0),
            Line(
                "run_time_largest",
                "run time a recording (largest)",
                "s",
                largest,
                np.nan,
                np.nan,
                len(seconds),
                at_most=10.0,
            ),
        ]
    return found


def quantities(found: list[Line], target: str) -> pd.DataFrame:
    """The table as quantities that tolerances can guard: ``target``, ``quantity``, ``value``, ``unit``."""
    rows = [{"target": target, "quantity": q.quantity, "value": q.value, "unit": q.unit} for q in found]
    return pd.DataFrame(rows)


def to_markdown(found: list[Line], stamp: str) -> str:
    """The table for README.md, with a line that says what it was computed from."""

    def number(value: float, unit: str) -> str:
        return f"{value:.1f} %" if unit == "%" else f"{value:.2f} s" if unit == "s" else f"{value:.3f}"

    def target(line: Line) -> str:
        if line.met is None:
            return "–"
        low, high = line.at_least, line.at_most
        if low is not None and high is not None:
            return f"{low:g} to {high:g} {line.unit}"
        sign, bound = ("≥", low) if low is not None else ("≤", high)
        return f"{sign} {bound:g}{'' if line.unit == '1' else ' ' + line.unit}"

    table = []
    for line in found:
        known = np.isfinite(line.low) and np.isfinite(line.high)
        interval = f"{number(line.low, line.unit)} to {number(line.high, line.unit)}" if known else "–"
        measured = number(line.value, line.unit) if np.isfinite(line.value) else "–"
        met = {True: "yes", False: "**no**", None: "–"}[line.met] if np.isfinite(line.value) else "–"
        table.append(
            {"": line.title, "target": target(line), "measured": measured, "95 % interval": interval, "of": line.count}
            | {"met": met}
        )
    return f"{pd.DataFrame(table).to_markdown(index=False, disable_numparse=True)}\n\n{stamp}\n"
