"""The engine against an adaptive integrator with events, and what it must not do."""

import time as clock
from math import cos, exp, pi, sin

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.effects import (
    actuator,
    bristle_friction,
    damping,
    dead_zone,
    disturbance,
    drift,
    friction,
    gradual_saturation,
    gravity,
    hysteresis,
    modes,
    plant_force,
    sensor,
    stiffness,
)
from camid.engine.mechanics import Chain, NotApplicable
from camid.engine.run import ROUGH, move, run
from camid.fitting.initial_motion import companion_state
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.structure import Structure
from tests.support.adaptive_integration import Reference, follow, mapped, pieces_of, play

OMEGA = 10.0
PLANT = second_order(1.0, OMEGA, 0.1)
LAGGED = PLANT * TransferFunction((1.0,), (0.05, 1.0))
FIRST = TransferFunction((2.0,), (0.1, 1.0))
START = 7.0
ERROR = 1e-4


def bouc_wen(h, k):
    return {
        "force": lambda t, y, v, u, m: h * m,
        "memory": lambda v, m: k * (v - 0.5 * abs(v) * m - 0.5 * v * abs(m)),
        "kinks": (lambda t, y, v: v,),
    }


def bristles(level, rest, displacement):
    """Friction whose level depends on the speed, with pre-sliding displacement."""
    return {
        "force": lambda t, y, v, u, m: rest * m,
        "memory": lambda v, m: (v - rest / level(abs(v)) * abs(v) * m) / displacement,
        "kinks": (lambda t, y, v: v,),
    }


def lugre(coulomb, breakaway, velocity, displacement):
    return bristles(lambda v: coulomb + (breakaway - coulomb) * exp(-((v / velocity) ** 2)), breakaway, displacement)


def stop(p, k):
    depth = (lambda y: max(y - p, 0.0)) if p >= 0.0 else (lambda y: min(y - p, 0.0))
    return {"force": lambda t, y, v, u, m: k * depth(y), "kinks": (lambda t, y, v: y - p,)}


def drifting(rate, stiffness=0.0, damping=0.0, gain=0.0):
    return {"force": lambda t, y, v, u, m: rate * t * (stiffness * y + damping * v - gain * u)}


