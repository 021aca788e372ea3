"""The zero of the sensor and the bias of the input are unknown unless something is said of them."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.errors import InputError
from camid.identification.accuracy import cramer_rao_bound
from tests.support import linear_rig as rig

SENSOR = {"column": "y", "kind": "camera"}
TRUTH = np.array([*rig.NUMERATOR, *rig.DENOMINATOR])


def coefficients(result):
    plant = result.simulation.plant
    return np.array([*plant.numerator, *plant.denominator])


def believed(**changes):
    return rig.simulation(plant=rig.plant([200.0], [2.0, 9.0, 260.0]), **changes)


@pytest.mark.parametrize("state", ["zero", "estimate"])
@pytest.mark.parametrize("deviations", [0.0, -2.5, 1e4])
def test_an_offset_changes_nothing_but_itself(state, deviations):
    """To numbers of pixels: 10⁴ standard deviations; the digits that they cost are those of the file."""
    table = rig.recording(noise=0.1)
    offset = deviations * float(np.std(table["y"]))
    content = believed(initial_state=state)
    reference, shifted = (camid.identify(table.assign(y=table["y"] + b), content) for b in (0.0, offset))
    np.testing.assert_allclose(coefficients(shifted), coefficients(reference), rtol=1e-7)
    difference = shifted.simulation.offset - reference.simulation.offset
    assert difference == pytest.approx(offset, abs=1e-9 * abs(offset) + 1e-12)
    assert abs(reference.simulation.offset) < 4.0 * reference.simulation.offset_deviation
    assert shifted.warnings() == []


def test_recovery_without_noise_is_as_exact_as_with_a_known_zero():
    """The reference integrates by Simpson's rule, whose error both share."""
    table = rig.recording(noise=0.0)
    known = camid.identify(table, believed(sensor=SENSOR | {"offset": 0.0}))
    free = camid.identify(table.assign(y=table["y"] + 7.0), believed())
    np.testing.assert_allclose(coefficients(free), coefficients(known), rtol=1e-9)
    assert free.simulation.offset == pytest.approx(7.0, abs=1e-9)


def test_the_price_of_an_unknown_zero_is_the_cramer_rao_bounds_and_small():
    """The input changes its level about zero, so the gain loses less than a hundredth of its accuracy."""
    table = rig.recording(noise=0.1)
    plant = TransferFunction(tuple(rig.NUMERATOR), tuple(rig.DENOMINATOR)).monic
    result = camid.identify(table, believed())
    signal = table["u"].to_numpy()
    known, unknown = (
        np.sqrt(np.diag(cramer_rao_bound(plant, signal, Acquisition(rig.PERIOD), 1.0, estimate_offset=unknown)))
        for unknown in (False, True)
    )
    assert np.all(unknown >= known * (1.0 - 1e-12))
    assert np.all(unknown <= 1.02 * known)
    noise = np.sqrt(result.estimate.noise_variance)
    np.testing.assert_allclose(result.estimate.standard_deviations, noise * unknown, rtol=0.1)


def test_the_errors_of_an_offset_are_those_that_are_stated():
    errors = []
    for seed in range(40):
        table = rig.recording(200, seed=seed)
        found = camid.identify(table.assign(y=table["y"] + 100.0), believed()).simulation
        errors.append((found.offset - 100.0) / found.offset_deviation)
    assert 0.65 < np.sqrt(np.mean(np.square(errors))) < 1.4  # χ² with 40 degrees of freedom, 99.9 %


def test_a_free_decay_with_an_offset():
    time = 0.05 * np.arange(400)
    swing = np.exp(-0.2 * time) * np.cos(3.0 * time)
    table = pd.DataFrame({"t": time, "y": swing + 40.0})
    content = rig.simulation(
        input=None,
        plant=rig.plant([9.0], [1.0, 0.2, 8.0]),
        sensor=SENSOR | {"kind": "instant"},
        initial_state="estimate",
    )
    result = camid.identify(table, content)
    assert result.nrmse < 1e-9
    np.testing.assert_allclose(result.simulation.plant.denominator, [1.0, 0.4, 9.04], rtol=1e-9)
    assert result.simulation.offset == pytest.approx(40.0, rel=1e-12)


