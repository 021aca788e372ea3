"""How hypotheses are compared, and what a search need not do twice."""

import numpy as np
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.diagnosis.search import screening
from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.screening import Signatures, screen
from camid.effects import known_effects
from camid.fitting import output_error
from camid.fitting.fit import evaluate, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import LinearPlant
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from camid.proof.concealed.cases import plan
from camid.proof.concealed.generator import make
from tests.support import pendulum_and_drive as rigs

PERIOD = 0.02
PLANT = second_order(1.0, 10.0, 0.1)
COUNT = 2000


def rig(noise):
    """A linear rig and the model that is right."""
    random = np.random.default_rng(3)
    signal = np.repeat(random.choice([-1.0, -0.4, 0.7, 1.0], COUNT // 5), 5)
    acquisition = Acquisition(PERIOD)
    output = sample(PLANT, signal, acquisition) + 0.05 * noise(random)
    structure = Structure.of_order(2, 0)
    experiment = Experiment(signal, output, acquisition, np.ones(COUNT, bool))
    problem = Problem(structure, [experiment], [PERIOD * np.arange(COUNT)], LinearPlant(), 0.1)
    return problem, Model(np.array([*PLANT.numerator, *PLANT.denominator[1:]]), (), (None,))


def white(random):
    return random.standard_normal(COUNT)


def slow(random):
    """First-order noise, a tenth of which is left after a step."""
    found = white(random)
    for k in range(1, COUNT):
        found[k] += 0.9 * found[k - 1]
    return found


def models(problem, model, **changes):
    """The model, and the same with an effect that is not there, fitted."""
    base = fit(problem, model)
    effect = known_effects()["sensor-drift"](**{p.name: 1e-3 for p in known_effects()["sensor-drift"].parameters})
    return base, fit(problem, base.model.plus(effect))


def test_in_white_noise_the_criterion_is_bayes_s():
    base, more = models(*rig(white))
    assert len(base.noise.whitening) == 1
    count, added = COUNT, len(more.packing.names) - len(base.packing.names)
    variances = [f.cost / (count - len(f.packing.names)) for f in (more, base)]
    expected = count * np.log(variances[0] / variances[1]) + added * np.log(count)
    assert more.criterion_beyond(base) == pytest.approx(expected)
    assert base.criterion_beyond(more) == pytest.approx(-expected)
    assert more.criterion_beyond(base) > 0.0


def test_what_noise_of_a_colour_does_by_itself_is_no_evidence():
    """A drift takes much more of slow noise than of white noise: its gain counts for as much less."""
    base, more = models(*rig(slow))
    gain = COUNT * np.log(base.cost / more.cost)
    change = base.residual - more.residual
    assert gain > 5.0
    # The spectrum of the noise at frequency zero over its mean: (1 + ρ)/(1 − ρ).
    assert more.inflation(change) == pytest.approx(19.0, rel=0.3)
    added = len(more.packing.names) - len(base.packing.names)
    assert base.criterion_beyond(more) < gain / 10.0 - added * np.log(COUNT) + 0.5
    assert in_order([Hypothesis("more", more), Hypothesis("", base)])[0].identifier == ""


def test_colour_never_adds_evidence():
    _, more = models(*rig(slow))
    fast = np.where(np.arange(COUNT) % 2 == 0, 1.0, -1.0)
    assert more.inflation(fast) == 1.0
    assert more.inflation(0.0 * fast) == 1.0


def test_a_general_law_has_prior_odds_against_it():
    problem, _ = rig(white)
    kinds = known_effects()
    general = kinds["stribeck-friction"](coulomb=1.0, breakaway=2.0, velocity=3.0)
    assert prior_penalty(problem, kinds["coulomb-friction"](force=1.0)) == 0.0
    assert 1.0 < prior_penalty(problem, general) < 4.0


@pytest.mark.slow
def test_a_general_law_takes_the_place_of_its_special_case():
    """Friction that falls with the speed, of which Coulomb's is found first, by the generator of the sealed proof."""
    case = plan(778, 72)[23]
    assert case.effects == ("stribeck-friction",)
    concealed = make(case)
    diagnosis = camid.diagnose(concealed.recording, concealed.simulation)
    assert [f.identifier for f in diagnosis.findings] == ["stribeck-friction"]
    true = concealed.truth["effects"][0]["parameters"]
    for name, value in diagnosis.findings[0].parameters.items():
        assert abs(value.value - true[name]) < 4.0 * value.standard_deviation


@pytest.mark.slow
def test_as_many_effects_as_the_recording_shows():
    """A torque that is always there holds the heavy side at an angle, where the sensor's zero is estimated."""
    true = {"friction": 0.05, "delay": 0.012, "bias": 0.08}
    diagnosis = camid.diagnose(rigs.disc(**true, count=1500), rigs.disc_simulation(), time_limit=None)
    found = {f.identifier: f.parameters for f in diagnosis.findings}
    assert set(found) == {"pendulum-gravity", "coulomb-friction", "delay"}
    assert diagnosis.verdict == "explained"
    estimates = (
        ("coulomb-friction", "force", true["friction"]),
        ("delay", "delay", true["delay"]),
        ("pendulum-gravity", "amplitude", 1.0),
        ("pendulum-gravity", "rest", np.arcsin(true["bias"])),
    )
    for name, parameter, truth in estimates:
        value = found[name][parameter]
        assert abs(value.value - truth) < 4.0 * value.standard_deviation


@pytest.fixture
def simulated(monkeypatch):
    """Effects that screenings simulate."""
    names = []
    original = screening.signature

    def counted(problem, base, effect):
        names.append(effect.identifier)
        return original(problem, base, effect)

    monkeypatch.setattr(screening, "signature", counted)
    return names


def test_a_screening_near_an_earlier_one_simulates_only_what_may_matter(simulated):
    problem, model = rig(white)
    friction = known_effects()["coulomb-friction"](force=0.01)
    base, signatures = fit(problem, model), Signatures()
    first = screen(problem, base, signatures=signatures)
    everything = len(simulated)
    beside = evaluate(problem, base.model.plus(friction))
    simulated.clear()
    quick = screen(problem, beside, signatures=signatures)
    assert len(simulated) < 0.4 * everything
    simulated.clear()
    thorough = screen(problem, beside)
    assert [c.effect.values for c in quick[:5]] == [c.effect.values for c in thorough[:5]]
    np.testing.assert_allclose([c.gain for c in quick[:5]], [c.gain for c in thorough[:5]])
    assert {c.effect.identifier for c in quick} == {c.effect.identifier for c in thorough}
    assert len(first) > 0


def test_a_screening_far_from_an_earlier_one_simulates_everything(simulated):
    problem, model = rig(white)
    signatures = Signatures()
    screen(problem, fit(problem, model), signatures=signatures)
    everything = len(simulated)
    simulated.clear()
    elsewhere = TransferFunction((30.0,), (1.0, 2.0, 60.0))
    other = Model(np.array([*elsewhere.numerator, *elsewhere.denominator[1:]]), (), (None,))
    screen(problem, evaluate(problem, other), signatures=signatures)
    assert len(simulated) > 0.8 * everything


def test_threads_change_no_derivative(monkeypatch):
    problem, model = rig(white)
    effect = known_effects()["coulomb-friction"](force=0.1)
    alone = evaluate(problem, model.plus(effect)).sensitivities
    monkeypatch.setattr(output_error, "STEPS_WORTH_A_THREAD", 0)
    np.testing.assert_array_equal(evaluate(problem, model.plus(effect)).sensitivities, alone)