FRICTION = [
    (friction.CoulombFriction(force=f), {"level": lambda t, y, speed, f=f: f}) for f in (0.02, 0.1, 0.35, 0.6)
] + [
    (
        friction.StribeckFriction(coulomb=c, breakaway=b, velocity=s),
        {"level": lambda t, y, speed, c=c, b=b, s=s: c + (b - c) * exp(-((speed / s) ** 2))},
    )
    for c, b, s in ((0.1, 0.16, 2.0), (0.05, 0.3, 0.3), (0.2, 0.4, 1.0))
]
SMOOTH = [
    (stiffness.CubicStiffness(coefficient=0.1), {"force": lambda t, y, v, u, m: 0.1 * y**3}),
    (stiffness.CubicStiffness(coefficient=1.0), {"force": lambda t, y, v, u, m: y**3}),
    (stiffness.QuadraticStiffness(coefficient=0.05), {"force": lambda t, y, v, u, m: 0.05 * y * y}),
    (gravity.PendulumGravity(amplitude=3.0), {"force": lambda t, y, v, u, m: 3.0 * sin(y / 3.0) - y}),
    (
        gravity.PendulumDrivenAcross(amplitude=1.5),
        {"force": lambda t, y, v, u, m: 1.5 * sin(y / 1.5) - y + u * (1.0 - cos(y / 1.5))},
    ),
    (drift.ParameterDrift(coefficient="stiffness", rate=0.1), drifting(0.1, stiffness=1.0)),
    (drift.ParameterDrift(coefficient="gain", rate=0.1), drifting(0.1, gain=1.0)),
    (
        gravity.PendulumAtAnAngle(amplitude=1.5, rest=0.3),
        {"force": lambda t, y, v, u, m: 1.5 * (sin(y / 1.5 + 0.2) - sin(0.2)) / cos(0.2) - y},
    ),
    (
        drift.SettlingDrift(coefficient="gain", rate=0.1, time_constant=2.0),
        {"force": lambda t, y, v, u, m: -0.2 * (1.0 - exp(-t / 2.0)) * u},
    ),
    (
        disturbance.PeriodicDisturbance(amplitude=0.3, frequency=23.0, phase=1.0),
        {"force": lambda t, y, v, u, m: -0.3 * sin(23.0 * t + 1.0)},
    ),
    (
        disturbance.StepDisturbance(size=0.3, time=7.4163),
        {"force": lambda t, y, v, u, m: -0.3 * (t >= 7.4163), "times": (7.4163,)},
    ),
    (disturbance.ImpulseDisturbance(size=0.1, time=7.3163), {"impulses": ((7.3163, 0.1),)}),
    (modes.ExtraMode(natural_frequency=60.0, damping=0.05), {"mode": (60.0, 0.05)}),
    (actuator.ActuatorLag(time_constant=0.013), {"lag": 0.013}),
]
VELOCITY = [
    (drift.ParameterDrift(coefficient="damping", rate=0.1), None),
    *(
        (
            damping.QuadraticDrag(coefficient=c),
            {"force": lambda t, y, v, u, m, c=c: c * abs(v) * v, "kinks": (lambda t, y, v: v,)},
        )
        for c in (0.01, 0.2)
    ),
]
EVENTS = [
    *((stiffness.EndStop(position=p, stiffness=k), stop(p, k)) for p, k in ((0.6, 1.0), (0.6, 100.0), (-0.5, 10.0))),
    *((hysteresis.Hysteresis(strength=h, shape=k), bouc_wen(h, k)) for h, k in ((0.1, 1.0), (0.3, 20.0), (0.2, 200.0))),
]
BRISTLES = [
    *(
        (bristle_friction.CoulombBristleFriction(force=f, presliding=d), bristles(lambda v, f=f: f, f, d))
        for f, d in ((0.1, 0.2), (0.4, 0.05), (0.3, 0.005))
    ),
    *(
        (bristle_friction.StribeckBristleFriction(coulomb=c, breakaway=b, velocity=v, presliding=d), lugre(c, b, v, d))
        for c, b, v, d in ((0.1, 0.3, 2.0, 0.1), (0.2, 0.35, 0.5, 0.02))
    ),
]
FORCES = [*FRICTION, *SMOOTH, *VELOCITY, *EVENTS, *BRISTLES]


def name(case):
    return str(case[0])


