"""What a recording leaves open of constants, and what it determines instead."""

import numpy as np
import pytest

from camid.physical.linear_form import RationalForm, StateSpaceForm
from camid.physical.plant import PhysicalPlant

SPRING = {"mass": 1.2, "damping": 0.4, "stiffness": 310.0}
TWO_MASSES = (
    ("0", "1", "0", "0"),
    ("-k/m1", "-c/m1", "k/m1", "c/m1"),
    ("0", "0", "0", "1"),
    ("k/m2", "c/m2", "-k/m2", "-c/m2"),
)


def left_open(parameters, form, fixed=(), rows=None):
    plant = PhysicalPlant(parameters, form, fixed)
    free_numerator, free_denominator = plant.freedom()
    return plant.undetermined(np.concatenate([free_numerator, free_denominator[1:]]) if rows is None else rows)


def rational(parameters, numerator, denominator):
    return RationalForm(tuple(parameters), tuple(numerator), tuple(denominator))


def test_a_spring_is_determined():
    assert left_open(SPRING, rational(SPRING, ["1"], ["mass", "damping", "stiffness"])).open == ()


def test_a_gain_leaves_ratios():
    parameters = {**SPRING, "gain": 2.0}
    form = rational(parameters, ["gain"], ["mass", "damping", "stiffness"])
    found = left_open(parameters, form)
    assert found.held == ("mass",)
    assert list(found.combinations) == ["damping/mass", "stiffness/mass", "gain/mass"]
    assert left_open(parameters, form, ("mass",)).open == ()


def test_what_adds_up_is_a_sum():
    parameters = {"mass": 1.2, "damper": 0.4, "bearing": 0.2, "stiffness": 310.0}
    found = left_open(parameters, rational(parameters, ["1"], ["mass", "damper + bearing", "stiffness"]))
    assert found.open == ("damper", "bearing")
    assert list(found.combinations) == ["bearing + damper"]


def test_neither_products_nor_sums_are_named_by_the_coefficients():
    parameters = {"inertia": 0.01, "constant": 0.05, "resistance": 2.0, "friction": 1e-3}
    form = rational(parameters, ["constant/resistance"], ["inertia", "friction + constant^2/resistance", "0"])
    found = left_open(parameters, form)
    assert set(found.open) == set(parameters)
    assert len(found.combinations) == 2
    plant = PhysicalPlant(parameters, form)
    values = [plant.combination(c)[0] for c in found.combinations]
    np.testing.assert_allclose(values, [2.5, (1e-3 + 0.05**2 / 2.0) / 0.01])


def test_a_free_decay_says_nothing_of_the_numerator():
    found = left_open(
        SPRING, rational(SPRING, ["1"], ["mass", "damping", "stiffness"]), rows=np.array([False, True, True])
    )
    assert list(found.combinations) == ["damping/mass", "stiffness/mass"]


def test_state_space_is_the_transfer_function_that_control_finds():
    control = pytest.importorskip("control")
    values = {"m1": 1.0, "m2": 0.5, "k": 100.0, "c": 0.2}
    form = StateSpaceForm(tuple(values), TWO_MASSES, ("0", "1/m1", "0", "0"), ("0", "0", "1", "0"))
    plant = PhysicalPlant(values, form).transfer_function()
    k, c = 100.0, 0.2
    matrix = np.array([[0, 1, 0, 0], [-k, -c, k, c], [0, 0, 0, 1], [2 * k, 2 * c, -2 * k, -2 * c]], dtype=float)
    wanted = control.ss(matrix, [[0], [1], [0], [0]], [[0, 0, 1, 0]], 0)
    frequencies = np.geomspace(0.5, 50.0, 30)
    np.testing.assert_allclose(plant.frequency_response(frequencies), wanted(1j * frequencies), rtol=1e-9)


def test_deviations_of_a_combination_are_carried_over():
    parameters = {"mass": 2.0, "stiffness": 8.0}
    form = rational(parameters, ["1"], ["mass", "0", "stiffness"])
    plant = PhysicalPlant(parameters, form, covariance=[[0.01, 0.0], [0.0, 0.04]])
    value, deviation = plant.combination("stiffness/mass")
    assert value == 4.0
    assert deviation == pytest.approx(np.hypot(4.0 * 0.1 / 2.0, 0.2 / 2.0), rel=1e-4)
