"""Constants of the diagnosis's weights, estimated from rigs with concealed effects that neither proof nor tests use."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.diagnosis.weights import Comparison, Constants, Member, log_likelihood, weights
from camid.proof.concealed.generator import Case, make
from camid.proof.rates import rate, reliability
from camid.proof.sealed_files import HELD_OUT, RECORDING, SIMULATION, write_case

Array = NDArray[np.float64]

# Where the search starts, and how far from there a constant is likely to be: logits of a probability, logarithms of
# positive constants. It keeps those that few recordings tell anything of where they are.
START = Constants(0.3, 0.05, 10.0, 1.0, 0.3, -0.2, 0.5, -3.0, 2.0)
PROBABILITIES, POSITIVE = ("other_law",), ("law_error", "unseen")
SPREAD = 2.0
EVALUATIONS = 6000
# Fall of what is minimised, in natural units for each comparison, from which another simplex is worth while.
SETTLED = 1e-4


def comparisons_of(cases: Iterable[Case]) -> list[dict[str, Any]]:
    """Diagnose recordings and keep what every effect that was named was compared with, beside the truth.

    Returns
    -------
    list of dict
        ``index``, ``truth`` (identifiers) and ``comparison`` (:class:`camid.diagnosis.weights.Comparison` as a dict).
    """
    return [row for case in cases for row in _rows(case, ())]


def comparisons_of_two(cases: Iterable[Case]) -> list[dict[str, Any]]:
    """The same of each recording and a second one with another input, of the same or twice the amplitude in turn."""
    return [row for case in cases for row in _rows(case, (HELD_OUT[case.index % len(HELD_OUT)],))]


def _rows(case: Case, further: tuple[str, ...]) -> list[dict[str, Any]]:
    """What the effects of one diagnosis were compared with; ``further`` are recordings that are held out otherwise."""
    import camid

    made = make(case)
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / folder for folder in ("recordings", "held_out", "truths")]
        write_case(case.index, made, *folders)
        own = [folder / str(case.index) for folder in folders]
        recordings = [own[0] / RECORDING, *(own[1] / f"{kind}.csv" for kind in further)]
        diagnosis = camid.diagnose(recordings, own[0] / SIMULATION, time_limit=None)
    truth = [effect["id"] for effect in made.truth["effects"]]
    return [
        {"index": case.index, "truth": truth, "comparison": asdict(finding.comparison)}
        for finding in diagnosis.findings
        if finding.comparison is not None
    ]


def read_comparisons(rows: Iterable[Mapping[str, Any]]) -> list[tuple[Comparison, set[str]]]:
    """What :func:`comparisons_of` kept, with the identifiers of what is there."""
    found = []
    for row in rows:
        content = dict(row["comparison"])
        content["members"] = tuple(Member(**member) for member in content["members"])
        found.append((Comparison(**content), set(row["truth"])))
    return found


def calibrate(comparisons: Sequence[tuple[Comparison, set[str]]]) -> Constants:
    """The constants that give the truth the largest weight, in the geometric mean.

    Parameters
    ----------
    comparisons : sequence of (Comparison, set of str)
        With the identifiers of what is there.

    Raises
    ------
    ValueError
        If there is nothing to learn from.
    """
    from scipy.optimize import minimize

    if not comparisons:
        raise ValueError("no effect was named in any recording: there is nothing to calibrate the weights with")
    start = _free(START)

    def loss(vector: Array) -> float:
        distance = float(np.sum(((vector - start) / SPREAD) ** 2)) / len(comparisons)
        return 0.5 * distance - log_likelihood(comparisons, _constants(vector))

    options: Any = {"maxfev": EVALUATIONS, "maxiter": EVALUATIONS}
    found = minimize(loss, start, method="Nelder-Mead", options=options)
    while True:  # a simplex that has shrunk to nothing may lie on a slope
        again = minimize(loss, found.x, method="Nelder-Mead", options=options)
        if again.fun >= found.fun - SETTLED:
            return _constants(found.x)
        found = again


def stated_and_true(comparisons: Sequence[tuple[Comparison, set[str]]], constants: Constants) -> pd.DataFrame:
    """Reliability of the weights: :func:`camid.proof.rates.reliability` over all names of all effects."""
    rows = [
        {"weight": weight, "right": name in truth}
        for comparison, truth in comparisons
        for name, weight in weights(comparison, constants)[0]
    ]
    return reliability(pd.DataFrame(rows))


def outside_stated_and_true(comparisons: Sequence[tuple[Comparison, set[str]]], constants: Constants) -> pd.DataFrame:
    """How often physics outside the catalogue, and not the names, is the truth of effects, beside what is stated.

    Parameters
    ----------
    comparisons : sequence of (Comparison, set of str)
    constants : Constants

    Returns
    -------
    DataFrame
        One row per group: ``left`` (nothing; something: more than noise is left), ``strongest`` (of its recordings),
        ``experiments``, ``effects``, ``stated`` (mean weight), ``true`` (how many), and their ``share`` with the 95 %
        interval (Wilson) ``from`` and ``to``.
    """
    rows = [
        {
            "left": "something" if comparison.left > 0.0 else "nothing",
            "strongest": comparison.strongest,
            "experiments": comparison.experiments,
            "stated": weights(comparison, constants)[1],
            "true": not any(name in truth for name, _ in weights(comparison, constants)[0]),
        }
        for comparison, truth in comparisons
        if not comparison.noise
    ]
    groups = []
    for keys, part in pd.DataFrame(rows).groupby(["left", "strongest", "experiments"]):
        share, low, high = rate(int(part["true"].sum()), len(part))
        groups.append(
            {
                **dict(zip(("left", "strongest", "experiments"), keys, strict=True)),
                "effects": len(part),
                "stated": float(part["stated"].mean()),
                "true": int(part["true"].sum()),
                "share": share,
                "from": low,
                "to": high,
            }
        )
    return pd.DataFrame(groups)


def _free(constants: Constants) -> Array:
    """Constants as numbers without bounds."""
    values = asdict(constants)
    for name in PROBABILITIES:
        values[name] = np.log(values[name] / (1.0 - values[name]))
    for name in POSITIVE:
        values[name] = np.log(values[name])
    return np.array(list(values.values()))


def _constants(vector: Array) -> Constants:
    values = dict(zip(asdict(START), vector.tolist(), strict=True))
    for name in PROBABILITIES:
        values[name] = float(1.0 / (1.0 + np.exp(-values[name])))
    for name in POSITIVE:
        values[name] = float(np.exp(values[name]))
    return Constants(**values)