def integrator(bias, count=400):
    """A mass with a damper, by an integration that knows the solution of a step: ẍ + 2ẋ = 3 (u + bias)."""
    signal = rig.steps(count, length=6)
    position, velocity, rows = 0.0, 0.0, []
    for level in signal + bias:
        rows.append(position)
        final = 1.5 * level
        position += final * 0.05 + (velocity - final) * (1.0 - np.exp(-0.1)) / 2.0
        velocity = final + (velocity - final) * np.exp(-0.1)
    return pd.DataFrame({"t": 0.05 * np.arange(count), "u": signal, "y": rows})


INTEGRATOR = rig.plant([2.0], [1.0, 1.0, 0.0])


def test_an_integrator_shows_the_bias_of_its_input_and_its_offset():
    table = integrator(0.3)
    content = rig.simulation(plant=INTEGRATOR, sensor=SENSOR | {"kind": "instant"})
    result = camid.identify(table.assign(y=table["y"] + 5.0), content)
    found = result.simulation
    np.testing.assert_allclose([*found.plant.numerator, *found.plant.denominator], [3.0, 1.0, 2.0, 0.0], rtol=1e-8)
    assert found.bias == pytest.approx(0.3, rel=1e-8)
    assert found.offset == pytest.approx(5.0, rel=1e-8)
    assert found.bias_deviation is not None
    again = camid.simulate(table, found)
    np.testing.assert_allclose(again["simulated"], table["y"] + 5.0, atol=1e-6)


def test_what_cannot_be_told_apart_is_said():
    moving = rig.simulation(plant=INTEGRATOR, sensor=SENSOR | {"kind": "instant"}, initial_state="estimate")
    result = camid.identify(integrator(0.3)[50:], moving)
    assert result.simulation.offset is None
    assert result.simulation.bias == pytest.approx(0.3, rel=1e-6)
    (sentence,) = result.warnings()
    assert "initial state" in sentence
    step = pd.DataFrame({"t": rig.PERIOD * np.arange(300), "u": np.ones(300), "y": rig.film(np.ones(300))})
    (sentence,) = camid.identify(step, believed(initial_state="estimate")).warnings()
    assert "the input is constant" in sentence
    assert camid.identify(step, believed()).warnings() == []  # from rest the transient tells


def test_simulate_adds_a_declared_offset_and_fits_one_where_it_is_told_to():
    table = rig.recording(noise=0.0)
    plain = camid.simulate(table, rig.simulation())["simulated"]
    shifted = table.assign(y=table["y"] + 4.0)
    np.testing.assert_array_equal(camid.simulate(shifted, rig.simulation())["simulated"], plain)
    declared = camid.simulate(table, rig.simulation(sensor=SENSOR | {"offset": 4.0}))
    np.testing.assert_allclose(declared["simulated"], plain + 4.0, rtol=1e-12)
    fitted = camid.simulate(shifted, rig.simulation(sensor=SENSOR | {"offset": "estimate"}))
    np.testing.assert_allclose(fitted["simulated"], plain + 4.0, atol=1e-6)
    with pytest.raises(InputError, match="y"):
        camid.simulate(table.drop(columns="y"), rig.simulation(sensor=SENSOR | {"offset": "estimate"}))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plant": {"pendulum": {"natural_frequency": 3.0, "damping": 0.01, "gain": 1.0, "rest": 0.0}}}, "pendulum"),
        ({"controller": {"reference": "r", "position_gain": 1.0, "velocity_gain": 1.0}}, "closed loop"),
    ],
)
def test_an_offset_that_nothing_tells_apart_is_refused(changes, words):
    with pytest.raises(InputError, match=words):
        camid.identify(rig.recording(), rig.simulation(sensor=SENSOR | {"offset": "estimate"}, **changes))


def test_the_choice_of_the_order_is_that_without_the_offset():
    table = rig.recording(600)
    first, second = (camid.select_order(table.assign(y=table["y"] + b), rig.simulation()) for b in (0.0, 300.0))
    assert (first.poles, first.zeros) == (second.poles, second.zeros) == (2, 0)
    np.testing.assert_allclose(second.table["delta_bic"], first.table["delta_bic"], rtol=1e-3, atol=0.1)
