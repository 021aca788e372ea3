"""Coarse steps of the command: what they do, how they are guessed and found, and what hides them."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete, lfilter

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.input_quantisation import InputQuantisation
from camid.effects.residual_regression import ResidualRegression, sampled
from camid.effects.situation import Situation
from camid.engine.mechanics import Chain
from camid.engine.run import run
from tests.diagnosis.test_noise_of_uneven_rows import fitted_to
from tests.support.mass_on_spring import effect, record

PERIOD, ROWS = 0.02, 1500
NUMERATOR, DENOMINATOR = [92.0], [1.0, 2.4, 110.0]
BELIEVED = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [100.0], "denominator": [1.0, 2.0, 100.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def command(seed, held=6, levels=None):
    """Levels anywhere within ± 2, or some of them, each held for a while."""
    random = np.random.default_rng([55, seed])
    count = ROWS // held
    drawn = random.uniform(-2.0, 2.0, count) if levels is None else random.choice(levels, count)
    return np.repeat(drawn, held)


def moved(force):
    """Positions of a mass on a spring under forces that are held, by another program."""
    numerator, denominator, _ = cont2discrete((NUMERATOR, DENOMINATOR), PERIOD, method="zoh")
    return lfilter(numerator.ravel(), denominator, force)


def recording(seed, step, **options):
    """With commands rounded to steps, and noise of half a per cent."""
    signal = command(seed, **options)
    output = moved(step * np.round(signal / step))
    noise = 0.005 * np.std(output) * np.random.default_rng([56, seed]).standard_normal(ROWS)
    return pd.DataFrame({"t": PERIOD * np.arange(ROWS), "u": signal, "y": output + noise})


def test_the_command_is_rounded():
    signal = command(0)
    chain = Chain(
        TransferFunction(tuple(NUMERATOR), tuple(DENOMINATOR)),
        Acquisition(PERIOD, sensor="instant"),
        (InputQuantisation(step=0.3),),
    )
    found = run(chain, signal, PERIOD * np.arange(ROWS))
    expected = moved(0.3 * np.round(signal / 0.3))
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.std(expected))


def test_smaller_steps_do_less_in_proportion():
    signal = command(0, held=1)
    errors = []
    for factor in (1.0, 0.1, 0.01):
        rounded, _ = InputQuantisation(step=0.4).scaled(factor).transform(signal, signal, PERIOD)
        errors.append(np.std(rounded - signal) / factor)
    np.testing.assert_allclose(errors, 0.4 / np.sqrt(12.0), rtol=0.05)


@pytest.mark.parametrize(("seed", "step"), [(1, 0.25), (2, 0.6), pytest.param(3, 1.7, marks=pytest.mark.slow)])
def test_steps_of_a_command_are_found(seed, step):
    diagnosis = camid.diagnose(recording(seed, step), BELIEVED)
    (found,) = diagnosis.findings
    assert (found.identifier, diagnosis.verdict) == ("input-quantisation", "explained")
    # Between two jumps the step and the plant's gain make up for each other, and both are no surer than that.
    estimate, gain = found.parameters["step"], diagnosis.coefficients[0]
    assert abs(estimate.value - step) < 4.0 * estimate.standard_deviation < 0.05 * step
    assert abs(gain.improved - NUMERATOR[0]) < 4.0 * gain.improved_deviation < 0.05 * NUMERATOR[0]


NOISE = 1e-3
AXIS = ([92.0], [1.0, 2.4, 0.0])


def axis(seed, step):
    """What drives an axis is a command in a hundred steps that a controller's noise roughens; the errors add up."""
    random = np.random.default_rng([57, seed])
    time = PERIOD * np.arange(ROWS)
    tones = zip(random.uniform(0.4, 3.0, 6), random.uniform(0.0, 2.0 * np.pi, 6), strict=True)
    signal = np.sum([np.sin(2.0 * np.pi * tone * time + phase) for tone, phase in tones], axis=0)
    signal += 0.1 * random.standard_normal(ROWS)
    numerator, denominator, _ = cont2discrete(AXIS, PERIOD, method="zoh")
    output = lfilter(numerator.ravel(), denominator, step * np.round(signal / step))
    noise = NOISE * np.std(output) * random.standard_normal(ROWS)
    return pd.DataFrame({"t": time, "u": signal, "y": output + noise})


@pytest.mark.parametrize(("seed", "share"), [pytest.param(1, 60, marks=pytest.mark.slow), (3, 80)])
def test_small_steps_are_found_where_what_they_do_adds_up(seed, share):
    step = 4.0 / share
    plant = {"transfer_function": {"numerator": [120.0], "denominator": [1.0, 1.8, 0.0]}}
    diagnosis = camid.diagnose(axis(seed, step), {**BELIEVED, "plant": plant})
    (found,) = diagnosis.findings
    assert (found.identifier, diagnosis.verdict) == ("input-quantisation", "explained")
    estimate = found.parameters["step"]
    assert abs(estimate.value - step) < 4.0 * estimate.standard_deviation < 0.01 * step


