"""Time of camid's fit against the number of samples."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.identification import camid_fit
from benchmarks.report import Report, number
from benchmarks.task import SCALING, excitation, generator, nominal, plant, record, truth
from benchmarks.timing import timed
from camid.chain.acquisition import Acquisition
from camid.identification.accuracy import cramer_rao_bound

PERIOD = 0.1  # s
LENGTHS = (511, 1_000, 3_162, 10_000, 31_623, 100_000, 316_228, 1_000_000)
SAMPLES_IN_ALL = 3_000_000  # per length, at most: longer recordings are fitted less often
MOST_REPEATS, FEWEST_REPEATS = 100, 5


def measure(length: int, repeats: int) -> dict[str, float]:
    """Median time of a warm fit, and how far it is from the truth in standard deviations of the bound."""
    recording = record(excitation(length), PERIOD, generator(SCALING, length))
    camid_fit(recording, nominal())
    fits = [timed(lambda: camid_fit(recording, nominal())) for _ in range(repeats)]
    bound = cramer_rao_bound(plant(), recording.signal, Acquisition(PERIOD), recording.noise_variance)
    return {
        "samples": length,
        "fits": repeats,
        "milliseconds": 1e3 * float(np.median([seconds for _, seconds in fits])),
        "largest_standardised_error": float(np.max(np.abs(fits[0][0] - truth()) / np.sqrt(np.diag(bound)))),
    }


def exponent(table: pd.DataFrame, shortest: float) -> float:
    """Slope of log time over log samples by least squares, from ``shortest`` samples on."""
    part = table[table["samples"] >= shortest]
    return float(np.polyfit(np.log(part["samples"]), np.log(part["milliseconds"]), 1)[0])


def run(lengths: tuple[int, ...] = LENGTHS) -> Report:
    """Fit recordings of the same plant of growing length."""
    repeats = [min(max(SAMPLES_IN_ALL // length, FEWEST_REPEATS), MOST_REPEATS) for length in lengths]
    table = pd.DataFrame([measure(length, count) for length, count in zip(lengths, repeats, strict=True)])
    table["microseconds_per_sample"] = 1e3 * table["milliseconds"] / table["samples"]
    last = exponent(table, 0.099 * max(lengths))
    shown = pd.DataFrame(
        {
            "samples": [f"{n:,}".replace(",", " ") for n in table["samples"]],
            "fits": [str(n) for n in table["fits"]],
            "ms per fit": [number(t) for t in table["milliseconds"]],
            "µs per sample": [number(t) for t in table["microseconds_per_sample"]],
            "largest error / its bound": [number(e, 2) for e in table["largest_standardised_error"]],
        }
    )
    return Report(
        "scaling",
        "Time of a fit against the number of samples",
        f"camid, started from a nominal plant 10 % off, T = {PERIOD:g} s, noise of 10 dB, median over the fits; the "
        "input is a sufficiently long PRBS, cut to length. Largest error / its bound: the largest of b0, a1 and a0, in "
        "standard deviations by the Cramér–Rao bound, for one noise sample. "
        f"**Over the last decade the time grows as N^{last:.2f}.**",
        table.assign(exponent_of_last_decade=last),
        shown,
    )
