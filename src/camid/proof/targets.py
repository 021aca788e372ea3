"""The table that holds every measured rate of the sealed proof against its target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from camid.number_text import SPACE, number, plain, span
from camid.proof.rates import largest_difference_by_chance, median, rate, reliability
from camid.proof.scoring import COLOURED_NOISE, STRONG

HIGH_SNR = 30.0  # dB: between the 20 and the 40 dB of the recordings with an effect outside the catalogue
FEWEST_MEMBERS = 20  # class members in a bin of stated weights that counts
NAMED = 96.0  # per cent of strong single effects that are named or in a class, asked
MEDIAN_TIME, LARGEST_TIME = 3.0, 15.0  # seconds of a diagnosis, asked
ABOVE = f"above {plain(STRONG)} × the detectable size"


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
        Recordings (or intervals, or effects) that it is based on.
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


def share_line(quantity: str, title: str, successes: pd.Series, **target: float) -> Line:
    """A line with the share of successes in per cent."""
    value, low, high = (100.0 * v for v in rate(int(successes.sum()), len(successes)))
    return Line(quantity, title, "%", value, low, high, len(successes), **target)


def median_line(quantity: str, title: str, unit: str, values: pd.Series, **target: float) -> Line:
    """A line with the median of the values that are known."""
    known = values.dropna().to_numpy(float)
    return Line(quantity, title, unit, *median(known), len(known), **target)


def lines(
    scores: pd.DataFrame,
    parameters: pd.DataFrame,
    run_times: pd.DataFrame | None = None,
    weights: pd.DataFrame | None = None,
) -> list[Line]:
    """Every measured rate beside its target.

    Parameters
    ----------
    scores : DataFrame
        One row per recording: :func:`camid.proof.scoring.score`, with ``share_same_kind`` and
        ``share_double_amplitude``.
    parameters : DataFrame
        From :func:`camid.proof.scoring.parameter_rows`.
    run_times : DataFrame, optional
        ``seconds``.
    weights : DataFrame, optional
        From :func:`camid.proof.scoring.weight_rows`.
    """
    # An effect may be large alone and beside others not act at all.
    alone = _several(scores, "strong_alone", ", each alone")
    found = [*naming(scores), *alone, *_outside(scores), *model(scores, parameters)]
    found += [] if weights is None else calibration(weights)
    return found if run_times is None else [*found, *run_time_lines(run_times["seconds"])]


def naming(scores: pd.DataFrame) -> list[Line]:
    """False alarms, and effects detected, named and placed."""
    kind = scores["kind"]
    coloured = (kind == "single") & (scores["truth"] == COLOURED_NOISE)
    single = scores[(kind == "single") & (scores["multiple"] >= STRONG)]
    return [
        share_line(
            "false_alarms",
            "nothing missing: false alarms",
            scores[kind == "none"]["false_alarm"],
            at_most=100.0 / 200.0,
        ),
        share_line(
            "false_alarms_invisible",
            "effect that cannot show: false alarms",
            scores[kind == "invisible"]["false_alarm"],
        ),
        share_line(
            "coloured_noise_alone", "coloured noise alone: taken for something else", scores[coloured]["false_alarm"]
        ),
        share_line("detected", f"{ABOVE}: detected", single["detected"]),
        share_line("named_top", f"{ABOVE}: named first", single["top"]),
        share_line(
            "named_in_class", f"{ABOVE}: named or in a class of at most four", single["in_class"], at_least=NAMED
        ),
        share_line("place_top", f"{ABOVE}: place right, strictly", single["place_top"]),
        share_line("place", f"{ABOVE}: place right", single["place_in_class"], at_least=96.0),
        share_line("wrong_names", f"{ABOVE}: with a wrong name besides or instead", single["wrong_names"] > 0),
        *_several(scores, two=85.0, three=70.0),
    ]


def _several(scores: pd.DataFrame, size: str = "strong", words: str = "", **targets: float) -> list[Line]:
    """Recordings with two and with three strong effects of which all are named, by the sizes of a column."""
    found = []
    for count, called in ((2, "two"), (3, "three")):
        part = scores[(scores["kind"] == "several") & (scores[size] == count)]
        found.append(
            share_line(
                f"several_in_class_{count}{size.removeprefix('strong')}",
                f"{called} above that size{words}: all named or in a class",
                part[f"{size}_in_class"] == count,
                **({"at_least": targets[called]} if called in targets else {}),
            )
        )
    return found


def _outside(scores: pd.DataFrame) -> list[Line]:
    """What is said of effects that the catalogue does not hold."""
    outside = scores[scores["kind"] == "outside"]
    return [
        *(
            share_line(
                f"outside_{level}",
                f"outside the catalogue, {level} dB: confidently wrong",
                outside[(outside["snr_db"] >= HIGH_SNR) == (level == 40)]["confidently_wrong"],
                at_most=limit,
            )
            for level, limit in ((40, 20.0), (20, 40.0))
        ),
        *(
            share_line(
                f"outside_{level}_strong",
                f"outside the catalogue, {level} dB, {ABOVE}: confidently wrong",
                outside[((outside["snr_db"] >= HIGH_SNR) == (level == 40)) & (outside["multiple"] >= STRONG)][
                    "confidently_wrong"
                ],
            )
            for level in (40, 20)
        ),
    ]


def recovered_line(quantity: str, words: str, shares: pd.Series, target: float | None) -> Line:
    """Median of the shares of the error that are recovered; ``{}`` in the words stands for that, None for no target."""
    label = f"{ABOVE}{words.format('share of the error recovered')} (median)"
    return median_line(quantity, label, "1", shares, **({} if target is None else {"at_least": target}))


def model(scores: pd.DataFrame, parameters: pd.DataFrame) -> list[Line]:
    """What the model of a diagnosis predicts, and its parameters."""
    strong = scores[scores["repeatable"] & (scores["multiple"] >= STRONG)]
    with_effects = strong["kind"].isin(["single", "several"])
    groups = {
        "": (strong[with_effects], "", 0.95),
        "_inexact": (strong[with_effects & strong["inexact"]], ", law not exact", 0.9),
        "_outside": (strong[strong["kind"] == "outside"], ", outside the catalogue", None),
    }
    return [
        *(
            recovered_line(
                f"recovered_share_{name}{group}", f"{which}: {{}}, held out, {words}", part[f"share_{name}"], target
            )
            for group, (part, which, target) in groups.items()
            for name, words in (("same_kind", "same kind"), ("double_amplitude", "twice the amplitude"))
        ),
        share_line(
            "coverage",
            "95 % intervals of parameters that hold the truth",
            parameters["covered"],
            at_least=92.0,
            at_most=98.0,
        ),
    ]


def calibration(weights: pd.DataFrame) -> list[Line]:
    """How far stated weights are from the frequency of being right."""
    table = reliability(weights)
    table = table[table["members"] >= FEWEST_MEMBERS]
    worst = 100.0 * float((table["share"] - table["weight"]).abs().max()) if len(table) else np.nan
    brier = float(((weights["weight"] - weights["right"]) ** 2).mean())
    words = f"stated weights: largest difference from what is true, of ten bins with {FEWEST_MEMBERS} cases or more"
    exact = 100.0 * largest_difference_by_chance(table)
    by_chance = "the same of weights that are exactly right: exceeded in one in twenty samples of this size"
    return [
        Line("reliability_by_chance", by_chance, "points", exact, np.nan, np.nan, len(weights)),
        Line("reliability", words, "points", worst, np.nan, np.nan, len(weights), at_most=7.0),
        Line("brier", "stated weights: Brier score", "1", brier, np.nan, np.nan, len(weights)),
    ]


def run_time_lines(seconds: pd.Series) -> list[Line]:
    """Median and largest, without a report."""
    largest = float(seconds.max())
    return [
        median_line(
            "run_time", "run time of a diagnosis without report.html (median)", "s", seconds, at_most=MEDIAN_TIME
        ),
        Line(
            "run_time_largest",
            "run time of a diagnosis without report.html (largest)",
            "s",
            largest,
            np.nan,
            np.nan,
            len(seconds),
            at_most=LARGEST_TIME,
        ),
    ]


def quantities(found: list[Line], target: str) -> pd.DataFrame:
    """The table as quantities that tolerances can guard: ``target``, ``quantity``, ``value``, ``unit``."""
    rows = [{"target": target, "quantity": q.quantity, "value": q.value, "unit": q.unit} for q in found]
    return pd.DataFrame(rows)


def to_markdown(found: list[Line], stamp: str) -> str:
    """The table as Markdown, with a line that says what it was computed from."""

    def measured(value: float, unit: str) -> str:
        return number(value) + ("" if unit == "1" else SPACE + unit)

    def target(line: Line) -> str:
        low, high, unit = line.at_least, line.at_most, "" if line.unit == "1" else line.unit
        if low is not None and high is not None:
            return span((low, high), unit)
        if low is not None:
            return f"≥ {plain(low, unit=unit)}"
        return "–" if high is None else f"≤ {plain(high, unit=unit)}"

    table = []
    for line in found:
        known = np.isfinite(line.low) and np.isfinite(line.high)
        interval = f"{measured(line.low, line.unit)} to {measured(line.high, line.unit)}" if known else "–"
        value = measured(line.value, line.unit) if np.isfinite(line.value) else "–"
        met = {True: "yes", False: "**no**", None: "–"}[line.met] if np.isfinite(line.value) else "–"
        table.append(
            {"": line.title, "target": target(line), "measured": value, "95 % interval": interval, "of": line.count}
            | {"met": met}
        )
    return f"{pd.DataFrame(table).to_markdown(index=False, disable_numparse=True)}\n\n{stamp}\n"
