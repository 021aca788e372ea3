"""Closed loops: the controller inside the simulation, the control as what is compared."""

import numpy as np
import pytest

import camid
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.errors import InputError
from camid.simulation.file import load_simulation
from tests.support import pendulum_and_drive as rigs

RIG = {"mass": 12.0, "viscous": 30.0, "friction": 6.0, "bias": 1.5}
EFFECTS = [
    {"id": "coulomb-friction", "parameters": {"force": 6.0}},
    {"id": "input-bias", "parameters": {"bias": 1.5}},
]


@pytest.mark.parametrize("limit", [None, 25.0])
def test_loop_is_simulated(limit):
    """Against an integrator that shares nothing with the engine, with and without a limit that is reached."""
    recording = rigs.drive(**RIG, limit=limit or np.inf)
    content = rigs.drive_simulation(12.0, 30.0, limit=limit) | {"effects": EFFECTS}
    found = camid.simulate(recording, content)
    if limit:
        assert np.mean(np.abs(recording["u"]) >= limit) > 0.01
    for simulated, recorded in (("simulated_input", "u"), ("simulated", "y")):
        error = found[simulated] - recording[recorded]
        assert np.sqrt(np.mean(error**2)) < 2e-3 * np.std(recording[recorded])


def _dead_zone(command, last, seconds):
    return np.sign(command) * max(abs(command) - 3.0, 0.0)


def _saturation(command, last, seconds):
    return min(max(command, -15.0), 15.0)


def _backlash(command, last, seconds):
    return min(max(last, command - 2.0), command + 2.0)


def _rate_limit(command, last, seconds):
    return last + min(max(command - last, -300.0 * seconds), 300.0 * seconds)


def _asymmetry(command, last, seconds):
    return command if command > 0.0 else 0.7 * command


@pytest.mark.parametrize(
    ("actuator", "identifier", "parameters"),
    [
        (_dead_zone, "dead-zone", {"half_width": 3.0}),
        (_saturation, "saturation", {"limit": 15.0}),
        (_backlash, "backlash", {"half_width": 2.0}),
        (_rate_limit, "rate-limit", {"rate": 300.0}),
        (_asymmetry, "gain-asymmetry", {"ratio": 0.7}),
    ],
)
def test_the_actuator_acts_within_the_loop(actuator, identifier, parameters):
    """What it makes of the controller's own output, not of the recorded one, which would give the answer away."""
    recording = rigs.drive(mass=12.0, viscous=30.0, actuator=actuator)
    content = rigs.drive_simulation(12.0, 30.0)
    plain = camid.simulate(recording, content)["simulated_input"] - recording["u"]
    content["effects"] = [{"id": identifier, "parameters": parameters}]
    found = camid.simulate(recording, content)
    error = found["simulated_input"] - recording["u"]
    assert np.sqrt(np.mean(error**2)) < 0.03 * np.sqrt(np.mean(plain**2))
    content["initial_state"] = "zero"
    known, silent = (camid.simulate(r, content) for r in (recording, recording.assign(u=0.0)))
    np.testing.assert_array_equal(silent["simulated_input"], known["simulated_input"])


def test_every_actuator_acts_within_a_loop():
    for effect in known_effects().values():
        assert (effect.transform is Effect.transform) == (effect.actuated is None), effect.identifier


def test_what_the_loop_hides_is_found():
    """Friction and a bias that the position hardly shows; the error of both control and position is told."""
    recording = rigs.drive(**RIG, noise=0.3, count=600)
    diagnosis = camid.diagnose(recording, rigs.drive_simulation(10.0, 50.0))
    names = {f.identifier: f for f in diagnosis.findings}
    assert set(names) == {"coulomb-friction", "input-bias"}
    for name, parameter, true in (("coulomb-friction", "force", 6.0), ("input-bias", "bias", 1.5)):
        found = names[name].parameters[parameter]
        assert abs(found.value - true) < 4.0 * found.standard_deviation
    refitted, improved = diagnosis.fit.position
    assert improved < 0.2 * refitted
    assert camid.diagnose(recording, diagnosis.improved).verdict == "adequate"


@pytest.fixture(scope="module")
def linear():
    """Diagnosis of a drive without friction."""
    recording = rigs.drive(mass=12.0, viscous=30.0, noise=0.3, count=1500)
    return camid.diagnose(recording, rigs.drive_simulation(10.0, 50.0))


def test_nothing_is_found_where_nothing_is_missing(linear):
    assert linear.verdict == "adequate"


def test_identified_in_its_loop():
    recording = rigs.drive(mass=12.0, viscous=30.0, noise=0.3)
    found = camid.identify(recording, rigs.drive_simulation(9.0, 60.0)).simulation
    assert abs(found.plant.monic.numerator[0] * 12.0 - 1.0) < 0.01
    (_, viscous, _), deviations = found.plant.denominator, found.standard_deviations["denominator"]
    mass = found.plant.denominator[0]
    gain, spread = found.plant.numerator[0], found.standard_deviations["numerator"][0]
    assert mass == 9.0  # the leading coefficient stays as it is written
    assert abs(gain - 9.0 / 12.0) < 4.0 * spread
    assert abs(viscous - 30.0 * 9.0 / 12.0) < 4.0 * deviations[1]


def test_units_of_all_columns():
    """Millimetres, millivolts of an amplifier, a reference with another zero: the same as in SI units."""
    recording = rigs.drive(**RIG, noise=0.3, count=600)
    content = rigs.drive_simulation(12.0, 30.0) | {"effects": EFFECTS}
    expected = camid.simulate(recording, content)
    other = recording.assign(y=1e3 * recording["y"], r=1e3 * recording["r"] + 5.0, u=1e3 * recording["u"] / 20.0)
    content["input"] = content["input"] | {"unit": "mV", "scale": 20.0}
    content["sensor"] = content["sensor"] | {"unit": "mm"}
    content["controller"] = content["controller"] | {"unit": "mm", "offset": -0.005}
    found = camid.simulate(other, content)
    assert np.allclose(found.to_numpy(), expected.to_numpy(), rtol=1e-9, atol=1e-9)
    assert load_simulation(load_simulation(content).to_mapping()).to_mapping() == load_simulation(content).to_mapping()


def test_sensor_effects_are_said_to_be_out_of_sight(linear):
    reasons = {u.identifier: u.reason for u in linear.undetectable}
    assert "closed loop" in reasons["sensor-offset"]
    assert "closed loop" in reasons["delay"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"input": None}, "a controller, but no input column"),
        ({"controller": {"reference": "r", "position_gain": 0, "velocity_gain": 1}}, "position_gain = 0"),
        ({"controller": {"reference": "r", "velocity_gain": 1}}, "position_gain"),
        ({"controller": {"reference": "r", "position_gain": 1, "velocity_gain": 1, "limit": 0}}, "limit"),
    ],
)
def test_wrong_controllers_are_refused(change, said):
    with pytest.raises(InputError) as refused:
        load_simulation(rigs.drive_simulation(1.0, 1.0) | change)
    assert said in str(refused.value)


def test_the_reference_has_to_be_recorded():
    recording = rigs.drive(mass=12.0, viscous=30.0, count=300).drop(columns="r")
    with pytest.raises(InputError, match="no column 'r'"):
        camid.simulate(recording, rigs.drive_simulation(12.0, 30.0))
