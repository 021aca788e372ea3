"""Words for laws: sides, thresholds, slopes, periods, powers and loops."""

from dataclasses import replace

import numpy as np
import pytest

from camid.diagnosis.laws.formula.words import described, held_by_coefficients, loop_area, missing_from, parity
from camid.diagnosis.learned_part import Formula, LearnedPart, Quantity
from camid.simulation.declared_units import IN_U_AND_Y
from tests.diagnosis.formula.test_search import linearised


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda x: 0.1 * x**3 + 0.4 * x, "odd"),
        (lambda x: 0.2 * np.abs(x) + 0.3, "even"),
        (lambda x: 0.3 * np.exp(x), "neither"),
    ],
)
def test_sides(law, says):
    assert parity(linearised(law)).startswith(says)


def test_sides_are_not_told_in_noise_nor_from_one_side():
    assert parity(linearised(lambda x: x**2, low=-0.2, high=3.0)) is None
    # What noise leaves open is not called neither.
    assert parity(linearised(lambda x: 0.0 * x)) != "neither odd nor even"


def test_thresholds_and_slopes():
    points = np.linspace(-1.0, 1.0, 81)
    law = Formula(
        "kink",
        "f(y) = a·max(y − c, 0)",
        {"a": Quantity(2.0, 0.1, "u/y"), "c": Quantity(0.25, 0.01, "y")},
        points=points.tolist(),
        values=(2.0 * np.maximum(points - 0.25, 0.0) - 0.5 * points).tolist(),
    )
    words = "; ".join(described(linearised(lambda x: np.maximum(x - 0.25, 0.0)), "position", law, None))
    assert "threshold at y = 0.250 ± 0.010 y" in words
    assert "slope −0.500 at the lower end, 1.50 at the upper one; change 2.00 ± 0.10 u/y" in words


@pytest.mark.parametrize(
    ("form", "parameters", "says"),
    [
        ("sine", {"L": Quantity(0.9, 0.01, "y")}, "repeats every 0.900 ± 0.010 y"),
        ("bump", {"y0": Quantity(1.0, 0.1, "y"), "c": Quantity(0.5, 0.1, "y")}, "centred at y = 1.00 ± 0.10 y"),
        ("inverse of a distance", {"y0": Quantity(3.0, 0.1, "y")}, "grows without bound towards y = 3.00 ± 0.10 y"),
    ],
)
def test_what_numbers_mean(form, parameters, says):
    words = described(linearised(np.sin), "position", Formula(form, "f(y) = …", parameters), None)
    assert says in "; ".join(words)


@pytest.mark.parametrize(
    ("variables", "expression", "slope", "says"),
    [
        ("input", "u' = u + a·dead_zone(u, c)", 1.0004, "it is u' = a·dead_zone(u, c)"),
        ("input", "u' = u + a·u³", 0.25, "it is u' = 0.75·u + a·u³"),
        ("position", "f(y) = a·y² + b·y³", 0.16, "hold a straight part of 0.16 u/y of it already"),
        ("position", "f(y) = a·y² + b·y³", 1e-4, ""),
    ],
)
def test_what_the_coefficients_hold_of_a_formula(variables, expression, slope, says):
    """With all of a dead zone's straight part in the gain, what is left of the signal itself is nothing."""
    points = np.linspace(-1.0, 1.0, 5)
    law = Formula("…", expression, {}, held={"slope": slope}, points=points.tolist(), values=(points**3).tolist())
    part = LearnedPart("…", "plant", "…", variables, [], [], [], "y", "u", 9.0, 0.5)
    words = held_by_coefficients(law, part, IN_U_AND_Y)
    assert words == [] if says == "" else says in words[0]


@pytest.mark.parametrize(
    ("variables", "expression", "says"),
    [
        (
            "damping over position",
            "f = d(y)·v, d(y) = a·exp(−(y/c)²)",
            "the plant's damping, as the coefficients stand",
        ),
        (
            "gain over velocity",
            "f = g(v)·u, g(v) = a·v",
            "the plant's gain, as the coefficients stand, holds 0.3 of g(v)",
        ),
        ("position", "f(y) = a·y²", ""),
    ],
)
def test_a_part_of_a_coefficient_that_a_formula_is_without(variables, expression, says):
    """The numbers of the formula and the coefficients that are printed are else not those of one rig."""
    points = np.linspace(-1.0, 1.0, 5)
    held = {"constant": 0.3}
    law = Formula("…", expression, {}, held=held, points=points.tolist(), values=(points**2).tolist())
    part = LearnedPart("…", "plant", "…", variables, [], [], [], "y", "u", 9.0, 0.5)
    words = held_by_coefficients(law, part, IN_U_AND_Y)
    assert words == [] if says == "" else says in words[0]


def test_power():
    words = described(linearised(lambda x: x**3), "velocity", None, Quantity(3.02, 0.05, ""))
    assert "grows as the power 3.020 ± 0.050 of |v|" in "; ".join(words)


def test_the_loop_of_a_law_has_the_area_of_its_work():
    knots = np.linspace(-4.0, 4.0, 801)
    drag = {"knots": knots, "values": 0.3 * knots * np.abs(knots), "deviations": np.full(801, 0.01)}
    area, spread = loop_area(drag, "velocity", 0.5, 3.0)
    # Work of c·v·|v| over a period of A·sin(ωt): 8/3·c·A³·ω².
    assert area == pytest.approx(8.0 / 3.0 * 0.3 * 0.5**3 * 9.0, rel=1e-3)
    assert spread == pytest.approx(4.0 * 0.5 * 0.01, rel=1e-3)
    assert loop_area(drag, "position", 0.5, 3.0) is None


def test_what_is_missing_says_where_and_how_much():
    knots = np.linspace(-1.0, 1.0, 9)
    nearest = Formula("cube", "f(y) = a·y³", {}, points=knots.tolist(), values=(knots**3).tolist())
    values = knots**3
    values[5] += 0.2
    part = LearnedPart(
        *("learned-force", "plant", "Learned force", "position"),
        *(knots.tolist(), values.tolist(), [0.01] * 9, "y", "u", 9.0, 0.5),
    )
    text = missing_from(nearest, part, 0.87)
    assert "nearest form of the dictionary is cube (f(y) = a·y³), with 87 %" in text
    assert "about y = 0.25 y, 0.200 ± 0.010 u" in text
    assert "about" not in missing_from(nearest, replace(part, values=(knots**3).tolist()), 0.87)
