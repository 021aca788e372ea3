"""Equations against the linear path, and against an integrator of SciPy's."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from camid.chain.acquisition import Acquisition
from camid.effects.known import declarable_effects
from camid.engine.mechanics import Chain
from camid.engine.nonlinear_plant import NonlinearPlant
from camid.engine.run import run
from camid.physical.equations import Equations, coefficients_at, state_at_rest

PERIOD = 0.01
SPRING = Equations(
    ("m", "c", "k"), (("position", "speed"), ("speed", "(u - c*speed - k*position)/m")), "position", "u", (0.0, 0.0)
)
VALUES = np.array([1.3, 2.0, 310.0])
TANKS = Equations(
    ("pump", "out"),
    (("upper", "pump*u - out*sqrt(max(upper, 0))"), ("lower", "out*(sqrt(max(upper, 0)) - sqrt(max(lower, 0)))")),
    "lower",
    "u",
    (2.0, 3.0),
)


def signal(rows, seed=0):
    return np.repeat(np.random.default_rng(seed).choice([-1.0, 0.5, 1.0], rows // 5), 5)


EFFECTS = {
    "none": (),
    "friction": (("coulomb-friction", {"force": 0.15}),),
    "stop": (("end-stop", {"position": 0.005, "stiffness": 2000.0}),),
    "spring": (("cubic-stiffness", {"coefficient": 3e6}),),
    "lag and friction": (("coulomb-friction", {"force": 0.15}), ("actuator-lag", {"time_constant": 0.02})),
    "impulse": (("impulse-disturbance", {"size": 0.05, "time": 3.333}),),
    "beside": (("parallel-mode", {"gain": 1e-3, "natural_frequency": 60.0, "damping": 0.05}),),
}


@pytest.mark.parametrize("name", EFFECTS)
def test_linear_equations_are_the_linear_plant(name):
    """The same chain by the matrix exponential and by Runge-Kutta steps of the equations."""
    effects = tuple(declarable_effects()[i](**values) for i, values in EFFECTS[name])
    plant = NonlinearPlant(SPRING, VALUES)
    linear = plant.about_start.transfer_function()
    np.testing.assert_allclose(linear.numerator, [1.0 / 1.3], rtol=1e-9)
    np.testing.assert_allclose(linear.denominator, [1.0, 2.0 / 1.3, 310.0 / 1.3], rtol=1e-9)
    acquisition = Acquisition(PERIOD, "zoh", "camera", PERIOD, 0.0)
    u, t = signal(600), PERIOD * np.arange(600)
    wanted = run(Chain(linear, acquisition, effects), u, t)
    found = run(Chain(linear, acquisition, effects, equations=plant), u, t)
    assert np.max(np.abs(found - wanted)) < 1e-4 * np.std(wanted)


def test_two_tanks_against_scipy():
    values, period = np.array([0.5, 0.4]), 0.5
    u, t = signal(200, 1) + 1.5, period * np.arange(200)

    def flow(time, state):
        held = u[min(int(time / period + 1e-12), len(u) - 1)]
        above, below = np.sqrt(np.maximum(state, 0.0))
        return [0.5 * held - 0.4 * above, 0.4 * (above - below)]

    states, wanted = np.array([2.0, 3.0]), []
    for k in range(len(u)):
        wanted.append(states[1])
        states = solve_ivp(lambda _, state, k=k: flow(t[k], state), (0.0, period), states, rtol=1e-10, atol=1e-12).y[
            :, -1
        ]
    plant = NonlinearPlant(TANKS, values)
    chain = Chain(
        plant.about_start.transfer_function(), Acquisition(period, "zoh", "instant", None, 0.0), equations=plant
    )
    np.testing.assert_allclose(run(chain, u, t), wanted, atol=1e-6)


def test_a_limited_state_does_not_rise_above_its_edge():
    values, period = np.array([0.5, 0.4]), 0.5
    u, t = np.full(400, 3.0), period * np.arange(400)
    plant = NonlinearPlant(TANKS, values)
    linear, acquisition = plant.about_start.transfer_function(), Acquisition(period, "zoh", "instant", None, 0.0)
    free = run(Chain(linear, acquisition, equations=plant), u, t)
    overflow = declarable_effects()["overflow"](height=4.0, share=0.0, state="upper")
    limited = run(Chain(linear, acquisition, (overflow,), equations=plant), u, t)
    assert free[-1] > 10.0
    assert limited[-1] == pytest.approx(4.0, rel=0.05)  # both tanks have the same outflow
    passed_on = declarable_effects()["overflow"](height=4.0, share=1.0, state="upper")
    assert run(Chain(linear, acquisition, (passed_on,), equations=plant), u, t)[-1] == pytest.approx(free[-1], rel=0.05)


def test_state_at_rest():
    assert state_at_rest(TANKS, np.array([0.5, 0.4]), 4.0) == pytest.approx({"upper": 4.0, "lower": 4.0})


def test_small_motions_about_a_large_state_are_exact():
    """By differences the damping would be lost in the rounding of a force of the size of the stiffness."""
    states = (("s", "v"), ("v", "u - k*s - c*v"))
    equations = Equations(("k", "c"), states, "s", "u", (80.0, 0.0))
    values = np.array([16.8, 0.14])
    np.testing.assert_allclose(coefficients_at(equations, values, 3), [1.0, 0.14, 16.8], rtol=1e-14)
    moved = coefficients_at(equations, values * (1.0 + np.array([0.0, 1e-7])), 3)
    assert moved[1] - 0.14 == pytest.approx(1.4e-8, rel=1e-6)