def signal_of(count, seed=3):
    return np.repeat(np.random.default_rng(seed).choice([-1.0, -0.5, 0.3, 1.0], count // 3), 3)


def largest_error(plant, effects, terms, period, hold, count=48, pieces=None, state=None):
    """Largest error of a full and of a short, late exposure, in standard deviations of the output."""
    signal, time = signal_of(count), START + period * np.arange(count)
    behind = pieces_of(signal, period, hold, START)
    reference = Reference(plant.numerator, plant.denominator, **terms)
    reference.run(behind if pieces is None else pieces(behind), state)
    errors = []
    for acquisition in (Acquisition(period, hold), Acquisition(period, hold, "camera", 0.4 * period, 0.3 * period)):
        found = run(Chain(plant, acquisition, effects), signal, time)
        end = time - acquisition.latency
        expected = reference.mean(end - acquisition.exposure, end)
        errors.append(np.max(np.abs(found - expected)) / np.std(expected))
    return max(errors)


def terms_of(case, plant):
    return drifting(0.1, damping=plant_force.static_damping(plant)) if case[1] is None else case[1]


@pytest.mark.parametrize(("speed", "hold"), [(0.2, "zoh"), (0.2, "foh"), (1.5, "zoh"), (1.5, "foh")])
@pytest.mark.parametrize("case", FORCES, ids=name)
def test_forces_equal_adaptive_integration(case, speed, hold):
    assert largest_error(PLANT, (case[0],), terms_of(case, PLANT), speed / OMEGA, hold, 30) < ERROR


@pytest.mark.parametrize("case", [SMOOTH[0], *SMOOTH[3:], *VELOCITY[:2]], ids=name)
def test_forces_on_a_plant_with_a_lag_equal_adaptive_integration(case):
    assert largest_error(LAGGED, (case[0],), terms_of(case, LAGGED), 0.03, "zoh") < ERROR


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize("case", [FRICTION[0], FRICTION[2], *VELOCITY, SMOOTH[0], SMOOTH[6], EVENTS[0]], ids=name)
def test_forces_on_a_first_order_plant_equal_adaptive_integration(case, hold):
    assert largest_error(FIRST, (case[0],), terms_of(case, FIRST), 0.03, hold, 30) < ERROR


@pytest.mark.parametrize("case", [FRICTION[1], *EVENTS[:1], *EVENTS[3:4], VELOCITY[1]], ids=name)
def test_a_plant_with_a_negative_gain_is_held_back_all_the_same(case):
    """With y turned round the forces against the motion are the same, and only the sign of y is another."""
    effect = case[0]
    turned = TransferFunction((-100.0,), PLANT.denominator)
    signal, time = signal_of(60), 0.02 * np.arange(60)
    if effect.identifier == "end-stop":
        other = type(effect)(position=-effect.values["position"], stiffness=effect.values["stiffness"])
    else:
        other = effect
    acquisition = Acquisition(0.02)
    assert np.allclose(
        run(Chain(turned, acquisition, (other,)), signal, time),
        -run(Chain(PLANT, acquisition, (effect,)), signal, time),
    )


def beyond(value, middle):
    """What a dead zone of 0.4 leaves of a value in a piece with this middle."""
    return (abs(value) - 0.4) * np.sign(middle) if abs(middle) > 0.4 else 0.0


ACTUATORS = [
    (dead_zone.DeadZone(half_width=0.4), lambda p: mapped(p, [-0.4, 0.4], beyond)),
    (actuator.Saturation(limit=0.6), lambda p: mapped(p, [-0.6, 0.6], lambda u, m: np.clip(u, -0.6, 0.6))),
    (actuator.GainAsymmetry(ratio=0.7), lambda p: mapped(p, [0.0], lambda u, m: u * (0.7 if m < 0.0 else 1.0))),
    (actuator.InputBias(bias=0.2), lambda p: mapped(p, [], lambda u, m: u + 0.2)),
    (actuator.Backlash(half_width=0.3), lambda p: play(p, 0.3)),
    (actuator.RateLimit(rate=20.0), lambda p: follow(p, 20.0)),
    (actuator.RateLimit(rate=3.0), lambda p: follow(p, 3.0)),
]  # fmt: skip


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize("speed", [0.2, 1.5])
@pytest.mark.parametrize(("effect", "pieces"), ACTUATORS, ids=[str(e) for e, _ in ACTUATORS])
def test_actuators_equal_adaptive_integration(effect, pieces, speed, hold):
    assert largest_error(PLANT, (effect,), {}, speed / OMEGA, hold, pieces=pieces) < ERROR


def test_several_effects_at_once():
    effects = (
        modes.ExtraMode(natural_frequency=60.0, damping=0.05),
        friction.CoulombFriction(force=0.1),
        stiffness.CubicStiffness(coefficient=0.3),
        actuator.ActuatorLag(time_constant=0.01),
        actuator.Saturation(limit=0.8),
        disturbance.StepDisturbance(size=0.3, time=START + 0.4163),
    )
    terms = {
        "level": lambda t, y, speed: 0.1,
        "force": lambda t, y, v, u, m: 0.3 * y**3 - 0.3 * (t >= START + 0.4163),
        "times": (START + 0.4163,),
        "lag": 0.01,
        "mode": (60.0, 0.05),
    }

    def pieces(given):
        return mapped(given, [-0.8, 0.8], lambda u, m: np.clip(u, -0.8, 0.8))

    assert largest_error(PLANT, effects, terms, 0.02, "zoh", pieces=pieces) < ERROR


@pytest.mark.parametrize(
    ("fast", "terms"),
    [
        (actuator.ActuatorLag(time_constant=0.0005), {"lag": 0.0005}),
        (modes.ExtraMode(natural_frequency=1500.0, damping=0.4), {"mode": (1500.0, 0.4)}),
    ],
    ids=lambda given: type(given).__name__,
)
def test_dynamics_far_faster_than_the_frames_do_not_upset_friction(fast, terms):
    """Forty radians a frame, where a few Runge–Kutta steps would be unstable."""
    effects = (fast, friction.CoulombFriction(force=0.1))
    terms = terms | {"level": lambda t, y, speed: 0.1}
    assert largest_error(PLANT, effects, terms, 0.02, "zoh", 30) < 10.0 * ERROR
    signal, time = signal_of(300), 0.02 * np.arange(300)
    fine, rough = (
        run(Chain(PLANT, Acquisition(0.02, "zoh"), effects, steps=steps), signal, time) for steps in (None, ROUGH)
    )
    assert np.max(np.abs(rough - fine)) < 1e-2 * np.std(fine)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_linear_chains_are_exact(hold):
    signal, time = signal_of(90), 0.02 * np.arange(90)
    acquisition = Acquisition(0.02, hold, "camera", 0.013, 0.031)
    assert np.array_equal(run(Chain(PLANT, acquisition), signal, time), sample(PLANT, signal, acquisition))
    delayed = run(Chain(PLANT, acquisition, (sensor.Delay(delay=0.007),)), signal, time)
    assert np.array_equal(delayed, sample(PLANT, signal, Acquisition(0.02, hold, "camera", 0.013, 0.038)))
    lag, mode = actuator.ActuatorLag(time_constant=0.01), modes.ExtraMode(natural_frequency=70.0, damping=0.1)
    whole = PLANT * TransferFunction((1.0,), (0.01, 1.0)) * second_order(1.0, 70.0, 0.1)
    assert np.allclose(
        run(Chain(PLANT, acquisition, (lag, mode)), signal, time), sample(whole, signal, acquisition), atol=1e-12
    )


@pytest.mark.parametrize("before_record", [True, False])
@pytest.mark.parametrize("plant", [PLANT, LAGGED, FIRST, TransferFunction((3.0, 100.0), (1.0, 4.0, 100.0))])
def test_initial_state_is_that_of_the_predictor(plant, before_record):
    monic = plant.monic
    structure = Structure(
        np.asarray(monic.numerator),
        np.asarray(monic.denominator),
        np.ones(len(monic.numerator), bool),
        np.arange(len(monic.denominator)) > 0,
    )
    signal, time = signal_of(60), START + 0.02 * np.arange(60)
    acquisition = Acquisition(0.02, "zoh", "camera", 0.008, 0.025)
    used = np.arange(60) >= (0 if before_record else 3)
    experiment = Experiment(signal, np.zeros(60), acquisition, used, estimate_initial_state=True)
    coefficients = structure.coefficients()
    predictor = Predictor.around(structure, [experiment], np.asarray(monic.denominator))
    polynomial = np.array([0.7, -0.4, 0.2])[: structure.order]
    expected = predictor.simulate(predictor.from_physical(coefficients, polynomial))[0]
    state = companion_state(structure, coefficients, polynomial)
    chain = Chain(plant, acquisition, (), state, experiment.free_motion_before_record)
    found = run(chain, signal, time)
    assert experiment.free_motion_before_record == before_record
    assert np.allclose(found[used], expected[used], atol=1e-7 * np.std(expected))


def test_a_force_that_needs_a_motion_which_jumps_with_the_input_is_refused():
    jumping = TransferFunction((1.0, 2.0), (1.0, 1.0))
    for effect in (friction.CoulombFriction(force=0.1), stiffness.CubicStiffness(coefficient=0.1)):
        with pytest.raises(NotApplicable, match="jumps"):
            run(Chain(jumping, Acquisition(0.1), (effect,)), np.ones(5), 0.1 * np.arange(5))


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_friction_that_acts_with_a_lag_does_not_chatter(hold):
    """It takes energy away, brings a body without force to rest, and costs no more than a few steps a frame."""
    signal, time = signal_of(1500), 0.02 * np.arange(1500)
    signal[900:] = 0.0
    acquisition = Acquisition(0.02, hold)
    chain = Chain(LAGGED, acquisition, (friction.CoulombFriction(force=0.1),))
    found = run(chain, signal, time)
    begin = clock.perf_counter()
    run(chain, signal, time)
    assert clock.perf_counter() - begin < 0.5
    linear = sample(LAGGED, signal, acquisition)
    assert 0.5 * np.std(linear[:900]) < np.std(found[:900]) < np.std(linear[:900])
    assert np.ptp(found[1400:]) < 1e-3 * np.ptp(found[:900])


EXTREME = [
    friction.CoulombFriction(force=1e9),
    friction.StribeckFriction(coulomb=0.0, breakaway=1e6, velocity=1e-9),
    damping.QuadraticDrag(coefficient=10.0),
    stiffness.CubicStiffness(coefficient=1e4),
    gravity.PendulumGravity(amplitude=1e-9),
    gravity.PendulumDrivenAcross(amplitude=1e-9),
    gradual_saturation.GradualSaturation(limit=1e-300, sharpness=20.0),
    gradual_saturation.GradualSaturation(limit=1e300, sharpness=1.0),
    stiffness.EndStop(position=1e-9, stiffness=1e9),
    stiffness.EndStop(position=-0.5, stiffness=1e6),
    hysteresis.Hysteresis(strength=1e3, shape=1e6),
    hysteresis.Hysteresis(strength=1.0, shape=1e-12),
    disturbance.PeriodicDisturbance(amplitude=1.0, frequency=1e5, phase=0.0),
    disturbance.ImpulseDisturbance(size=1e6, time=-5.0),
    disturbance.StepDisturbance(size=1.0, time=1e9),
    sensor.RollingShutter(time_per_unit=1e6),
    sensor.ClockSkew(skew=0.5),
    actuator.RateLimit(rate=0.0),
    actuator.RateLimit(rate=1e12),
]


@pytest.mark.parametrize("effect", EXTREME, ids=str)
def test_extreme_parameters_give_finite_outputs_in_bounded_time(effect):
    signal, time = signal_of(300), START + 0.02 * np.arange(300)
    run(Chain(PLANT, Acquisition(0.02, "foh"), (effect,)), signal[:9], time[:9])
    begin = clock.perf_counter()
    found = run(Chain(PLANT, Acquisition(0.02, "foh"), (effect,)), signal, time)
    assert clock.perf_counter() - begin < 3.0
    assert np.all(np.isfinite(found))


def test_a_body_under_friction_that_nothing_overcomes_stays_where_it_is():
    found = run(
        Chain(PLANT, Acquisition(0.02), (friction.CoulombFriction(force=1.1),)), signal_of(90), 0.02 * np.arange(90)
    )
    assert np.array_equal(found, np.zeros(90))


def test_free_decay_under_friction_falls_by_the_same_amount_each_half_period():
    """Textbook: without viscous damping the amplitude falls by 2 f_c / k in half a period."""
    undamped = second_order(1.0, OMEGA, 0.0)
    state = np.array([0.0, 1.0])  # z' and z of z = u / A in scaled time
    time = 0.01 * np.arange(400)
    motion = move(
        Chain(undamped, Acquisition(0.01, sensor="instant"), (friction.CoulombFriction(force=0.04),), state),
        0.0 * time,
        time,
    )
    peaks = np.abs(motion.at(np.array([k * pi / OMEGA for k in range(4)])))
    assert np.diff(peaks) == pytest.approx(-2.0 * 0.04, rel=1e-4)
