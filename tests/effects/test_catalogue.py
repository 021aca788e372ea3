"""The catalogue: complete, printable, searchable from any recording, and calibrated where it recognises noise."""

from dataclasses import replace

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.effects import PLACES, Situation, known_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run

PERIOD = 0.02
PLANT = second_order(1.0, 10.0, 0.1)
FIRST_ORDER = TransferFunction((2.0,), (0.1, 1.0))

# Design, section 2, and what real rigs showed missing (issue 12).
DESIGN = """
actuator dead-zone half_width; saturation limit; backlash half_width; rate-limit rate; actuator-lag time_constant;
 gain-asymmetry ratio; input-hold hold; input-bias bias; input-quantisation step
plant coulomb-friction force; stribeck-friction coulomb breakaway velocity; quadratic-drag coefficient;
 cubic-stiffness coefficient; quadratic-stiffness coefficient; pendulum-gravity amplitude; end-stop position stiffness;
 hysteresis strength shape; extra-mode natural_frequency damping; parameter-drift coefficient rate;
 asymmetric-friction forward backward; position-dependent-friction force gradient;
 load-dependent-friction force coefficient; amplitude-dependent-damping coefficient;
 cogging amplitude period phase; parallel-mode gain natural_frequency damping;
 square-root-outflow coefficient below; overflow height share below
disturbance periodic-disturbance amplitude frequency phase; step-disturbance size time; impulse-disturbance size time
sensor exposure exposure; delay delay; rolling-shutter time_per_unit; clock-skew skew; timestamp-jitter std;
 lens-distortion k1; clipping low high; quantisation step; sensor-offset offset; sensor-drift rate;
 dropped-frames fraction; outliers fraction; absolute-value; speed-weighted-centroid;
 encoder-eccentricity amplitude period phase; late-command lead; input-pickup coefficient
noise coloured-noise spectrum; multiplicative-noise share
"""


def promised():
    place, joined = None, []
    for line in DESIGN.strip().splitlines():
        if line.startswith(" "):
            joined[-1][1] += line
        else:
            place, _, rest = line.partition(" ")
            joined.append([place, rest])
    for place, rest in joined:
        for entry in filter(None, (part.split() for part in rest.split(";"))):
            yield entry[0], place, tuple(entry[1:])


@pytest.mark.parametrize(
    ("identifier", "place", "parameters"), list(promised()), ids=lambda x: x if isinstance(x, str) else ""
)
def test_the_design_is_kept(identifier, place, parameters):
    effect = known_effects()[identifier]
    assert effect.place == place
    assert tuple(p.name for p in effect.parameters if not p.is_name) == parameters


EFFECTS = sorted(known_effects().items())
SHOWN = [(name, effect) for name, effect in EFFECTS if not effect.noise_like]
NOISE = [(name, effect) for name, effect in EFFECTS if effect.noise_like]
names = pytest.mark.parametrize("identifier", [name for name, _ in EFFECTS])
shown = pytest.mark.parametrize("identifier", [name for name, _ in SHOWN])


@names
def test_every_effect_can_be_printed(identifier):
    from matplotlib.mathtext import MathTextParser

    effect = known_effects()[identifier]
    assert effect.place in PLACES
    assert effect.title
    assert len(effect.reference) > 10
    assert effect.__doc__
    parser = MathTextParser("path")
    parser.parse(f"${effect.equation}$")
    with pytest.raises(ValueError, match=r"Unknown symbol|Expected"):
        parser.parse(f"${effect.equation}\\nosuchsymbol$")
    for parameter in effect.parameters:
        assert parameter.meaning
        assert parameter.lower < parameter.upper
        assert set(parameter.unit.replace("rad", "").replace("^", "").replace("/", "")) <= set("uys .1234567890")


