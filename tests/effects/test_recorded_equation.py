"""Plants beside a force over the position, by their equation at the recorded positions."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.recorded_equation import plant_beside_stop
from camid.effects.situation import Situation
from camid.effects.stiffness import EndStop

PERIOD, ROWS = 0.05, 3000
GAIN, RATE = 0.45, 3.0
PLACE, STIFFNESS = 35.0, 3.0
# What an estimation without the stop ends in: no motor.
BENT = TransferFunction((27.0,), (1.0, 230.0, 0.0))
BUTTONS = (-1.0, -0.4, 0.0, 0.5, 0.8, 1.0)


@pytest.fixture(scope="module")
def actuator():
    """Time, command and stroke of a spindle that is driven into a buffer by hand, by another integrator."""
    generator = np.random.default_rng(4)
    time = PERIOD * np.arange(ROWS)
    command = 40.0 * np.repeat(generator.choice(BUTTONS, ROWS // 60), 60)

    def motion(t, x):
        pushed = command[min(int(t / PERIOD), ROWS - 1)]
        contact = STIFFNESS * max(x[0] - PLACE, 0.0) + 0.5 * max(x[0] - PLACE, 0.0) ** 2
        return [x[1], GAIN * (pushed - contact) - RATE * x[1]]

    found = solve_ivp(motion, (0.0, time[-1]), [5.0, 0.0], t_eval=time, rtol=1e-8, max_step=PERIOD)
    return time, command, np.round(found.y[0] + 0.02 * generator.normal(size=ROWS), 2)


def situation(time, command, stroke, plant=BENT):
    """What effects are told of a recording, with a simulation that is somewhere else."""
    nothing = np.zeros(ROWS)
    used = np.ones(ROWS, bool)
    return Situation(
        time, command, stroke, nothing, nothing, nothing, plant, Acquisition(PERIOD, sensor="instant"), used
    )


def test_the_stop_and_the_plant_beside_it_are_seen_before_anything_is_fitted(actuator):
    found = plant_beside_stop(situation(*actuator))
    assert found.place == pytest.approx(PLACE, rel=0.05)
    assert found.stiffness > STIFFNESS  # the buffer is progressive
    assert found.plant.denominator[1] == pytest.approx(RATE, rel=0.1)
    assert found.plant.numerator[0] == pytest.approx(GAIN, rel=0.1)
    assert found.plant.denominator[2] == 0.0


def test_only_a_plant_that_integrates_needs_one(actuator):
    (stop, plant, constants) = EndStop.with_plant(situation(*actuator), {"bias": 0.3, "offset": 1.0})
    assert type(stop) is EndStop
    assert set(constants) == {"bias"}
    assert plant.denominator[2] == 0.0
    spring = TransferFunction((27.0,), (1.0, 230.0, 4.0))
    assert EndStop.with_plant(situation(*actuator, plant=spring), {}) is None


def test_free_motion_shows_no_stop(actuator):
    time, command, _ = actuator
    velocity = np.zeros(ROWS)
    for k in range(ROWS - 1):
        velocity[k + 1] = velocity[k] + PERIOD * (GAIN * command[k] - RATE * velocity[k])
    position = PERIOD * np.cumsum(velocity)
    assert plant_beside_stop(situation(time, command, position)) is None


def test_a_buffer_of_a_spindle_is_found_though_the_plant_without_it_runs_away(actuator):
    time, command, stroke = actuator
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [0.3], "denominator": [1.0, 2.4, 0.0]}},
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": "estimate",
    }
    found = camid.diagnose(pd.DataFrame({"t": time, "u": command, "y": stroke}), nominal)
    first = found.findings[0]
    assert first.identifier == "end-stop"
    assert first.parameters["position"].value == pytest.approx(PLACE, rel=0.05)
    assert found.fit.improved < 0.05 < found.fit.refitted


def test_a_buffer_in_a_loop_that_is_not_declared_is_found_beside_coefficients_of_either_sign():
    """Without the buffer the plant that is estimated from what the loop commanded may even have the other sign."""
    generator = np.random.default_rng(8)
    period, rows, fine = 0.02, 2500, 20
    wanted = np.repeat(generator.uniform(-0.7, 0.75, rows // 125), 125)
    command, trolley = np.zeros(rows), np.zeros(rows)
    position, velocity = 0.0, 0.0
    for k in range(rows):
        trolley[k] = position
        command[k] = np.clip(6.0 * (wanted[k] - position) - 4.0 * velocity, -3.0, 3.0)
        for _ in range(fine):
            contact = 25.0 * max(position - 0.5, 0.0)
            velocity += period / fine * (0.99 * (command[k] - contact) - 0.4 * velocity)
            position += period / fine * velocity
    recorded = 1.2 + trolley + 0.001 * generator.normal(size=rows)
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [0.8], "denominator": [1.0, 0.5, 0.0]}},
        "sensor": {"column": "y", "kind": "instant"},
    }
    table = pd.DataFrame({"t": period * np.arange(rows), "u": command, "y": recorded})
    found = camid.diagnose(table, nominal)
    assert [f.identifier for f in found.findings] == ["end-stop"]
    for name, truth in (("position", 0.5), ("stiffness", 25.0)):
        assert found.findings[0].parameters[name].value == pytest.approx(truth, rel=0.01)
    assert found.fit.improved < 0.05 < found.fit.refitted
