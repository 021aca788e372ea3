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
from camid.proof.rates import reliability
from camid.proof.sealed_files import RECORDING, SIMULATION, write_case

Array = NDArray[np.float64]

# Where the search starts, and how far from there a constant is likely to be: logits of a probability, logarithms of
# positive constants. It keeps those that few recordings tell anything of where they are.
START = Constants(0.3, 0.05, 1.0, 0.3, -0.2, 0.5, -3.0, 2.0)
PROBABILITIES, POSITIVE = ("other_law",), ("law_error",)
SPREAD = 2.0
EVALUATIONS = 6000


def comparisons_of(cases: Iterable[Case]) -> list[dict[str, Any]]:
    """Diagnose recordings and keep what every effect that was named was compared with, beside the truth.

    Returns
    -------
    list of dict
        ``index``, ``truth`` (identifiers) and ``comparison`` (:class:`camid.diagnosis.weights.Comparison` as a dict).
    """
    import camid

    rows = []
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / folder for folder in ("recordings", "held_out", "truths")]
        for case in cases:
            made = make(case)
            write_case(case.index, made, *folders)
            files = [folders[0] / str(case.index) / file for file in (RECORDING, SIMULATION)]
            diagnosis = camid.diagnose(*files, time_limit=None)
            truth = [effect["id"] for effect in made.truth["effects"]]
            rows += [
                {"index": case.index, "truth": truth, "comparison": asdict(finding.comparison)}
                for finding in diagnosis.findings
                if finding.comparison is not None
            ]
    return rows


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

    found = minimize(loss, start, method="Nelder-Mead", options={"maxfev": EVALUATIONS, "maxiter": EVALUATIONS})
    return _constants(found.x)


def stated_and_true(comparisons: Sequence[tuple[Comparison, set[str]]], constants: Constants) -> pd.DataFrame:
    """Reliability of the weights: :func:`camid.proof.rates.reliability` over all names of all effects."""
    rows = [
        {"weight": weight, "right": name in truth}
        for comparison, truth in comparisons
        for name, weight in weights(comparison, constants)[0]
    ]
    return reliability(pd.DataFrame(rows))


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
