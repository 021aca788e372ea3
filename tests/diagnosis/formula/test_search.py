"""Forms of the dictionary against curves of known law, with what coefficients do of them taken out."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from camid.diagnosis.laws.formula.bends import Range
from camid.diagnosis.laws.formula.dictionary import FORMS
from camid.diagnosis.laws.formula.search import fitted_forms, length_of
from camid.diagnosis.laws.formula.text import formula_of, unit_text
from camid.fitting.linearised_law import Absorbed, LinearisedLaw, fine_grid

ROWS, NOISE = 1500, 0.01


def linearised(law, low=-2.0, high=2.5, seed=1, line=True, noise=NOISE):
    """What a recording says of a law that acts on its output directly: rows of a random motion over the range."""
    random = np.random.default_rng(np.random.SeedSequence((seed, 77)))
    grid = fine_grid(np.linspace(low, high, 17))
    motion = np.clip(0.5 * (low + high) + 0.28 * (high - low) * random.standard_normal(ROWS), low, high)
    table = np.array([np.interp(motion, grid, row) for row in np.eye(len(grid))]).T
    counts = np.mean(table, axis=0)
    zero = np.array([np.interp(0.0, grid, row) for row in np.eye(len(grid))])
    constraints = [zero] + [counts * (grid - counts @ grid)] * line
    absorbed = Absorbed(grid, np.array(constraints), constant=True, line=line)
    beside = np.column_stack([np.ones(ROWS), motion] if line else [np.ones(ROWS)])
    basis = np.linalg.qr(beside)[0]
    rows = table @ law(grid) + noise * random.standard_normal(ROWS)
    left, target = (each - basis @ (basis.T @ each) for each in (table, rows))
    basis, factor = np.linalg.qr(left)
    z = basis.T @ target
    return LinearisedLaw(grid, law(grid), factor, z, float(target @ target - z @ z), absorbed, ROWS)


LAWS = {
    "square": lambda x: 0.2 * x**2,
    "cube": lambda x: -0.1 * x**3,
    "square with the sign": lambda x: 0.3 * x * np.abs(x),
    "absolute value": lambda x: 0.5 * np.abs(x),
    "sign": lambda x: 0.3 * np.sign(x),
    "power with the sign": lambda x: 0.4 * np.sign(x) * np.abs(x) ** 1.4,
    "sine": lambda x: 0.2 * np.sin(2.0 * np.pi * x / 0.9 + 0.4),
    "bump": lambda x: 0.4 * np.exp(-(((x - 0.7) / 0.4) ** 2)),
    "pull to a point": lambda x: -0.4 * (x - 0.7) / 0.4 * np.exp(-(((x - 0.7) / 0.4) ** 2)),
    "exponential": lambda x: 0.05 * np.exp(x / 0.8),
    "peak at a point": lambda x: 0.8 * x / (1.0 + (x / 0.5) ** 2),
    "saturation, tanh": lambda x: 0.5 * np.tanh(x / 0.6),
    "smooth step": lambda x: 0.5 * np.tanh((x - 0.8) / 0.2),
    "dead zone": lambda x: 0.5 * (x - np.clip(x, -0.8, 0.8)),
    "kink": lambda x: 0.5 * np.maximum(x - 0.9, 0.0),
    "inverse square of a distance": lambda x: 0.5 / (3.2 - x) ** 2,
}


def criterion(each, law):
    return each.left / NOISE**2 + each.form.count * np.log(law.rows)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_of_the_dictionary_is_found_with_its_curve(name):
    law = linearised(LAWS[name])
    best = min(fitted_forms(law), key=lambda each: criterion(each, law))
    assert best.form.name == name
    # A constant and a straight line are the coefficients'.
    wrong = law.absorbed.without(best.values(law.grid) - LAWS[name](law.grid))
    inner = (law.grid > -1.5) & (law.grid < 2.0)
    assert np.max(np.abs(wrong[inner])) < 0.05 * np.ptp(law.absorbed.without(LAWS[name](law.grid)))
    assert best.left < 1.1 * NOISE**2 * law.rows


@pytest.mark.parametrize("line", [True, False])
def test_a_straight_line_is_a_form_where_no_coefficient_stands_for_it(line):
    law = linearised(lambda x: 0.3 * x, line=line)
    names = [each.form.name for each in fitted_forms(law)]
    assert ("straight line" in names) is not line


def test_nothing_outside_of_the_dictionary_is_taken_for_a_form():
    law = linearised(lambda x: 0.3 * np.sin(4.0 * x * np.abs(x)))
    best = min(fitted_forms(law), key=lambda each: each.left)
    assert best.left > 3.0 * NOISE**2 * law.rows


def test_in_noise_no_form_explains_more_than_chance():
    law = linearised(lambda x: 0.0 * x)
    nothing = float(law.target @ law.target) + law.rest
    for each in fitted_forms(law):
        # Thresholds and periods may be chosen among many.
        assert (nothing - each.left) / NOISE**2 < 12.0 + 4.0 * each.form.count


def test_forms_that_need_both_sides_are_left_out_on_one():
    names = {each.form.name for each in fitted_forms(linearised(lambda x: 0.2 * x**2, low=0.5, high=3.0))}
    assert "square" in names
    assert not {"dead zone", "saturation, tanh", "power with the sign"} & names


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.text)
def test_forms_are_what_they_say(form):
    visited = Range(-0.9, 1.0)
    starts = list(form.starts(visited))
    low, high = form.bounds(visited)
    assert all(len(start) == len(form.bends) and np.all(start >= low) and np.all(start <= high) for start in starts)
    x = np.linspace(-0.9, 1.0, 41)
    columns = form.columns(x, starts[0] if form.bends else np.zeros(0))
    assert columns.shape == (41, len(form.amplitudes))
    assert np.all(np.isfinite(columns))
    assert all(name in form.text for name in [a for a, _ in form.amplitudes] + [b.name for b in form.bends])
    assert form.contains <= {other.name for other in FORMS}


def test_the_grid_holds_zero_and_the_knots():
    knots = np.linspace(-1.0, 1.37, 17)
    grid = fine_grid(knots)
    assert 0.0 in grid
    assert np.all(np.diff(grid) > 0.0)
    assert np.max(np.min(np.abs(knots[:, None] - grid[None, :]), axis=1)) < 0.1 * (knots[1] - knots[0])
    assert 0.0 not in fine_grid(np.linspace(0.2, 1.0, 9))


def test_numbers_have_the_units_of_the_recording():
    law = linearised(lambda x: -1e-10 * x**3, low=-2000.0, high=2500.0)
    best = next(each for each in fitted_forms(law) if each.form.name == "cube")
    assert length_of(law.grid) == 2500.0
    formula = formula_of(best, np.array([[1e-4]]), "position")
    a = formula.parameters["a"]
    assert (a.value, a.unit) == (pytest.approx(-1e-10, rel=0.02), "u/y^3")
    assert a.standard_deviation == pytest.approx(1e-2 / 2500.0**3)
    assert formula.text.startswith("f(y) = a·y³, a = ")
    assert unit_text({"u": 1, "s": 1, "y": -1}, {"y": 1}, 2.0) == "u s/y^3"
    assert unit_text({}, {"y": 1, "s": -1}, 1.0) == "s/y"
    assert unit_text({"y": 1}, {"y": 1}, 1.0) == ""


def test_forms_that_do_nothing_to_the_output_are_none():
    """Their numbers would be what rounding makes of nought by nought."""
    law = linearised(LAWS["square"])
    silent = replace(law, factor=np.zeros_like(law.factor))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fitted_forms(silent) == []
    assert fitted_forms(law)