def slow_lag(seed, share):
    """A lag of many frames under few levels, as a staircase has them, each of them in steps that many others mimic."""
    random = np.random.default_rng([58, seed])
    step, ladder = 4.0 / share, random.uniform(0.1, 0.2) + 0.37 * np.arange(-11, 11)
    signal = np.repeat(random.choice(ladder, ROWS // 10), 10)
    numerator, denominator, _ = cont2discrete(([0.3], [1.0, 1.6]), PERIOD, method="zoh")
    output = lfilter(numerator.ravel(), denominator, step * np.round(signal / step))
    noise = 0.3 * NOISE * np.std(output) * random.standard_normal(ROWS)
    return step, pd.DataFrame({"t": PERIOD * np.arange(ROWS), "u": signal, "y": output + noise})


@pytest.mark.parametrize(("seed", "share"), [pytest.param(1, 47, marks=pytest.mark.slow), (2, 83)])
def test_small_steps_are_found_by_what_they_do_in_their_own_size(seed, share):
    """Steps of other sizes do the same in another size, which is not theirs."""
    step, recorded = slow_lag(seed, share)
    plant = {"transfer_function": {"numerator": [0.28], "denominator": [1.0, 1.7]}}
    diagnosis = camid.diagnose(recorded, {**BELIEVED, "plant": plant})
    (found,) = diagnosis.findings
    assert (found.identifier, diagnosis.verdict) == ("input-quantisation", "explained")
    estimate = found.parameters["step"]
    assert abs(estimate.value - step) < 4.0 * estimate.standard_deviation < 0.05 * step


def test_a_product_with_a_response_is_one_with_the_signal():
    """What answers the residual in reversed time is the adjoint of the plant, its sampling included."""
    recorded = axis(3, 0.05)
    plant, acquisition = TransferFunction(*map(tuple, AXIS)), Acquisition(PERIOD, exposure=0.7 * PERIOD)
    random = np.random.default_rng(5)
    rows = [recorded[name].to_numpy() for name in ("t", "u", "y", "y")]
    used = np.arange(ROWS) % 3 > 0
    residual = random.standard_normal(ROWS) * used
    situation = Situation(*rows, np.gradient(rows[2], PERIOD), residual, plant, acquisition, used)
    regression = ResidualRegression(situation, lambda signals: sampled(plant, signals, acquisition))
    signals = random.standard_normal((ROWS, 4))
    left, _ = regression.left(signals)
    np.testing.assert_allclose(regression.reversed_answer @ signals, regression.residual @ left, rtol=1e-8)


def test_an_input_of_two_sizes_does_not_show_them():
    diagnosis = camid.diagnose(recording(4, 0.7, levels=[-1.4, -0.6, 0.6, 1.4]), BELIEVED)
    (hidden,) = [u for u in diagnosis.undetectable if u.identifier == "input-quantisation"]
    assert "two absolute values at most" in hidden.reason


def test_steps_that_round_alike_are_no_surer_than_they_are_apart():
    """Of three sizes of the command all steps from 0.68 to 1.13 make the same, and the gain makes up for the rest."""
    signal = command(6, levels=[-1.7, -1.0, -0.3, 0.3, 1.0, 1.7])
    coarse = effect("input-quantisation", step=0.9)
    _, fitted = fitted_to(record(coarse, signal=signal, count=ROWS), coarse)
    place = fitted.packing.names.index("0 step")
    gain = fitted.packing.names.index("coefficient 0")
    step, numerator = (float(np.sqrt(fitted.covariance[i, i])) for i in (place, gain))
    assert 0.08 < step / 0.9 < 0.4
    assert 0.08 < numerator / fitted.model.coefficients[0] < 0.4


@pytest.mark.parametrize("sizes", [[0.45, 0.9, 1.35], [-0.45, -0.9, -1.35]])
def test_halves_are_rounded_away_from_zero(sizes):
    signal = np.array(sizes)
    rounded, _ = InputQuantisation(step=0.9).transform(signal, signal, PERIOD)
    np.testing.assert_allclose(rounded, np.sign(signal) * [0.9, 0.9, 1.8])


def test_a_dead_zone_may_be_the_first_of_few_steps():
    """As of a three-position valve; a dead zone that is fitted to it is narrower than half a step."""
    few, many = SimpleNamespace(largest=lambda _: 90.0), SimpleNamespace(largest=lambda _: 900.0)
    fitted = effect("dead-zone", half_width=24.8)
    steps = [law.values["step"] for law in fitted.relatives(few)]
    assert min(abs(step - 54.3) for step in steps) < 1.0
    assert fitted.relatives(many) == ()
