"""Designs: limits that are kept, evidence that is not absorbed by a fit, and decisions that come true."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import camid
from camid.errors import InputError
from camid.experiment_design.hypothesis import Played, hypothesis_of
from camid.experiment_design.limits import Limits
from camid.experiment_design.prediction import NoiseModel, responses
from camid.experiment_design.refit import left_after_fit, refitted
from camid.experiment_design.run import information
from camid.experiment_design.separation import pairs_of
from camid.experiment_design.signals import FAMILIES, Band
from camid.simulation.file import load_simulation
from tests.experiment_design.conftest import ROWS, played
from tests.support.mass_on_spring import PERIOD, effect, record, simulation

TRUE = {"numerator": [100.0], "denominator": [1.0, 2.0, 100.0]}
NOISE = NoiseModel(0.02, np.ones(1))


def believed(*effects, plant=TRUE, **changes):
    declared = [{"id": e.identifier, "parameters": e.stated()} for e in effects]
    return simulation(plant={"transfer_function": plant}, effects=declared, **changes)


def hypothesis(name, *effects, **changes):
    return hypothesis_of(load_simulation(believed(*effects, **changes)), name, PERIOD, question="one")


def steps(rows=400, hold=20):
    return Played(np.repeat(np.resize([0.0, 1.0, -1.0, 0.5, -0.5], rows // hold), hold), PERIOD)


# -- evidence ----------------------------------------------------------------------------------------------------------


def test_what_a_fit_absorbs_is_no_evidence():
    """Two stiffnesses and gains differ by far, and are the same structure: fitted again, nothing tells them apart."""
    other = {"numerator": [90.0], "denominator": [1.0, 2.6, 110.0]}
    pair = [hypothesis("one"), hypothesis("other", plant=other)]
    found = responses(pair, steps(), NOISE)
    difference = NOISE.whitened(found[0].output - found[1].output)
    assert float(difference @ difference) > 1e4
    (one, another) = refitted(pair, steps(), NOISE, pairs_of(found, NOISE))
    assert max(one.left, another.left) < 1.0


def test_first_order_agrees_with_a_real_fit_for_a_small_difference():
    pair = [hypothesis("drag", effect("quadratic-drag", coefficient=1e-4)), hypothesis("none")]
    linear = pairs_of(responses(pair, steps(), NOISE), NOISE)[0].left
    fitted = refitted(pair, steps(), NOISE, pairs_of(responses(pair, steps(), NOISE), NOISE))[0].left
    assert 5.0 < fitted <= linear
    assert fitted == pytest.approx(linear, rel=0.1)


def test_a_fit_is_held_by_what_earlier_recordings_say():
    """With every coefficient known the rival cannot turn its damping up, and leaves more."""
    drag = hypothesis("drag", effect("quadratic-drag", coefficient=0.01))
    free = hypothesis("none")
    names = ["coefficient 0", "coefficient 1", "coefficient 2"]
    known = hypothesis_of(free.simulation, "none", PERIOD, parameters=names, information=1e9 * np.eye(3))
    truth = responses([drag], steps(), NOISE)[0].output
    assert left_after_fit(known, truth, steps(), NOISE) > 2.0 * left_after_fit(free, truth, steps(), NOISE)


def test_differences_are_measured_in_whitened_noise():
    random = np.random.default_rng(7)
    noise = NoiseModel(0.02, np.array([1.0, -0.9]))
    slow = lfilter([1.0], noise.whitening, 0.02 * random.standard_normal(20_000))
    whitened = noise.whitened(slow)
    assert np.std(whitened) == pytest.approx(1.0, rel=0.03)
    assert abs(np.mean(whitened[1:] * whitened[:-1])) < 0.03
    # A constant is a hundredth as visible in it as in white noise of the same innovations.
    constant = noise.whitened(np.ones(500)) @ noise.whitened(np.ones(500))
    assert constant == pytest.approx(0.01 * 499 / 0.02**2, rel=1e-6)


def test_evidence_grows_with_the_rows_and_ends_at_the_whole():
    pair = [hypothesis("drag", effect("quadratic-drag", coefficient=0.01)), hypothesis("none")]
    found = responses(pair, steps(), NOISE)
    difference = NOISE.whitened(found[0].output - found[1].output)
    grown = found[1].growth(difference, np.array([100, 200, 300, 400]))
    assert np.all(np.diff(grown) >= -1e-9)
    assert grown[-1] == pytest.approx(found[1].left_of(difference), rel=1e-6)


# -- a design ----------------------------------------------------------------------------------------------------------


def test_the_first_recording_leaves_two_names_and_designs_an_experiment(diagnosis):
    finding = diagnosis.findings[0]
    names = dict([(finding.identifier, finding.weight), *finding.alternatives])
    assert min(names["gain-asymmetry"], names["input-bias"]) > 0.1
    assert "if it is Asymmetric gain of the actuator: ΔBIC" in finding.separating_experiment
    assert "camid design" in finding.separating_experiment
    ids = [h.identifier for h in diagnosis.hypotheses]
    assert {"gain-asymmetry", "input-bias", None} <= set(ids)


def test_a_designed_experiment_decides_and_a_repetition_does_not(first, diagnosis, design):
    second = played(design.played.signal, 5)
    found = camid.diagnose([first, second], simulation()).findings[0]
    assert (found.identifier, found.weight > 0.95) == ("gain-asymmetry", True)
    promised = next(e for e in design.expectations if e.identifier == "gain-asymmetry")
    assert promised.weight > 0.95
    assert promised.seconds < design.duration
    repeated = camid.diagnose([first, played(first["u"].to_numpy(), 6)], simulation()).findings[0]
    assert repeated.weight < 0.6


@pytest.mark.slow
def test_a_design_is_the_same_again(diagnosis, design):
    again = camid.design(diagnosis, time_limit=None)
    np.testing.assert_array_equal(again.played.signal, design.played.signal)
    assert again.to_mapping() == design.to_mapping()


@pytest.mark.slow
def test_limits_are_kept_under_every_hypothesis(diagnosis):
    limits = {"amplitude": (-0.8, 0.9), "rate": 4.0, "duration": 5.0, "travel": (-0.9, 0.7)}
    found = camid.design(diagnosis, **limits, time_limit=None)
    signal = found.played.signal
    assert len(signal) == round(5.0 / PERIOD)
    assert -0.8 <= signal.min() < signal.max() <= 0.9
    assert np.max(np.abs(np.diff(signal, prepend=0.0))) <= 4.0 * PERIOD + 1e-6
    assert len({e.identifier for e in found.expectations}) >= 2
    for each in found.hypotheses:
        table = record(*each.model.effects, count=len(signal), noise=0.0, signal=signal, plant=each.simulation.plant)
        assert -0.9 <= table["y"].min() < table["y"].max() <= 0.7
    assert -0.9 <= found.travel[0] < found.travel[1] <= 0.7


@pytest.mark.slow
def test_what_no_input_tells_apart_is_said():
    """At a thousandth of the amplitude the noise hides everything."""
    pair = [believed(effect("cubic-stiffness", coefficient=0.1)), believed(effect("quadratic-drag", coefficient=0.01))]
    found = camid.design(pair, amplitude=(-0.001, 0.001), duration=4.0, frame_rate=50.0, noise=0.02, time_limit=None)
    assert [e.seconds for e in found.expectations] == [None, None]
    assert max(e.evidence for e in found.expectations) < 2.0
    assert found.seconds_to_decide is None


@pytest.mark.slow
def test_a_faster_camera_is_taken_where_it_says_more():
    sensor = {"column": "y", "kind": "camera", "exposure": 0.02, "latency": 0.0}
    lag = believed(effect("actuator-lag", time_constant=0.01), sensor=sensor)
    delay = believed(effect("delay", delay=0.01), sensor=sensor)
    options = {"amplitude": (-1.0, 1.0), "duration": 4.0, "noise": 0.01, "time_limit": None}
    one = camid.design([lag, delay], frame_rate=50.0, **options)
    two = camid.design([lag, delay], frame_rate=(50.0, 200.0), exposure=(0.02, 0.004), **options)
    assert two.played.period == pytest.approx(1 / 200)
    assert two.played.exposure == 0.004
    assert two.evidence > 1.5 * one.evidence


@pytest.mark.slow
def test_a_rig_that_can_be_released_says_what_no_input_does():
    """An input of a hundredth of the friction moves nothing; a release from a position decides at once."""
    pair = [believed(effect("coulomb-friction", force=0.1)), believed(effect("quadratic-drag", coefficient=0.05))]
    found = camid.design(
        pair,
        amplitude=(-0.001, 0.001),
        duration=6.0,
        frame_rate=50.0,
        noise=0.01,
        initial_position=1.0,
        travel=(-2.0, 2.0),
        time_limit=None,
    )
    assert found.played.position == 1.0
    assert min(e.evidence for e in found.expectations) > 100.0
    for output in found.outputs.values():
        assert output[1] == pytest.approx(1.0, abs=0.1)


# -- coefficients ------------------------------------------------------------------------------------------------------


def test_one_hypothesis_is_determined(first):
    """D-optimal: better than the first recording again, by its own measure."""
    found = camid.design(believed(), recording=first, time_limit=None)
    assert found.expectations == []
    assert found.evidence is None
    after = np.array([d.after for d in found.determined])
    before = np.array([d.before for d in found.determined])
    assert {"b0", "a1", "a0"} <= {d.name for d in found.determined}
    assert np.all(after < before)
    assert np.prod(after / before) < 0.5 ** (0.5 * len(after))


def test_an_input_that_moves_nothing_determines_nothing():
    """A rig that moves by millimetres, in metres: a fit measures its gain by the output, and by a metre without one."""
    gap, small = effect("dead-zone", half_width=0.4), {"numerator": [0.1], "denominator": [1.0, 2.0, 100.0]}
    names = [*(f"coefficient {i}" for i in range(3)), "dead-zone half_width"]
    simulated = load_simulation(believed(gap, plant=small))
    known = hypothesis_of(simulated, "dead-zone", PERIOD, parameters=names, information=np.diag([1e10, 1e4, 1e4, 1e5]))
    noise = NoiseModel(2e-5, np.ones(1))
    still, moved = (responses([known], Played(share * steps().signal, PERIOD), noise)[0] for share in (0.3, 1.0))
    assert np.ptp(still.output) < 1e-12 < np.ptp(moved.output)
    assert information(moved) > information(still)


@pytest.mark.slow
def test_expected_deviations_come_true(first):
    found = camid.design(believed(), recording=first, time_limit=None)
    noise = {"noise": 0.02, "count": ROWS}
    values = [
        camid.identify(record(signal=found.played.signal, seed=seed, **noise), believed()).simulation.plant.denominator
        for seed in range(30)
    ]
    alone = replace(found.hypotheses[0], information=np.zeros_like(found.hypotheses[0].information))
    expected = responses([alone], found.played, NOISE)[0].deviations(with_experiment=True)
    # A diagnosis fits four fifths of the rows, and identification all.
    np.testing.assert_allclose(np.std([v[1] for v in values]), np.sqrt(0.8) * expected[1], rtol=0.4)


# -- signals -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_every_member_of_a_family_stays_in_its_range(family):
    band = Band(0.2, 8.0, 0.02, 517)
    random = np.random.default_rng(1)
    corners = [np.zeros(family.numbers), np.ones(family.numbers), *random.random((40, family.numbers))]
    for numbers in corners:
        signal, _ = family.make(numbers, band)
        assert signal.shape == (517,)
        assert np.all(np.isfinite(signal))
        assert np.max(np.abs(signal)) <= 1.0 + 1e-12
        assert np.ptp(signal) > 0.0


def test_a_written_input_never_leaves_its_range():
    limits = Limits(-0.3333333, 0.1111111, 5.0, 10.0, (0.02,))
    random = np.random.default_rng(2)
    signal = limits.kept(random.uniform(-1.5, 1.5, 500), 0.02)
    assert limits.low <= signal.min()
    assert signal.max() <= limits.high
    assert np.max(np.abs(np.diff(signal, prepend=0.0))) <= 5.0 * 0.02 + 1e-6


# -- refusals ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"travel": (0.2, 0.9)}, "the rig rests at"),
        ({"travel": (0.9, 0.2)}, "travel"),
        ({"amplitude": (0.5, 0.5)}, "the input can only be 0.5"),
        ({"amplitude": (1.0, -1.0)}, "amplitude"),
        ({"duration": 0.1}, "are 5 rows"),
        ({"duration": 1e7}, "at most 50000"),
        ({"rate": 0.0}, "rate 0"),
        ({"frame_rate": -1.0}, "frame rate"),
        ({"noise": 0.0}, "noise 0"),
        ({"exposure": 0.5}, "exposure 0.5 s"),
        ({"initial_position": 50.0, "travel": (-1.0, 1.0)}, "the initial position 50 y lies outside"),
    ],
)
def test_limits_that_cannot_be_kept_are_refused_in_one_line(diagnosis, options, said):
    with pytest.raises(InputError) as refused:
        camid.design(diagnosis, **options)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
    assert refused.value.hint


def test_simulations_alone_need_limits():
    for missing in ("amplitude", "duration", "frame_rate", "noise"):
        options = {"amplitude": (-1.0, 1.0), "duration": 4.0, "frame_rate": 50.0, "noise": 0.01}
        options.pop(missing)
        with pytest.raises(InputError, match="is not known"):
            camid.design([believed(), believed(effect("coulomb-friction", force=0.1))], **options)


def test_a_free_decay_has_no_input_to_design():
    content = believed(input=None, initial_state="estimate")
    with pytest.raises(InputError, match="nothing drives this plant"):
        camid.design(content, amplitude=(-1, 1), duration=4.0, frame_rate=50.0, noise=0.01)


@pytest.mark.slow
def test_the_numbers_of_a_driven_pendulum_are_determined():
    """Those of its motion near rest are fitted, and have units, though its constants are others."""
    pendulum = {"natural_frequency": 6.0, "damping": 0.05, "rest": 0.0, "gain": 0.2}
    known = {**believed(), "plant": {"pendulum": pendulum}}
    found = camid.design([known], amplitude=(-1.0, 1.0), frame_rate=50.0, duration=4.0, noise=0.002, time_limit=None)
    assert {each.name: each.unit for each in found.determined} == {
        "b0": "y/(u s^2)",
        "a1": "s^-1",
        "a0": "s^-2",
        "rest": "y",
    }
