"""The tests of the residual alarm as often as they say, and find wrong declarations, on data that scipy alone made."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter, max_len_seq
from scipy.stats import binomtest, kstest

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.identification.declaration_search import alternative_declarations, refitted
from camid.identification.declarations import contradiction_sentence
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.residual_analysis import analyse_residual
from camid.identification.residual_statistics import Moments, Rows
from camid.identification.structure import Structure

MODE = ([100.0], [1.0, 2.0, 100.0])
PERIOD = 0.1
STEPS = 20  # a period


def film(plant, signal, period=PERIOD, hold="zoh", exposure=1.0, latency=0.0):
    """Sensor samples; exposure (0: instant) and latency count in periods. Straight lines begin at a sample of zero."""
    numerator, denominator = plant
    if hold == "zoh":
        driven = np.repeat(signal, STEPS)
    else:
        assert signal[0] == 0.0
        driven = np.interp(np.arange(STEPS * (len(signal) - 1) + 1) / STEPS, np.arange(len(signal)), signal)
    denominator = denominator if exposure == 0.0 else np.polymul(denominator, [1.0, 0.0])
    top, bottom, _ = cont2discrete((numerator, denominator), period / STEPS, method=hold)
    moved = lfilter(top.ravel(), bottom, driven)  # the output, or its integral
    end = STEPS * np.arange(len(signal)) - round(STEPS * latency)
    begin = end - round(STEPS * exposure)

    def at(index):
        return np.where(index > 0, moved[np.maximum(index, 0)], 0.0)

    return at(end) if exposure == 0.0 else (at(end) - at(begin)) / (exposure * period)


def excite(kind, count, generator):
    """An input of some kind, zero at first."""
    if kind == "prbs":
        signal = 2.0 * max_len_seq(int(np.ceil(np.log2(count + 1))))[0][:count] - 1.0
    elif kind == "multisine":
        angle = 2.0 * np.pi * np.arange(count) / count
        signal = sum(np.cos(line * angle + generator.uniform(0.0, 2.0 * np.pi)) for line in (3, 7, 15, 31, 40))
    elif kind == "coloured":
        signal = lfilter([1.0], [1.0, -0.95], generator.standard_normal(count))
    else:
        signal = np.repeat(generator.uniform(-1.0, 1.0, count // 8 + 1), 8)[:count]
    signal = np.array(signal)
    signal[0] = 0.0
    return signal


def recorded(
    generator, kind="prbs", count=511, decibel=10.0, noise=(1.0,), moving=False, missing=False, several=1, **chain
):
    """Experiments of one rig as a right declaration describes them."""
    experiments, level = [], None
    before = 40 if moving else 0
    for _ in range(several):
        signal = excite(kind, count // several + before, generator)
        clean = film(MODE, signal, **chain)[before:]
        level = level or np.std(clean) * 10.0 ** (-decibel / 20.0)
        coloured = lfilter([1.0], noise, generator.standard_normal(len(clean) + 300))[300:]
        output = clean + level * coloured / np.sqrt(np.sum(lfilter([1.0], noise, np.eye(300)[0]) ** 2))
        acquisition = Acquisition(
            chain.get("period", PERIOD),
            chain.get("hold", "zoh"),
            "camera" if chain.get("exposure", 1.0) else "instant",
            chain.get("exposure", 1.0) * chain.get("period", PERIOD) or None,
            chain.get("latency", 0.0) * chain.get("period", PERIOD),
        )
        used = np.ones(len(output), bool)
        if moving:
            used[: acquisition.window()[0]] = False
        if missing:
            used[len(output) // 3 : len(output) // 2] = False
            used[::17] = False
        experiments.append(Experiment(signal[before:], output, acquisition, used, moving))
    return experiments


def analysed(experiments, declared=None):
    """Analysis of the residual that an estimate leaves; where the declaration is right, it starts at the truth."""
    structure = Structure.of_order(2, 0)
    if declared is None:
        plant = refitted(structure, TransferFunction(*MODE), experiments)[1]
    else:
        experiments = [replace(e, acquisition=declared) for e in experiments]
        plant = estimate(structure, experiments).plant
    return analyse_residual(structure, plant, experiments)


def p_values(sets, **recording):
    """Whiteness and independence for data sets of the root seed 2008, shape (sets, 2)."""
    seeds = np.random.SeedSequence(2008).spawn(sets)
    found = [analysed(recorded(np.random.default_rng(seed), **recording)) for seed in seeds]
    return np.array([(a.whiteness_p, a.independence_p) for a in found])


def assert_uniform(values):
    assert kstest(values, "uniform").pvalue > 1e-3
    alarms = int(np.sum(values < 0.003))
    assert binomtest(alarms, len(values), 0.003).pvalue > 1e-3


RIGHTLY_DECLARED = [
    {},
    {"count": 200},
    {"count": 200, "kind": "multisine"},  # the lagged inputs have ten directions and a transient
    {"kind": "coloured"},
    {"count": 200, "kind": "steps", "moving": True},
    {"several": 3, "moving": True, "kind": "steps"},
    {"missing": True},
    {"hold": "foh", "exposure": 0.4, "latency": 1.3, "count": 200},
]


# A hundred values show an error of the distribution of 0.2, a thousand one of 0.06 and an alarm rate of the tail.
@pytest.mark.parametrize("sets", [100, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("recording", RIGHTLY_DECLARED, ids=str)
def test_p_values_are_uniform_if_the_declaration_is_right(sets, recording):
    for values in p_values(sets, **recording).T:
        assert_uniform(values)


@pytest.mark.parametrize(
    "recording",
    [
        {"noise": (1.0, -0.5)},
        {"noise": (1.0, -1.6, 0.8)},
        {"noise": (1.0, -0.9), "count": 200, "kind": "multisine"},
        {"noise": (1.0, -0.9), "moving": True, "missing": True},
    ],
    ids=str,
)
def test_coloured_noise_is_not_white_but_independent_of_the_input(recording):
    white, independent = p_values(100, **recording).T
    assert np.mean(white < 1e-3) > 0.95
    assert_uniform(independent)


def test_moments_are_those_of_the_matrices():
    generator = np.random.default_rng(3)
    experiments = []
    for count in (90, 57):
        used = np.ones(count, bool)
        used[20:31] = used[::7] = False
        values = generator.standard_normal((2, count))
        experiments.append(Experiment(values[0], values[1], Acquisition(1.0), used))
    fitted = sum(int(e.used.sum()) for e in experiments)
    table = generator.standard_normal((fitted, 4))
    rows = Rows.of(experiments, generator.standard_normal(fitted), table, np.zeros((fitted, 0)), 12, 0)
    moments = Moments.of(rows, 12)
    size = len(rows.used)
    left = np.diag(rows.used.astype(float)) - rows.basis @ rows.basis.T
    shifts = [0.5 * (np.eye(size, k=k) + np.eye(size, k=-k)) for k in range(13)]
    np.testing.assert_allclose(moments.first, [np.trace(left @ a) for a in shifts], atol=1e-10)
    second = [[np.trace(left @ a @ left @ b) for a in shifts] for b in shifts]
    np.testing.assert_allclose(moments.second, second, atol=1e-10)


DECLARED = {
    "hold": Acquisition(PERIOD, "foh"),
    "exposure": Acquisition(PERIOD, exposure=0.5 * PERIOD),
    "sensor": Acquisition(PERIOD, sensor="instant"),
    "latency": Acquisition(PERIOD, latency=0.3 * PERIOD),
}


@pytest.mark.parametrize("wrong", DECLARED)
def test_a_wrong_declaration_is_found_and_named(wrong):
    experiments = recorded(np.random.default_rng(1), decibel=20.0)
    analysis = analysed(experiments, DECLARED[wrong])
    assert analysis.contradicts
    assert analysis.independence_p < 1e-6
    structure = Structure.of_order(2, 0)
    experiments = [replace(e, acquisition=DECLARED[wrong]) for e in experiments]
    plant = estimate(structure, experiments).plant
    found = alternative_declarations(structure, plant, experiments)
    passing = [a for a in found if a.passes]
    named = [a for a in passing if a.analysis.deviance < passing[0].analysis.deviance + 6.0]
    right = [a for a in named if a.changed == (wrong,)]
    assert len(right) == 1
    assert right[0].acquisition == Acquisition(PERIOD)
    assert right[0].nrmse == pytest.approx(0.1, rel=0.1)
    np.testing.assert_allclose(right[0].plant.denominator, MODE[1], rtol=0.05)


def test_two_wrong_declarations_are_found_together():
    experiments = recorded(np.random.default_rng(1), decibel=20.0, hold="foh", exposure=0.0)
    experiments = [replace(e, acquisition=Acquisition(PERIOD)) for e in experiments]
    structure = Structure.of_order(2, 0)
    plant = estimate(structure, experiments).plant
    best = alternative_declarations(structure, plant, experiments)[0]
    assert best.passes
    assert best.changed[0] == "hold"
    assert best.acquisition.hold == "foh"


def test_a_residual_that_passes_and_is_larger_does_not_fall():
    """A delay that a coefficient bends for leaves less, and depends on the input."""
    experiments = recorded(np.random.default_rng(1), decibel=20.0, hold="foh", exposure=0.0)
    experiments = [replace(e, acquisition=Acquisition(PERIOD)) for e in experiments]
    structure = Structure.of_order(2, 0)
    plant = estimate(structure, experiments).plant
    analysis = analyse_residual(structure, plant, experiments)
    found = alternative_declarations(structure, plant, experiments)
    for before, word in ((10.0, "the residual falls from"), (1e-6, "the residual goes from")):
        assert word in contradiction_sentence(analysis, before, Acquisition(PERIOD), found)


def test_what_no_declaration_explains():
    """A second mode."""
    generator = np.random.default_rng(1)
    signal = excite("prbs", 511, generator)
    whole = (np.array([100.0 * 400.0]), np.polymul(MODE[1], [1.0, 2.0, 400.0]))
    output = film(whole, signal)
    output = output + 0.03 * np.std(output) * generator.standard_normal(len(output))
    experiments = [Experiment(signal, output, Acquisition(PERIOD), np.ones(len(output), bool))]
    structure = Structure.of_order(2, 0)
    plant = estimate(structure, experiments).plant
    analysis = analyse_residual(structure, plant, experiments)
    found = alternative_declarations(structure, plant, experiments)
    assert analysis.contradicts
    assert not any(a.passes for a in found)
    sentence = contradiction_sentence(analysis, 1.0, Acquisition(PERIOD), found)
    assert "no hold, exposure or latency explains it" in sentence


def test_correlations_lie_within_their_bounds_and_a_wrong_declaration_shows():
    outside = np.zeros(2)
    for seed in np.random.SeedSequence(2008).spawn(60):
        table = analysed(recorded(np.random.default_rng(seed), noise=(1.0, -0.7))).correlations(PERIOD)
        inside = table[table["lag"] != 0]
        outside += [
            np.mean(np.abs(inside["autocorrelation"]) > inside["bound_autocorrelation"]),
            np.mean(np.abs(table["crosscorrelation"]) > table["bound_crosscorrelation"]),
        ]
    assert outside[0] / 60 > 0.1  # the noise is not white, and the bounds say so
    assert 0.002 < outside[1] / 60 < 0.02
    assert table["lag"].tolist() == list(range(-25, 26))
    np.testing.assert_allclose(table["seconds"], PERIOD * table["lag"])
    assert table.loc[table["lag"] == 0, "autocorrelation"].item() == 1.0
    wrong = analysed(recorded(np.random.default_rng(1)), DECLARED["hold"]).correlations(PERIOD)
    past, future = wrong[wrong["lag"] >= 0], wrong[wrong["lag"] < 0]
    assert np.max(np.abs(past["crosscorrelation"]) / past["bound_crosscorrelation"]) > 1.5
    assert np.max(np.abs(future["crosscorrelation"]) / future["bound_crosscorrelation"]) < 1.5


def test_rounding_is_no_residual():
    analysis = analysed(recorded(np.random.default_rng(0), decibel=400.0))
    assert analysis.at_rounding
    assert analysis.whiteness_p is None
    assert not analysis.contradicts
    assert "nothing to test" in analysis.summary()


def test_units_do_not_matter():
    (one,) = recorded(np.random.default_rng(0))
    small = replace(one, signal=1e-60 * one.signal, output=1e80 * one.output)
    foh = DECLARED["hold"]
    first, second = analysed([one], foh), analysed([small], foh)
    assert second.whiteness_p == pytest.approx(first.whiteness_p, rel=1e-3)
    assert second.independence_p == pytest.approx(first.independence_p, rel=1e-3)
    structure = Structure.of_order(2, 0)
    small = replace(small, acquisition=foh)
    plant = estimate(structure, [small]).plant
    found = alternative_declarations(structure, plant, [small])
    best = next(a for a in found if a.changed == ("hold",))
    assert best.passes
    assert best.plant.static_gain() == pytest.approx(1e140, rel=0.1)


def test_an_offset_is_no_dynamics():
    """Nor is it a correlation with an input that has a mean, nor colour of the noise."""
    for seed in range(5):
        (one,) = recorded(np.random.default_rng(seed), decibel=20.0, kind="steps")
        shifted = replace(one, output=one.output + 0.5 * np.std(one.output))
        analysis = analysed([shifted])
        assert analysis.independence_p > 1e-3
        assert analysis.whiteness_p > 1e-3


def test_a_long_delay_is_tested_where_it_acts():
    """Declared with 30 periods of latency instead of 31, the residual depends on inputs more than 25 samples ago."""
    experiments = recorded(np.random.default_rng(0), decibel=20.0, latency=31.0)
    assert analysed(experiments).independence_p > 1e-3
    analysis = analysed(experiments, Acquisition(PERIOD, latency=30.0 * PERIOD))
    assert analysis.independence_p < 1e-6
    assert analysis.correlations(PERIOD)["lag"].max() > 31


def test_too_few_samples_and_free_decays():
    (one,) = recorded(np.random.default_rng(0), count=12)
    short = analysed([one])
    assert short.independence_p is None
    assert "too few" in short.summary()
    (one,) = recorded(np.random.default_rng(0), moving=True)
    decay = film(MODE, np.repeat([1.0, 0.0], [30, 270]), exposure=1.0)[40:]
    noise = 0.05 * np.std(decay) * np.random.default_rng(1).standard_normal(len(decay))
    free = Experiment(np.zeros(len(decay)), decay + noise, one.acquisition, np.ones(len(decay), bool), True)
    structure = replace(Structure.of_order(2, 0), numerator=np.array([100.0]), free_numerator=np.array([False]))
    plant = estimate(structure, [free]).plant
    analysis = analyse_residual(structure, plant, [free])
    assert analysis.independence_p is None
    assert analysis.whiteness_p > 1e-3
    assert "input" not in analysis.summary()
