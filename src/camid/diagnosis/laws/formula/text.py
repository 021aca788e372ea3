"""A formula as people write it: symbols of the law's variable, numbers with standard deviations and units."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.laws.formula.search import FittedForm
from camid.diagnosis.learned_part import LENGTH, Formula, Quantity

Array = NDArray[np.float64]

Unit = dict[str, float]
# What a learned law is over: symbol, what stands before its formula, and the units of its values and its variable.
NOTATION: dict[str, tuple[str, str, Unit, Unit]] = {
    "position": ("y", "f(y) = ", {"u": 1}, {"y": 1}),
    "velocity": ("v", "f(v) = ", {"u": 1}, {"y": 1, "s": -1}),
    "damping over position": ("y", "f = d(y)·v, d(y) = ", {"u": 1, "s": 1, "y": -1}, {"y": 1}),
    "gain over position": ("y", "f = g(y)·u, g(y) = ", {}, {"y": 1}),
    "gain over velocity": ("v", "f = g(v)·u, g(v) = ", {}, {"y": 1, "s": -1}),
    "input": ("u", "u' = u + ", {"u": 1}, {"u": 1}),
    "reading": ("y", "w = y + ", {"y": 1}, {"y": 1}),
}


def symbol_of(variables: str) -> str:
    """The letter for what a law is over."""
    return NOTATION[variables][0]


def unit_text(heights: Unit, over: Unit, power: float) -> str:
    """Unit of a number that is multiplied with x to a power, in u, y and s."""
    total: Unit = dict(heights)
    for name, exponent in over.items():
        total[name] = total.get(name, 0.0) - power * exponent
    above = [_power(n, e) for n, e in total.items() if e > 0.0]
    below = [_power(n, -e) for n, e in total.items() if e < 0.0]
    if not below:
        return " ".join(above)
    under = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return f"{' '.join(above) or '1'}/{under}"


def _power(name: str, exponent: float) -> str:
    return name if exponent == 1.0 else f"{name}^{exponent:g}"


def formula_of(form: FittedForm, covariance: Array, variables: str) -> Formula:
    """A fitted form in the units of the recording.

    Parameters
    ----------
    form : FittedForm
    covariance : ndarray, shape (q, q)
        Of its numbers.
    variables : str
        What the law depends on.
    """
    symbol, before, heights, over = NOTATION[variables]
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    parameters = {}
    rows = [(name, power, form.length**-power, heights) for name, power in form.form.amplitudes]
    rows += [(bend.name, -float(bend.power), form.length**bend.power, {}) for bend in form.form.bends]
    for (name, power, factor, unit), value, deviation in zip(rows, form.vector, deviations, strict=True):
        spread = float(deviation * factor) if np.isfinite(deviation) else None
        parameters[_named(name, symbol)] = Quantity(float(value * factor), spread, unit_text(unit, over, power))
    pattern = before + _named(form.form.text, symbol)
    length = form.length if LENGTH in pattern else None
    return Formula(form.form.name, pattern, parameters, pattern=pattern).with_length(length)


def _named(text: str, symbol: str) -> str:
    """With the variable's letter in the place of x; a place on its axis is called after it, too."""
    text = re.sub(r"x0", f"{symbol}0", text)
    return re.sub(r"(?<![A-Za-z0-9])x(?![A-Za-z0-9])", symbol, text)
