"""What is diagnosed of rigs under laws outside the catalogue, held against those laws."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.errors import InputError
from camid.proof.unlisted.laws import Law
from camid.proof.unlisted.rigs import Case, Rig, draw, generator, law_of

Array = NDArray[np.float64]

# Seconds that a diagnosis may take: on a loaded machine none is to end before its time.
PATIENCE = 900.0
# How the report writes what Python writes otherwise.
_MEANINGS = (
    ("·", "*"),
    ("−", "-"),
    ("²", "**2"),
    ("³", "**3"),
    ("⁴", "**4"),
    ("⁵", "**5"),
    ("^", "**"),
    ("2π", "2*pi"),
    ("4π", "4*pi"),
)
# At which a formula is compared with the law.
POINTS = 200
# What named effects are functions of, in the words of learned laws, from the equations of the catalogue's page.
VARIABLES = {
    "position": (
        "cogging",
        "cubic-stiffness",
        "quadratic-stiffness",
        "end-stop",
        "overflow",
        "pendulum-gravity",
        "square-root-outflow",
    ),
    "velocity": ("coulomb-friction", "asymmetric-friction", "stribeck-friction", "quadratic-drag"),
    "damping over position": ("amplitude-dependent-damping",),
    "input": ("dead-zone", "saturation", "gain-asymmetry"),
    "reading": ("absolute-value", "clipping", "encoder-eccentricity", "lens-distortion", "perspective"),
}
COLUMNS = [
    "number",
    "missing",
    "law",
    "variables",
    "form",
    "first",
    "second",
    "noise",
    "share",
    "left",
    "beyond",
    "verdict",
    "effects",
    "learned",
    "carrier",
    "carrier_variables",
    "formula",
    "formula_variables",
    "curve_error",
    "refitted",
    "improved",
    "recovered",
    "seconds",
    "failure",
]


def campaign(seed: int, first: int, last: int) -> pd.DataFrame:
    """Answers on the cases of a span of numbers, with a law outside the catalogue and with nothing missing.

    Parameters
    ----------
    seed : int
    first, last : int
        Numbers of its first and last case.

    Returns
    -------
    DataFrame
        Two rows per number: of a rig under a law and of one under none. ``number``, ``missing``, ``law``,
        ``variables`` and ``form`` (of the truth), ``first`` and ``second`` (kinds of input), ``noise`` (share of the
        output's standard deviation), ``share`` (of the output that the law changes), ``left`` (of that, beyond what
        coefficients can do) and ``beyond`` (share of the second recording beyond the first one's readings);
        ``verdict``, ``effects`` (identifiers with their shares, named and learned, as JSON), ``learned`` (how many
        laws), ``carrier`` (what carries the law: see :func:`carrier`) and ``carrier_variables``, ``formula`` and
        ``formula_variables``, ``curve_error`` (:func:`curve_error`), ``refitted`` and ``improved`` (errors on the
        second recording, shares of its standard deviation), ``recovered``, ``seconds`` and ``failure``.
    """
    rows = [scored(seed, number, missing) for number in range(first, last + 1) for missing in (True, False)]
    return pd.DataFrame(rows, columns=COLUMNS)


def scored(seed: int, number: int, missing: bool) -> dict[str, Any]:
    """One row of :func:`campaign`."""
    rng = generator(seed, number, missing)
    law = law_of(number) if missing else None
    case = draw(rng, law)
    texts = ("verdict", "failure", "carrier", "carrier_variables", "formula", "formula_variables")
    numbers = ("curve_error", "refitted", "improved", "recovered")
    row: dict[str, Any] = {
        "number": number,
        "missing": missing,
        "law": law.name if law else "",
        "variables": law.variables if law else "",
        "form": law.form if law else "",
        "first": case.inputs[0],
        "second": case.inputs[1],
        "noise": case.rig.noise,
        "share": case.share,
        "left": case.left,
        "beyond": _beyond(case),
        "effects": "[]",
        "learned": 0,
        **dict.fromkeys(texts, ""),
        **dict.fromkeys(numbers, np.nan),
    }
    started = time.perf_counter()
    try:
        row |= _answers(case, case.simulation(rng))
    except InputError as refusal:
        row["failure"] = str(refusal).splitlines()[0]
    return row | {"seconds": time.perf_counter() - started}


def _beyond(case: Case) -> float:
    """Share of the second recording that lies beyond the first one's readings."""
    first = case.first["y"]
    return float(np.mean((case.clean < first.min()) | (case.clean > first.max())))


def _answers(case: Case, simulation: Mapping[str, Any]) -> dict[str, Any]:
    import camid

    found = camid.diagnose(case.first, simulation, time_limit=PATIENCE)
    stated = found.to_mapping()
    effects = stated["effects"]
    answers: dict[str, Any] = {
        "verdict": stated["verdict"],
        "effects": json.dumps([[effect["id"], effect["evidence"]["share"]] for effect in effects]),
        "learned": sum(effect["id"].startswith("learned-") for effect in effects),
    }
    chosen = carrier(effects)
    if chosen is not None:
        answers |= {"carrier": chosen["id"], "carrier_variables": variables_of(chosen)}
    written = next((effect for effect in effects if effect.get("formula")), None)
    if written is not None:
        answers |= {"formula": written["formula"], "formula_variables": written["variables"]}
        answers["curve_error"] = curve_error(case.rig, written, case.first)
    refitted = camid.identify(case.first, simulation, method="output-error").simulation
    answers["refitted"] = error_of(camid.simulate(case.second, refitted), case.clean)
    try:
        answers["improved"] = error_of(camid.simulate(case.second, found.improved), case.clean)
    except InputError as refusal:
        # A learned law that makes the plant unstable where the first recording never was.
        return answers | {"failure": str(refusal).splitlines()[0]}
    return answers | {"recovered": 1.0 - answers["improved"] / answers["refitted"]}


def error_of(simulated: pd.DataFrame, clean: Array) -> float:
    """Root mean square error against the recording without its noise, share of the standard deviation.

    The noise has no part in it: it is what is left of the error when the noise floor is taken off, and a perfect model
    has none.
    """
    difference = simulated["simulated"].to_numpy(float) - clean
    return float(np.sqrt(np.mean(difference**2)) / np.std(clean))


def carrier(effects: list[dict[str, Any]]) -> dict[str, Any] | None:
    """What carries the law: what removes the largest share of the refitted error, or the formula that stands for it."""
    largest = max(effects, key=lambda effect: effect["evidence"]["share"] or 0.0, default=None)
    if largest is None:
        return None
    return next((e for e in effects if e.get("formula") and largest["id"] in e.get("formula_replaces", [])), largest)


def variables_of(effect: Mapping[str, Any]) -> str:
    """What a law or a named effect is a function of; empty for what is no function of motion or input alone."""
    if "variables" in effect:
        return str(effect["variables"])
    return next((variables for variables, names in VARIABLES.items() if effect["id"] in names), "")


def curve_error(rig: Rig, effect: Mapping[str, Any], recording: pd.DataFrame) -> float:
    """How far a formula is from the law: share of the law's bend.

    Both are taken over the middle 98 % of the recording, less what the plant's coefficients hold: a straight line for a
    force, a constant for a damping, and factors for the gain and for the curves.

    Returns
    -------
    float
        Root mean square difference over that of the law's bend; NaN for other variables than the law's.
    """
    if rig.law is None or effect["variables"] != rig.law.variables:
        return np.nan
    points = np.linspace(*_reached(rig, recording), POINTS)
    constants = {name: row["value"] for name, row in effect["formula_parameters"].items()}
    values = evaluated(effect["formula"], points, constants)
    # What of a curve's straight line and of a gain's constant the plant's coefficients hold is in the formula, too.
    held = effect.get("formula_held") or {}
    if rig.law.variables in ("input", "reading"):
        values = values - held.get("slope", 0.0) * points
    elif rig.law.variables.startswith("gain"):
        values = values - held.get("constant", 0.0)
    return _bend_error(rig, rig.law, points, values)


def evaluated(formula: str, points: Array, constants: Mapping[str, float]) -> Array:
    """A formula as the report writes it, ``f(y) = …, a = …``, over points; read by Python, not by the tool.

    NaN where it is written in a way that is not known here.
    """
    text = without_numbers(formula).rpartition(" = ")[2]
    for written, meant in _MEANINGS:
        text = text.replace(written, meant)
    text = re.sub(r"√\|([^|]+)\|", r"sqrt(abs(\1))", text)
    text = re.sub(r"\|([^|]+)\|", r"abs(\1)", text)
    known = {name: getattr(np, name) for name in ("abs", "clip", "cos", "exp", "sign", "sin", "sqrt", "tanh", "pi")}
    known["dead_zone"] = lambda over, half: over - np.clip(over, -half, half)
    known |= {"max": np.maximum, "min": np.minimum, **dict.fromkeys("yvu", points), **constants}
    try:
        values = eval(text, {"__builtins__": {}}, known)
    except (SyntaxError, NameError, TypeError):
        return np.full(points.shape, np.nan)
    return np.broadcast_to(np.asarray(values, float), points.shape)


def without_numbers(formula: str) -> str:
    """A formula up to where its numbers begin."""
    return re.split(r", \w+ = [−(]*\d", formula)[0]


def _reached(rig: Rig, recording: pd.DataFrame) -> tuple[float, float]:
    """Middle 98 % of what the law depends on; of velocities, from differences of the frames."""
    assert rig.law is not None
    if rig.law.variables == "input":
        over = recording["u"].to_numpy(float)
    elif rig.law.variables in ("velocity", "gain over velocity"):
        over = np.gradient(recording["y"].to_numpy(float), rig.period)
    else:
        over = recording["y"].to_numpy(float)
    low, high = np.quantile(over, [0.01, 0.99])
    return float(low), float(high)


def _bend_error(rig: Rig, law: Law, knots: Array, values: Array) -> float:
    from scipy.optimize import minimize_scalar

    def true(points: Array) -> Array:
        return np.array([rig.departure(float(x)) for x in points])

    ones = np.ones(len(knots))
    straight = np.stack([ones, knots], axis=1)
    truth = true(knots)
    if np.isnan(values).any():
        return np.nan
    if law.variables in ("position", "velocity"):
        # Stated forces act against the motion, whatever the sign of the gain.
        return _left(values - np.sign(rig.gain) * truth, straight) / _left(truth, straight)
    if law.variables == "damping over position":
        return _left(values - np.sign(rig.gain) * truth, ones[:, None]) / _left(truth, ones[:, None])
    if law.variables.startswith("gain"):
        return _left(1.0 - values, (1.0 - truth)[:, None]) / _left(1.0 - truth, ones[:, None])
    if law.variables == "input":
        curve = knots + truth
        return _left(values, np.stack([ones, curve], axis=1)) / _left(curve, straight)

    def mismatch(factor: float) -> float:
        """With the plant's gain another one, the same reading belongs to another position."""
        return _left(values - factor * knots - true(factor * knots), ones[:, None])

    best = minimize_scalar(mismatch, bounds=(0.3, 3.0), method="bounded")
    return float(best.fun) / _left(truth, straight)


def _left(values: Array, columns: Array) -> float:
    """Root mean square of what a combination of columns leaves."""
    rest = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(np.sqrt(np.mean(rest**2)))
