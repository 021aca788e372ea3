"""Words that an engineer uses for a law: odd or even, threshold, slopes, period, power, loop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.laws.formula.text import NOTATION, symbol_of, unit_text
from camid.diagnosis.learned_part import Formula, LearnedPart, Quantity
from camid.fitting.linearised_law import LinearisedLaw
from camid.fitting.smoothness import smooth_curve
from camid.number_text import SPACE, number, plain, with_deviation
from camid.simulation.declared_units import DeclaredUnits

Array = NDArray[np.float64]

KNOTS = 13
LEAST_ROUGHNESS = 1e-6
# Share of the range that has to lie on either side of zero for a law to be called odd or even, and the gain of log
# evidence that calls it so.
LEAST_SIDE = 0.3
LEAST_GAIN = 2.0
# Forms of straight pieces.
PIECEWISE = {"kink", "dead zone", "two kinks", "absolute value"}
# Straight part of a formula, as a share of what is left of it, from which it is worth a word, and of the signal itself.
LEAST_HELD = 0.05
# Laws that multiply what a coefficient does: their constant is a part of it.
OF_A_COEFFICIENT = {"damping over position": "damping", "gain over position": "gain", "gain over velocity": "gain"}
# Standard deviations from which the largest difference of curve and formula is named.
SIGNIFICANT = 2.0


def described(law: LinearisedLaw, variables: str, formula: Formula | None, power: Quantity | None) -> list[str]:
    """What can be said of a law, each in a few words.

    Parameters
    ----------
    law : LinearisedLaw
    variables : str
        What it depends on.
    formula : Formula, optional
        One that holds.
    power : Quantity, optional
        Exponent, where one was fitted.
    """
    words = []
    if (side := parity(law)) is not None:
        words.append(side)
    if formula is not None:
        words += _of_form(formula, variables)
    if power is not None:
        words.append(f"grows as the power {_estimate(power)} of |{symbol_of(variables)}|")
    if variables == "position":
        words.append("a force of the position alone gives back what it takes: no loop")
    return words


def parity(law: LinearisedLaw) -> str | None:
    """Odd, even or neither, but for a constant and a straight line that coefficients hold; None where no side says."""
    low, high = float(law.grid[0]), float(law.grid[-1])
    reach = min(-low, high)
    if reach <= LEAST_SIDE * max(-low, high):
        return None
    half = np.linspace(0.0, max(-low, high), KNOTS)
    sizes = np.array([np.interp(np.abs(law.grid), half, row) for row in np.eye(KNOTS)[1:]]).T
    whole = np.array([np.interp(law.grid, np.linspace(low, high, 2 * KNOTS - 1), row) for row in np.eye(2 * KNOTS - 1)])
    evidence = {
        "odd": _evidence(law, sizes * np.sign(law.grid)[:, None]),
        "even": _evidence(law, sizes),
        "neither": _evidence(law, whole.T),
    }
    best = max(("odd", "even"), key=lambda name: evidence[name])
    if evidence[best] > evidence["neither"] + LEAST_GAIN:
        return {"odd": "odd: opposite on both sides", "even": "even: the same on both sides"}[best]
    if evidence["neither"] > evidence[best] + LEAST_GAIN:
        return "neither odd nor even"
    return None


def _evidence(law: LinearisedLaw, basis: Array) -> float:
    """Natural logarithm of the evidence for smooth laws of a basis, shape (G, m)."""
    second = np.diff(np.eye(basis.shape[1]), 2, axis=0)
    roughness = second.T @ second
    roughness += LEAST_ROUGHNESS * float(np.trace(roughness)) / len(roughness) * np.eye(len(roughness))
    table = law.factor @ law.absorbed.without(basis)
    # What no law explains is one more row that none of them reaches.
    table = np.vstack([table, np.zeros((1, table.shape[1]))])
    return smooth_curve(table, np.append(law.target, np.sqrt(law.rest)), roughness, law.rows).log_evidence


def _of_form(formula: Formula, variables: str) -> list[str]:
    """What the numbers of a formula mean."""
    symbol = symbol_of(variables)
    said = {name: _estimate(quantity) for name, quantity in formula.parameters.items()}
    sentences = {
        "kink": "threshold at {x} = {c}",
        "dead zone": "thresholds at {x} = ± {c}",
        "two kinks": "thresholds at {x} = {d} and {c}",
        "absolute value": "kink at {x} = 0",
        "sine": "repeats every {L}",
        "sine with a second harmonic": "repeats every {L}",
        "bump": "centred at {x} = {x0}, half-width {c}",
        "rational bump": "centred at {x} = {x0}, half-width {c}",
        "pull to a point": "centred at {x} = {x0}, half-width {c}",
        "step": "a step at {x} = {x0}",
        "smooth step": "a step at {x} = {x0}",
        "sign": "a step at {x} = 0",
        "peak at a point": "largest at |{x}| = {c}",
        "saturation, tanh": "levels off beyond |{x}| ≈ {c}",
        "saturation, rational": "levels off beyond |{x}| ≈ {c}",
        "inverse of a distance": "grows without bound towards {x} = {x0}",
        "inverse square of a distance": "grows without bound towards {x} = {x0}",
        "exponential": "grows by the factor e every {c}",
    }
    if formula.form not in sentences:
        return []
    words = [sentences[formula.form].format(**{**said, "x": symbol, "x0": said.get(f"{symbol}0", "")})]
    return [*words, _slopes(formula)] if formula.form in PIECEWISE else words


def _slopes(formula: Formula) -> str:
    """Slopes on the pieces of a piecewise linear law, and by how much they differ."""
    points, values = np.array(formula.points), np.array(formula.values)
    slopes = np.diff(values) / np.diff(points)
    change = "; ".join(_estimate(formula.parameters[name]) for name in ("a", "b") if name in formula.parameters)
    return (
        f"slope {number(float(np.median(slopes[: max(len(slopes) // 12, 1)])))} at the lower end, "
        f"{number(float(np.median(slopes[-max(len(slopes) // 12, 1) :])))} at the upper one; change {change}"
    )


def held_by_coefficients(formula: Formula, part: LearnedPart, units: DeclaredUnits) -> list[str]:
    """What the plant's coefficients, as they stand, hold of a formula already, in a few words; empty where it is none.

    Parameters
    ----------
    formula : Formula
        In declared units.
    part : LearnedPart
        The law whose formula it is.
    units : DeclaredUnits
    """
    slope, constant = (formula.held.get(name, 0.0) for name in ("slope", "constant"))
    symbol, notation, heights, over = NOTATION[part.variables]
    least = LEAST_HELD * float(np.ptp(formula.values or [0.0]))
    if part.variables in OF_A_COEFFICIENT and abs(constant) > least:
        shown = plain(constant, 3, units.text(unit_text(heights, over, 0.0)))
        law = notation.split(", ")[1].split(" ")[0]
        name = OF_A_COEFFICIENT[part.variables]
        return [f"the plant's {name}, as the coefficients stand, holds {shown} of {law} already".replace(SPACE, " ")]
    if abs(slope) * float(np.ptp(formula.points or [0.0])) <= least:
        return []
    before, signal, form = formula.expression.partition(f" = {symbol} + ")
    if signal:
        # The signal goes on beside what is bent of it, and the straight part is the plant's gain.
        left = "" if abs(1.0 - slope) < LEAST_HELD else f"{plain(1.0 - slope, 3)}·{symbol} + "
        return [f"beside the coefficients as they stand it is {before} = {left}{form}".replace(SPACE, " ")]
    shown = plain(slope, 3, units.text(unit_text(heights, over, 1.0)))
    return [f"the coefficients, as they stand, hold a straight part of {shown} of it already".replace(SPACE, " ")]


def missing_from(form: Formula, part: LearnedPart, explained: float) -> str:
    """What a formula would have to explain better than the best of the dictionary; both in the units of the words."""
    symbol = symbol_of(part.variables)
    knots, values, deviations = (np.array(each) for each in (part.knots, part.values, part.standard_deviations))
    values = values - knots if part.identifier == "learned-curve" else values
    drawn = np.interp(knots, form.points, form.values)
    ratio = (values - drawn) / np.maximum(deviations, 1e-12 * float(np.max(np.abs(values)) or 1.0))
    inner = np.arange(1, len(knots) - 1)
    worst = int(inner[np.argmax(np.abs(ratio[inner]))])
    text = f"the nearest form of the dictionary is {form.form} ({form.expression}), with {100.0 * explained:.3g} % of "
    text += "what the curve explains"
    if abs(ratio[worst]) < SIGNIFICANT:
        return text
    at = f"{symbol} = {plain(float(knots[worst]), 3, part.knot_unit)}"
    difference = with_deviation(float(values[worst] - drawn[worst]), float(deviations[worst]), part.unit)
    return f"{text}; a formula would have to explain what is left about {at}, {difference}".replace(SPACE, " ")


def loop_area(
    law: Mapping[str, Array], variables: str, amplitude: float, frequency: float
) -> tuple[float, float] | None:
    """Work that a law takes from a sinusoidal motion in a period, and its standard deviation; None where it has none.

    Parameters
    ----------
    law : mapping of str to ndarray
        ``knots``, ``values`` and ``deviations``; these are taken for wholly dependent, which makes the result no
        smaller than it is.
    variables : str
    amplitude : float
        Of the motion, in y.
    frequency : float
        In rad/s.
    """
    if variables not in ("velocity", "damping over position"):
        return None
    phase = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    position, velocity = amplitude * np.sin(phase), amplitude * frequency * np.cos(phase)
    at = velocity if variables == "velocity" else position
    weight = velocity if variables == "velocity" else velocity**2
    period = 2.0 * np.pi / frequency
    force = np.interp(at, law["knots"], law["values"])
    spread = np.interp(at, law["knots"], law["deviations"])
    return float(np.mean(force * weight) * period), float(np.mean(spread * np.abs(weight)) * period)


def _estimate(estimate: Quantity) -> str:
    text = with_deviation(estimate.value, estimate.standard_deviation, estimate.unit)
    return text.replace(SPACE, " ")