def situation(signal=None, plant=PLANT, acquisition=None, count=400, scale=1.0, input_scale=1.0, noise=0.02, seed=0):
    """A recording of the plant alone, in units of which ``scale`` make one of y, and what is known of it."""
    generator = np.random.default_rng(seed)
    if signal is None:
        signal = np.repeat(generator.choice([-1.0, -0.5, 0.3, 1.0], count // 4 + 1), 4)[:count]
    signal = np.asarray(signal, float) * input_scale
    acquisition = acquisition or Acquisition(PERIOD)
    plant = TransferFunction(tuple(b * scale / input_scale for b in plant.numerator), plant.denominator)
    simulated = sample(plant, signal, acquisition)
    residual = noise * scale * generator.standard_normal(len(signal))
    time = 3.0 + acquisition.period * np.arange(len(signal))
    velocity = np.gradient(simulated, acquisition.period) if len(signal) > 1 else np.zeros(len(signal))
    return Situation(
        time,
        signal,
        simulated + residual,
        simulated,
        velocity,
        residual,
        plant,
        acquisition,
        np.ones(len(signal), bool),
    )


SITUATIONS = {
    "usual": {},
    "zero input": {"signal": np.zeros(200)},
    "constant input": {"signal": np.ones(200)},
    "two levels": {"signal": np.repeat(np.random.default_rng(1).choice([-1.0, 1.0], 50), 4)},
    "one-sided input": {"signal": np.abs(np.sin(np.arange(200)))},
    "tiny units": {"scale": 1e-6, "input_scale": 1e-6},
    "huge units": {"scale": 1e6, "input_scale": 1e6},
    "tiny output, huge input": {"scale": 1e-6, "input_scale": 1e6},
    "instant sensor": {"acquisition": Acquisition(PERIOD, sensor="instant")},
    "joined input, short late exposure": {"acquisition": Acquisition(PERIOD, "foh", "camera", 0.004, 0.031)},
    "short record": {"count": 12},
    "no noise": {"noise": 0.0},
    "integrating plant": {"plant": TransferFunction((5.0,), (1.0, 2.0, 0.0))},
    "first-order plant": {"plant": FIRST_ORDER},
    "two storages": {"plant": TransferFunction((2.0,), (0.1, 1.0)) * TransferFunction((1.0,), (0.4, 1.0))},
    "plant with a zero": {"plant": TransferFunction((3.0, 100.0), (1.0, 4.0, 100.0))},
    "negative gain": {"plant": TransferFunction((-100.0,), (1.0, 2.0, 100.0))},
    "third order": {"plant": TransferFunction((1.0, 3.0), (1.0, 2.0, 5.0, 7.0))},
}


@pytest.mark.parametrize("kind", SITUATIONS)
@shown
def test_first_guesses_are_valid_and_run(identifier, kind):
    given = situation(**SITUATIONS[kind])
    effect = known_effects()[identifier]
    reason = effect.invisible(given)
    assert reason is None or len(reason) > 20
    for k, guess in enumerate(effect.candidates(given)):
        assert np.all(np.isfinite(guess.vector))
        if k < 3:
            found = run(Chain(given.plant, given.acquisition, (guess,)), given.signal, given.time)
            assert found.shape == given.signal.shape
            # A force that pushes a body away which nothing holds drives it off, as it should.
            assert np.all(np.isfinite(found)) or (kind, effect.parameters[0].unit[:4]) == ("integrating plant", "u/y^")
    if kind == "usual" and reason is None:
        assert any(True for _ in effect.candidates(given))


@names
def test_vectors_are_kept_within_bounds(identifier):
    effect = known_effects()[identifier]
    guesses = [] if effect.noise_like else list(effect.candidates(situation()))[:3]
    for guess in guesses:
        for value in (-1e12, 0.0, 1e12):
            moved = guess.with_vector(np.full(len(guess.vector), value))
            for parameter, number in zip(moved.numeric(), moved.vector, strict=True):
                assert parameter.lower <= number <= parameter.upper
        assert np.array_equal(guess.with_vector(guess.vector).vector, guess.vector)
        assert {k: v for k, v in guess.with_vector(guess.vector).values.items() if isinstance(v, str)} == {
            k: v for k, v in guess.values.items() if isinstance(v, str)
        }
    if effect.parameters:
        with pytest.raises(ValueError, match="needs the parameter"):
            effect()
    with pytest.raises(ValueError, match="no parameter"):
        effect(nonsense=1.0)


@shown
def test_every_law_has_its_finer_ones(identifier):
    """What a search tries where a law leaves structure, from each law that it may have fitted."""
    given = situation()
    laws = list(known_effects()[identifier].candidates(given))
    for _ in range(2):
        laws = [finer for law in laws for finer in law.finer(given)]
        assert all(np.all(np.isfinite(law.vector)) for law in laws)


# These exist or do not: nothing of them is small.
ALL_OR_NOTHING = {"input-hold", "absolute-value", "speed-weighted-centroid"}


# An effect of another size may be another pattern, and is in proportion on average alone: its own test says so.
IN_PROPORTION = [name for name, effect in SHOWN if name not in ALL_OR_NOTHING and not effect.size_is_shape]


@pytest.mark.parametrize("identifier", IN_PROPORTION)
def test_scaled_effects_change_the_output_in_proportion(identifier):
    """A hundredth of an effect is at most a tenth of its change, and within a factor of four of a hundredth at best."""
    given = situation()
    if known_effects()[identifier].invisible(given) is not None:
        given = situation(plant=FIRST_ORDER, acquisition=Acquisition(PERIOD, sensor="instant"))
    before = run(Chain(given.plant, given.acquisition), given.signal, given.time)

    def change(effect):
        return np.linalg.norm(run(Chain(given.plant, given.acquisition, (effect,)), given.signal, given.time) - before)

    best = np.inf
    for guess in known_effects()[identifier].candidates(given):
        whole = change(guess)
        half, little, least = (change(guess.scaled(f)) for f in (0.5, 0.01, 1e-6))
        if not 1e-9 < whole < 0.5 * np.linalg.norm(before):
            continue  # what replaces the motion by another is beyond proportion
        assert least < 1e-3 * whole
        assert little < 0.1 * whole
        assert little < 1.2 * half
        best = min(best, abs(np.log(little / whole / 0.01))) if little > 0.0 else best
    assert best < np.log(4.0)


def test_an_asymmetric_gain_is_found_on_both_sides():
    guess = next(known_effects()["gain-asymmetry"].candidates(situation()))
    assert not guess.one_sided
    assert guess.scaled(-2.0).values["ratio"] == pytest.approx(1.1)
    assert guess.scaled(2.0).values["ratio"] == pytest.approx(0.9)


# -- noise -----------------------------------------------------------------------------------------------------------


def spoil(given, identifier, generator):
    """The same recording with an effect that changes the noise."""
    residual, recorded = given.residual.copy(), given.recorded.copy()
    spread = np.std(residual)
    if identifier == "outliers":
        where = generator.choice(len(residual), 8, replace=False)
        residual[where] += 12.0 * spread * generator.choice([-1.0, 1.0], 8)
    elif identifier == "timestamp-jitter":
        residual += given.velocity * 0.004 * generator.standard_normal(len(residual))
    elif identifier == "multiplicative-noise":
        residual += given.position * 0.08 * generator.standard_normal(len(residual))
    elif identifier == "quantisation":
        step = 4.0 * spread
        recorded = step * np.round(recorded / step)
        return replace(given, residual=recorded - given.position, recorded=recorded)
    elif identifier == "dropped-frames":
        for k in generator.choice(np.arange(1, len(residual)), 12, replace=False):
            residual[k] += recorded[k - 1] - recorded[k]
            recorded[k] = recorded[k - 1]
        return replace(given, residual=residual, recorded=recorded)
    return replace(given, residual=residual, recorded=given.position + residual)


INSTANT = Acquisition(PERIOD, sensor="instant")
RECOGNISED = [name for name, _ in NOISE if name != "coloured-noise"]


@pytest.mark.parametrize("identifier", RECOGNISED)
def test_white_gaussian_noise_is_nothing_else(identifier):
    effect = known_effects()[identifier]
    alarms = 0
    for seed in range(300):
        found = effect.recognise(situation(seed=seed, acquisition=INSTANT))
        alarms += found is not None and found.p_value < 1e-4
    assert alarms == 0


@pytest.mark.parametrize("identifier", RECOGNISED)
def test_noise_is_recognised_for_what_it_is(identifier):
    hits = dict.fromkeys(RECOGNISED, 0)
    for seed in range(20):
        generator = np.random.default_rng(np.random.SeedSequence([seed, 1]))
        given = spoil(situation(seed=seed, count=1000, acquisition=INSTANT), identifier, generator)
        for other in RECOGNISED:
            found = known_effects()[other].recognise(given)
            if found is not None and found.named and found.p_value < 1e-4:
                hits[other] += 1
                assert found.spoiled.shape == given.time.shape
                assert set(found.standard_deviations) == {p.name for p in found.effect.numeric()}
    assert hits.pop(identifier) == 20
    assert max(hits.values()) <= 1, hits


@pytest.mark.parametrize("seed", range(5))
def test_significant_digits_repeat_by_chance_where_numbers_are_large(seed):
    """As a program prints that keeps five of them: 12.345 and 1.2345."""
    time = 0.01 * np.arange(2500)
    random = np.random.default_rng([5, seed])
    values = 12.0 * np.sin(2.0 * time) + 0.06 * random.standard_normal(2500)
    printed = np.array([float(f"{v:.5g}") for v in values])
    dropped = known_effects()["dropped-frames"]
    given = situation(count=2500)
    given = replace(given, recorded=printed, residual=printed - 12.0 * np.sin(2.0 * time), time=time)
    found = dropped.recognise(given)
    assert found is None or found.p_value > 1e-3
    lost = np.arange(20, 2480, 20)
    printed[lost] = printed[lost - 1]
    assert dropped.recognise(replace(given, recorded=printed)).p_value < 1e-6


def test_noise_parameters_are_right():
    generator = np.random.default_rng(5)
    given = situation(count=2000, seed=4, acquisition=INSTANT)
    found = {i: known_effects()[i].recognise(spoil(given, i, generator)) for i in RECOGNISED}
    assert found["outliers"].effect.values["fraction"] == pytest.approx(8 / 2000)
    assert found["dropped-frames"].effect.values["fraction"] == pytest.approx(12 / 2000, rel=0.2)
    assert found["quantisation"].effect.values["step"] == pytest.approx(4.0 * np.std(given.residual))
    jitter = found["timestamp-jitter"]
    assert abs(jitter.effect.values["std"] - 0.004) < 4.0 * jitter.standard_deviations["std"]
    filmed = replace(given, acquisition=Acquisition(PERIOD))
    assert known_effects()["multiplicative-noise"].recognise(spoil(filmed, "multiplicative-noise", generator)) is None
    proportional = found["multiplicative-noise"]
    assert abs(proportional.effect.values["share"] - 0.08) < 4.0 * proportional.standard_deviations["share"]


@pytest.mark.parametrize(("far", "stands_out"), [((60.0,), True), ((60.0, 45.0, 31.0, 22.0, 16.0, 11.0), False)])
def test_a_frame_far_from_those_around_it_stands_out_beside_structure(far, stands_out):
    """Misfits last, or come in all sizes; a few frames beyond everything else are neither."""
    given = situation(count=2000)
    structure = 3.0 * np.std(given.residual) * np.sin(0.05 * np.arange(2000))
    residual = given.residual + structure
    residual[100 : 100 + 150 * len(far) : 150] += np.std(given.residual) * np.array(far)
    found = known_effects()["outliers"].recognise(replace(given, residual=residual))
    assert found.stands_out == stands_out


def test_clipped_values_are_no_outliers():
    """A weak clipping leaves few, isolated and large residuals, all read at the edge and expected beyond it."""
    generator = np.random.default_rng(np.random.SeedSequence(8))
    position = np.sin(np.arange(600) * 1.1) + 0.02 * generator.standard_normal(600)
    recorded = np.minimum(position, 0.985) + 0.001 * generator.standard_normal(600)
    clipped = replace(
        situation(),
        time=0.02 * np.arange(600),
        signal=np.ones(600),
        recorded=recorded,
        position=position,
        velocity=np.gradient(position, 0.02),
        residual=recorded - position,
        used=np.ones(600, bool),
    )
    assert known_effects()["outliers"].recognise(clipped) is None
    rows = np.arange(5, 600, 60)
    struck = recorded.copy()
    struck[rows] += 0.5 * np.where(np.arange(len(rows)) % 2, 1.0, -1.0)
    struck = np.where(np.isin(np.arange(600), rows), struck, position + 0.001 * generator.standard_normal(600))
    found = known_effects()["outliers"].recognise(replace(clipped, recorded=struck, residual=struck - position))
    assert found is not None
    assert set(rows) <= set(np.flatnonzero(found.spoiled))


def test_noise_that_grows_with_the_reading_has_no_outliers():
    """Noise nearly in proportion to the position has long tails as a whole, and none beside its own size."""
    named = struck = 0
    for seed in range(20):
        generator = np.random.default_rng(np.random.SeedSequence([seed, 9]))
        given = situation(seed=seed, count=2000)
        size = np.hypot(0.05 * given.position, 0.01 * np.std(given.position))  # and a sensor's own noise
        residual = size * generator.standard_normal(len(size))
        grown = replace(given, residual=residual, recorded=given.position + residual)
        found = known_effects()["outliers"].recognise(grown)
        named += found is not None and found.p_value < 1e-4
        # And what stands out of such noise is found in it.
        far = np.zeros(len(residual))
        far[generator.choice(len(residual), 8, replace=False)] = 12.0 * np.std(residual)
        found = known_effects()["outliers"].recognise(
            replace(given, residual=residual + far, recorded=given.position + residual + far)
        )
        struck += found is not None and found.named and found.p_value < 1e-4
    assert (named, struck) == (0, 20)


def test_a_force_that_repeats_with_the_step_of_a_coarse_sensor_is_its_rounding():
    given = situation(seed=3)
    step = float(np.ptp(given.position)) / 10.0
    # As plant and camera hand on a force that repeats every step: what the first guess is made of.
    joined = replace(given.acquisition, hold="foh")
    residual = sample(given.plant, np.sin(2.0 * np.pi * given.position / step), joined)
    fine = replace(given, recorded=given.position + residual, residual=residual)
    coarse = replace(fine, recorded=step * np.round(given.position / step))
    periods, finer = ([e.values["period"] for e in known_effects()["cogging"].candidates(s)] for s in (coarse, fine))
    assert min(finer) < 1.3 * step
    assert all(period > 2.0 * step for period in periods)


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_a_command_that_may_answer_the_noise_of_the_reading_is_not_picked_up_by_it(noise):
    """A controller puts a share of that noise into its command: the same relation, the other way round."""
    given = replace(situation(), acquisition=Acquisition(PERIOD, sensor="instant"))
    random = np.random.default_rng(3).standard_normal(len(given.signal))
    given = replace(given, signal=given.signal + noise * np.std(given.signal) * random)
    assert (known_effects()["input-pickup"].invisible(given) is None) == (noise == 0.0)
