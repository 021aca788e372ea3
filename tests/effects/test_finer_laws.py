"""Laws with more detail that bear the name of a simpler one: what they do, and how a simulation declares them."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.effects.actuator import Saturation
from camid.effects.damped_end_stop import DampedEndStop
from camid.effects.dead_zone import DeadZone
from camid.effects.disturbance import PeriodicDisturbance
from camid.effects.drift import SettlingDrift
from camid.effects.extent import Extent
from camid.effects.gradual_dead_zone import GradualDeadZone
from camid.effects.gradual_friction import GradualAsymmetricFriction
from camid.effects.gradual_saturation import GradualSaturation
from camid.effects.gravity import PendulumAtAnAngle, PendulumDrivenAcross, PendulumGravity
from camid.effects.harmonics import (
    CoggingWithHarmonic,
    EncoderEccentricityWithHarmonic,
    PeriodicDisturbanceWithHarmonic,
    SensorOscillationWithHarmonic,
)
from camid.effects.hertz_contact import HertzEndStop
from camid.effects.lens_distortion import LensDistortion, LensDistortionOfFourthOrder
from camid.effects.modes import ExtraMode, ModeDampedBetween
from camid.effects.periodic_in_position import Cogging, EncoderEccentricity
from camid.effects.rate_limited_lag import RateLimitedLag
from camid.effects.sensor_drift import SettlingSensorDrift
from camid.effects.sensor_oscillation import SensorOscillation
from camid.effects.sensor_reading import GradedSpeedWeightedCentroid, SpeedWeightedCentroid
from camid.effects.stiffness import CubicStiffness, EndStop, QuadraticStiffness
from camid.effects.two_term_springs import (
    TYPICAL_DISPLACEMENT,
    CubicStiffnessWithFifthPower,
    CubicStiffnessWithQuadratic,
    QuadraticStiffnessWithCubic,
)
from camid.engine.mechanics import Chain
from camid.engine.run import run
from tests.support.mass_on_spring import PERIOD, PLANT, command, record, simulation

TIME = PERIOD * np.arange(300)


CAMERA, INSTANT = Acquisition(PERIOD, exposure=PERIOD), Acquisition(PERIOD, sensor="instant")


def output(*effects, acquisition=CAMERA):
    """Of the mass on its spring."""
    return run(Chain(PLANT, acquisition, effects), command(300), TIME)


@pytest.mark.parametrize("sharpness", [1.0, 2.4, 9.0])
def test_a_gradual_saturation_bends_a_held_input(sharpness):
    signal = command(300)
    bent = signal / (1.0 + np.abs(signal / 0.8) ** sharpness) ** (1.0 / sharpness)
    found = output(GradualSaturation(limit=0.8, sharpness=sharpness))
    np.testing.assert_allclose(found, sample(PLANT, bent, CAMERA), atol=1e-12)


def test_a_controller_s_command_is_bent_alike():
    law = GradualSaturation(limit=0.8, sharpness=2.4)
    signal = np.array([-5.0, -0.5, 0.0, 0.3, 1e9])
    bent = [law.actuated.at(PERIOD, 0.0, 0.0, u, 0.0, values=law.vector.tolist()) for u in signal]
    np.testing.assert_allclose(bent, law.transform(signal, signal, PERIOD)[0], rtol=1e-12)


@pytest.mark.parametrize("sharpness", [1.0, 2.4, 9.0])
def test_what_a_gradual_dead_zone_takes_is_a_gradual_saturation(sharpness):
    law, signal = GradualDeadZone(half_width=0.3, sharpness=sharpness), command(300)
    lost = signal / (1.0 + np.abs(signal / 0.3) ** sharpness) ** (1.0 / sharpness)
    np.testing.assert_allclose(output(law), sample(PLANT, signal - lost, CAMERA), atol=1e-12)
    alike = [law.actuated.at(PERIOD, 0.0, 0.0, u, 0.0, values=law.vector.tolist()) for u in signal[:40]]
    np.testing.assert_allclose(alike, (signal - lost)[:40], atol=1e-12)
    sharp, corner = (
        law.transform(signal, signal, PERIOD)[0]
        for law in (GradualDeadZone(half_width=0.3, sharpness=20.0), DeadZone(half_width=0.3))
    )
    assert np.max(np.abs(sharp - corner)) < 0.04 * 0.3


@pytest.mark.parametrize(("harmonic", "order"), [("second", 2), ("third", 3)])
def test_a_harmonic_is_a_wave_of_its_own(harmonic, order):
    shape = {"phase": 0.4, "harmonic": harmonic, "harmonic_amplitude": 0.1, "harmonic_phase": 1.1}
    force = PeriodicDisturbanceWithHarmonic(amplitude=0.2, frequency=8.0, **shape)
    waves = (
        PeriodicDisturbance(amplitude=0.2, frequency=8.0, phase=0.4),
        PeriodicDisturbance(amplitude=0.1, frequency=8.0 * order, phase=1.1),
    )
    np.testing.assert_allclose(output(force), output(*waves), atol=1e-7)

    hum = SensorOscillationWithHarmonic(amplitude=0.2, frequency=8.0, **shape)
    waves = (
        SensorOscillation(amplitude=0.2, frequency=8.0, phase=0.4),
        SensorOscillation(amplitude=0.1, frequency=8.0 * order, phase=1.1),
    )
    np.testing.assert_allclose(output(hum), output(*waves), atol=1e-12)

    detent = CoggingWithHarmonic(amplitude=0.2, period=0.5, **shape)
    waves = Cogging(amplitude=0.2, period=0.5, phase=0.4), Cogging(amplitude=0.1, period=0.5 / order, phase=1.1)
    at = [(0.0, y, 0.0, 0.0, 0.0) for y in np.linspace(-1.3, 0.9, 23)]
    forces = [[e.force.at(*point, values=e.force_values(PLANT)) for point in at] for e in (detent, *waves)]
    np.testing.assert_allclose(forces[0], np.add(*forces[1:]), atol=1e-14)

    reading = EncoderEccentricityWithHarmonic(amplitude=0.02, period=0.5, **{**shape, "harmonic_amplitude": 0.01})
    first = EncoderEccentricity(amplitude=0.02, period=0.5, phase=0.4)
    second = EncoderEccentricity(amplitude=0.01, period=0.5 / order, phase=1.1)
    straight = output()
    np.testing.assert_allclose(
        output(reading) - straight, (output(first) - straight) + (output(second) - straight), atol=1e-12
    )


def test_a_reading_that_turns_round_is_none():
    shape = {"period": 1.0, "phase": 0.0, "harmonic": "second", "harmonic_phase": 0.0}
    # Both waves fall steepest at half a turn, where the first does by 2π · 0.1 and the second by the same, or rises.
    falling = EncoderEccentricityWithHarmonic(
        amplitude=0.1, harmonic_amplitude=0.05, **{**shape, "harmonic_phase": np.pi}
    )
    assert not falling.is_plausible(Extent(5.0, 1.0))
    assert EncoderEccentricityWithHarmonic(amplitude=0.1, harmonic_amplitude=0.05, **shape).is_plausible(
        Extent(5.0, 1.0)
    )
    assert not EncoderEccentricityWithHarmonic(amplitude=0.1, harmonic_amplitude=0.05, **shape).is_plausible(
        Extent(1.1, 1.0)
    )
    # A force of two numbers more is a spring of any shape until it has repeated twice and a half.
    cogging = CoggingWithHarmonic(amplitude=0.1, harmonic_amplitude=0.05, **shape)
    assert cogging.is_plausible(Extent(2.6, 1.0))
    assert not cogging.is_plausible(Extent(2.4, 1.0))
    assert Cogging(amplitude=0.1, period=1.0, phase=0.0).is_plausible(Extent(2.4, 1.0))


@pytest.mark.parametrize("rate", [3.0, 20.0, 1e6])
def test_a_servo_approaches_its_command_as_its_equation_says(rate):
    law, signal, fine = RateLimitedLag(rate=rate, time_constant=0.03), command(60), 1e-5
    start, end = law.transform(signal, signal, PERIOD)
    value, means = 0.0, []
    for level in signal:
        path = np.empty(round(PERIOD / fine))
        for i in range(len(path)):
            value += fine * np.clip((level - value) / 0.03, -rate, rate)
            path[i] = value
        means.append(path.mean())
    np.testing.assert_allclose(0.5 * (start + end), means, atol=2e-3)
    reached = [0.0]
    for level in signal:
        reached.append(law.actuated.at(PERIOD, 0.0, 0.0, level, reached[-1], values=law.vector.tolist()))
    assert np.max(np.abs(np.diff(reached))) <= rate * PERIOD * (1.0 + 1e-12)


def test_a_sharp_knee_is_a_corner():
    signal = np.linspace(-2.0, 2.0, 81)
    laws = (GradualSaturation(limit=0.8, sharpness=20.0), Saturation(limit=0.8))
    sharp, corner = (law.transform(signal, signal, PERIOD)[0] for law in laws)
    assert np.max(np.abs(sharp - corner)) < 0.04 * 0.8


def test_a_small_swing_does_not_know_how_it_is_driven():
    along, across = (output(law(amplitude=1000.0)) for law in (PendulumGravity, PendulumDrivenAcross))
    np.testing.assert_allclose(along, across, atol=1e-3)
    along, across = (output(law(amplitude=2.0)) for law in (PendulumGravity, PendulumDrivenAcross))
    assert np.max(np.abs(along - across)) > 0.05


def test_a_lens_of_two_coefficients_bends_the_position():
    straight = output(acquisition=INSTANT)
    bent = output(LensDistortionOfFourthOrder(k1=0.05, k2=-0.02), acquisition=INSTANT)
    np.testing.assert_allclose(bent, straight * (1.0 + 0.05 * straight**2 - 0.02 * straight**4), atol=1e-9)
    plain, none = (output(e) for e in (LensDistortion(k1=0.05), LensDistortionOfFourthOrder(k1=0.05, k2=0.0)))
    np.testing.assert_allclose(plain, none, atol=1e-12)


def test_a_contour_that_counts_for_a_power_of_its_speed():
    mean, own = output(acquisition=CAMERA), output(SpeedWeightedCentroid())
    assert np.max(np.abs(mean - own)) > 1e-3
    np.testing.assert_array_equal(output(GradedSpeedWeightedCentroid(exponent=1.0)), own)
    np.testing.assert_allclose(output(GradedSpeedWeightedCentroid(exponent=0.0)), mean, atol=5e-5)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_hertz_contact_pushes_with_the_power_three_halves(side):
    law = HertzEndStop(position=0.8 * side, hertz=5.0)
    at = side * np.array([-2.0, 0.5, 0.8, 0.9, 1.5])
    forces = [law.force.at(0.0, y, 0.0, 0.0, 0.0, values=law.force_values(PLANT)) for y in at]
    np.testing.assert_allclose(forces, side * 5.0 * np.maximum(side * at - 0.8, 0.0) ** 1.5, atol=1e-14)
    # As stiff, and as hard, at a depth of a fifth of the position where it begins.
    straight, depth = law.simplified(), 0.2 * 0.8
    deep = side * (0.8 + depth)
    pushes = [e.force.at(0.0, deep, 0.0, 0.0, 0.0, values=e.force_values(PLANT)) for e in (law, straight)]
    np.testing.assert_allclose(pushes[1], pushes[0])
    assert straight.values["stiffness"] == pytest.approx(7.5 * np.sqrt(depth))
    assert HertzEndStop.as_stiff_as(EndStop(position=0.8, stiffness=3.0), 0.2).values["position"] < 0.8


def test_a_spring_of_two_terms_is_both_springs():
    both = output(QuadraticStiffness(coefficient=3.0), CubicStiffness(coefficient=2.0))
    for law in (
        QuadraticStiffnessWithCubic(coefficient=3.0, cubic=2.0),
        CubicStiffnessWithQuadratic(coefficient=2.0, quadratic=3.0),
    ):
        np.testing.assert_allclose(output(law), both, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("quadratic", "cubic"), [(3.0, 2.0), (1.0, 8.0)])
def test_a_spring_of_two_terms_has_the_name_of_the_larger_one(quadratic, cubic):
    span, named = 1.0, []
    for law in (
        QuadraticStiffnessWithCubic(coefficient=quadratic, cubic=cubic),
        CubicStiffnessWithQuadratic(coefficient=cubic, quadratic=quadratic),
    ):
        named += [law.identifier] if law.is_plausible(Extent(span, 1.0)) else []
    assert named == ["cubic-stiffness" if quadratic < cubic * TYPICAL_DISPLACEMENT * span else "quadratic-stiffness"]


def test_a_spring_with_a_fifth_power_is_that_of_its_parts():
    law = CubicStiffnessWithFifthPower(coefficient=2.0, fifth=-0.5)
    at = np.array([-1.5, 0.0, 0.4, 2.0])
    found = [law.force.at(0.0, y, 0.0, 0.0, 0.0, values=law.force_values(PLANT)) for y in at]
    np.testing.assert_allclose(found, 2.0 * at**3 - 0.5 * at**5)
    assert law.simplified().values == {"coefficient": 2.0}
    assert law.is_plausible(Extent(4.0, 1.0))
    # What turns round within the way is a term of some other law's series, unless next to nothing does.
    assert not law.is_plausible(Extent(10.0, 1.0))
    assert law.is_plausible(Extent(20.0, 1.0))
    assert CubicStiffnessWithFifthPower(coefficient=2.0, fifth=50.0).is_plausible(Extent(10.0, 1.0))
    beside = CubicStiffnessWithQuadratic(coefficient=2.0, quadratic=0.1).finer(
        SimpleNamespace(largest=lambda name: 1.0)
    )
    assert [type(each) for each in beside] == [CubicStiffnessWithFifthPower] * 2


def test_an_encoder_errs_once_in_each_of_many_turns():
    plant = TransferFunction((50.0,), (1.0, 10.0, 0.0))
    signal = np.repeat(np.random.default_rng(4).normal(size=30) + 1.0, 50)
    times, encoder = PERIOD * np.arange(1500), Acquisition(PERIOD, sensor="instant")
    eccentric = EncoderEccentricity(amplitude=0.01, period=3.0, phase=1.1)
    reading = run(Chain(plant, encoder, (eccentric,)), signal, times)
    assert np.ptp(reading) / 3.0 > 40.0
    table = pd.DataFrame({"t": times, "u": signal, "y": reading + 5e-4 * np.random.default_rng(5).normal(size=1500)})
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [45.0], "denominator": [1.0, 11.0, 0.0]}},
        "sensor": {"column": "y", "kind": "instant", "offset": 0.0},
    }
    (found,) = camid.diagnose(table, nominal).findings
    assert found.identifier == "encoder-eccentricity"
    for name, value in eccentric.values.items():
        assert found.parameters[name].value == pytest.approx(value, rel=0.05)


@pytest.mark.parametrize("rate", [1e-3, 1.0, 1e12])
def test_a_servo_is_started_from_any_limit(rate):
    starts = list(RateLimitedLag.starts(SimpleNamespace(signal=command(60)), rate=rate))
    assert len(starts) == 2
    assert all(start.values["rate"] == rate for start in starts)


@pytest.mark.slow
def test_a_law_that_leads_to_no_other_ends_no_diagnosis(monkeypatch):
    """A fit may run away to values from which a finer law cannot be made."""

    def failing(self, situation):
        raise ValueError("out of bounds")

    monkeypatch.setattr(CubicStiffness, "finer", failing)
    recording = record(CubicStiffness(coefficient=0.3), noise=0.001, count=1200)
    assert [f.identifier for f in camid.diagnose(recording, simulation()).findings] == ["cubic-stiffness"]


LAWS = [
    ("quadratic-stiffness", QuadraticStiffnessWithCubic(coefficient=0.35, cubic=0.1), "cubic"),
    ("cubic-stiffness", CubicStiffnessWithQuadratic(coefficient=0.5, quadratic=0.12), "quadratic"),
    ("cubic-stiffness", CubicStiffnessWithFifthPower(coefficient=0.3, fifth=0.15), "fifth"),
    ("end-stop", HertzEndStop(position=1.0, hertz=6.0), "hertz"),
    ("dead-zone", GradualDeadZone(half_width=0.6, sharpness=2.5), "sharpness"),
    (
        "periodic-disturbance",
        PeriodicDisturbanceWithHarmonic(
            amplitude=0.2, frequency=8.0, phase=0.4, harmonic="third", harmonic_amplitude=0.05, harmonic_phase=-1.0
        ),
        "harmonic",
    ),
    ("saturation", GradualSaturation(limit=1.0, sharpness=2.5), "sharpness"),
    ("pendulum-gravity", PendulumDrivenAcross(amplitude=3.0), "drive"),
    ("pendulum-gravity", PendulumAtAnAngle(amplitude=4.0, rest=1.2), "rest"),
    (
        "cogging",
        CoggingWithHarmonic(
            amplitude=0.06, period=0.8, phase=0.4, harmonic="second", harmonic_amplitude=0.02, harmonic_phase=-1.0
        ),
        "harmonic",
    ),
    (
        "encoder-eccentricity",
        EncoderEccentricityWithHarmonic(
            amplitude=0.05, period=0.8, phase=0.4, harmonic="second", harmonic_amplitude=0.02, harmonic_phase=-1.0
        ),
        "harmonic",
    ),
    ("lens-distortion", LensDistortionOfFourthOrder(k1=-0.15, k2=0.05), "k2"),
    ("rate-limit", RateLimitedLag(rate=12.0, time_constant=0.04), "time_constant"),
    ("parameter-drift", SettlingDrift(coefficient="gain", rate=0.05, time_constant=4.0), "time_constant"),
    ("speed-weighted-centroid", GradedSpeedWeightedCentroid(exponent=0.45), "exponent"),
]


# A whole diagnosis of these takes longer than five seconds.
LONG = {"cubic-stiffness", "end-stop", "lens-distortion"}


@pytest.mark.parametrize(
    ("identifier", "law", "key"),
    [
        pytest.param(*case, marks=[pytest.mark.slow] if case[0] in LONG else [], id=f"{case[0]}, {case[2]}")
        for case in LAWS
    ],
)
@pytest.mark.slow
def test_the_law_is_found_and_the_improved_simulation_declares_it(identifier, law, key):
    recording = record(law, noise=0.001, count=1200)
    found = camid.diagnose(recording, simulation())
    assert [f.identifier for f in found.findings] == [identifier]
    (declared,) = found.improved.effects
    assert key in declared.parameters
    again = camid.diagnose(record(law, noise=0.001, count=1200, seed=2), found.improved.to_mapping())
    assert again.verdict == "adequate"


def test_a_zero_that_settles_is_one_that_drifts_at_first():
    settling = SettlingSensorDrift(rate=0.01, time_constant=2.0)
    seen = settling.observe(np.zeros(3), np.array([0.0, 0.02, 1e4]))
    np.testing.assert_allclose(seen, [0.0, 0.01 * 0.02, 0.01 * 2.0], rtol=6e-3)
    assert settling.simplified().values == {"rate": 0.01}


def test_a_zero_that_settles_is_found():
    table = record(SettlingSensorDrift(rate=0.05, time_constant=4.0), count=1200)
    (found,) = camid.diagnose(table, simulation()).findings
    assert found.identifier == "sensor-drift"
    for name, truth in (("rate", 0.05), ("time_constant", 4.0)):
        estimate = found.parameters[name]
        assert abs(estimate.value - truth) < 3.0 * estimate.standard_deviation < 0.2 * truth


def test_less_than_a_period_and_a_half_is_no_periodic_disturbance():
    disturbance = PeriodicDisturbance(amplitude=1.0, frequency=1.0, phase=0.0)
    assert disturbance.is_plausible(Extent(1.0, 9.5))
    assert not disturbance.is_plausible(Extent(1.0, 9.4))


def test_a_mode_that_its_spring_damps_passes_on_the_speed_of_what_is_driven():
    """A load m on a spring k with a damper c beside it: m ẍ = k (y − x) + c (ẏ − ẋ)."""
    mass, stiffness, damping = 0.3, 400.0, 2.0
    rate, share = np.sqrt(stiffness / mass), 0.5 * damping / np.sqrt(stiffness * mass)
    law = ModeDampedBetween(natural_frequency=rate, damping=share, lead=damping / stiffness)
    (series,) = PLANT.numerator
    first, second = PLANT.denominator, np.array([mass, damping, stiffness])
    whole = TransferFunction(tuple(series * np.array([damping, stiffness])), tuple(np.polymul(first, second)))
    np.testing.assert_allclose(output(law), sample(whole, command(300), CAMERA), atol=1e-9)
    plain = ExtraMode(natural_frequency=rate, damping=share)
    np.testing.assert_allclose(output(law.with_vector(np.array([rate, share, 0.0]))), output(plain), atol=1e-9)
    assert next(ModeDampedBetween.starts(None, **plain.values)).values["lead"] == pytest.approx(damping / stiffness)
    np.testing.assert_allclose(law.simplified().vector, plain.vector)


@pytest.mark.parametrize("gain", [1.0, -1.0])
def test_friction_that_is_uneven_and_turns_round_gradually(gain):
    plant = TransferFunction(tuple(gain * np.array(PLANT.numerator)), PLANT.denominator)
    law = GradualAsymmetricFriction(forward=0.5, backward=0.3, transition=0.4)
    values = law.force_values(plant)
    for speed, level in ((2.0, 0.5), (-2.0, 0.3), (0.1, 0.5), (-0.1, 0.3), (0.0, 0.0)):
        force = law.force.at(0.0, 0.0, speed, 0.0, 0.0, values=values)
        assert gain * force == pytest.approx(level * np.tanh(speed / 0.4))
    even = GradualAsymmetricFriction(forward=0.4, backward=0.4, transition=0.4)
    np.testing.assert_allclose(output(even), output(even.simplified()), atol=1e-12)
    assert even.simplified().values == {"force": 0.4, "transition": 0.4}


@pytest.mark.parametrize("gain", [1.0, -1.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stop_that_takes_energy_pushes_harder_against_what_comes(gain, side):
    plant = TransferFunction(tuple(gain * np.array(PLANT.numerator)), PLANT.denominator)
    law = DampedEndStop(position=0.5 * side, stiffness=4.0, loss=0.5)
    values = law.force_values(plant)
    for depth, rate, force in ((0.2, 0.0, 0.8), (0.2, 1.0, 1.2), (0.2, -1.0, 0.4), (0.2, -3.0, 0.0), (-0.1, 1.0, 0.0)):
        found = law.force.at(0.0, side * (0.5 + depth), side * rate, 0.0, 0.0, values=values)
        assert gain * side * found == pytest.approx(force)
    without = law.with_vector(np.array([0.5 * side, 4.0, 0.0]))
    np.testing.assert_allclose(output(without), output(law.simplified()), atol=1e-9)
    assert np.std(output(law) - output(without)) > 1e-3
