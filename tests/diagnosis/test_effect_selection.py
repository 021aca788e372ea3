"""Effects that show only beside each other, and minima in which a search must not stay."""

from types import SimpleNamespace

import numpy as np
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.diagnosis import setting
from camid.diagnosis.search import effect_selection, forward_selection, hypothesis_search
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.search.screening import screen
from camid.diagnosis.watch import Watch
from camid.effects import modes
from camid.effects.base import Effect
from camid.effects.gradual_friction import GradualAsymmetricFriction, GradualCoulombFriction
from camid.fitting.fit import evaluate, fit
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import PERIOD, effect, record, simulation


def believed(plant, **changes):
    """The rig with coefficients off by several per cent."""
    (numerator,), (one, damping, stiffness) = plant.numerator, plant.denominator
    moved = {"numerator": [0.95 * numerator], "denominator": [one, 1.05 * damping, 1.04 * stiffness]}
    return simulation(plant={"transfer_function": moved}, **changes)


def friction_and_bias():
    """Dry friction that differs with the direction, of a rig that is slow beside its input."""
    plant = TransferFunction((1.69,), (1.0, 1.755, 1.69))
    law = effect("asymmetric-friction", forward=0.3, backward=0.1)
    return record(law, plant=plant, noise=0.001), believed(plant)


@pytest.mark.slow
def test_what_one_of_two_effects_leaves_is_no_noise_that_hides_both(monkeypatch):
    diagnosis = camid.diagnose(*friction_and_bias())
    assert {f.identifier for f in diagnosis.findings} == {"input-bias", "coulomb-friction"}
    assert diagnosis.verdict == "explained"
    # Nothing is found where the search stops at the first that chance explains, too.
    monkeypatch.setattr(forward_selection, "WORTH_A_LOOK", 1.0)
    assert camid.diagnose(*friction_and_bias()).findings == []


@pytest.mark.slow
def test_an_effect_that_was_looked_beside_in_vain_is_dropped(monkeypatch):
    """It is kept for the time being alone, as the search beside it shows."""
    beside = []
    search = forward_selection.hypotheses

    def watched(problem, base, *arguments, **keywords):
        beside.append([e.identifier for e in base.model.effects])
        return search(problem, base, *arguments, **keywords)

    monkeypatch.setattr(forward_selection, "hypotheses", watched)
    monkeypatch.setattr(forward_selection, "FALSE_ALARM_BESIDE_OTHERS", 0.0)
    assert camid.diagnose(*friction_and_bias()).findings == []
    assert beside == [[], ["input-bias"]]


@pytest.mark.slow
def test_a_special_case_that_was_not_screened_may_lead(monkeypatch):
    """Friction that only its general laws suggest, in a first search and beside another effect."""
    every = setting.screen

    def screened(*arguments, **keywords):
        return [c for c in every(*arguments, **keywords) if c.effect.identifier != "coulomb-friction"]

    for module in (setting, forward_selection, effect_selection):
        monkeypatch.setattr(module, "screen", screened)
    rig = record(effect("coulomb-friction", force=0.15), effect("step-disturbance", size=0.6, time=6.0))
    diagnosis = camid.diagnose(rig, simulation())
    assert {f.identifier for f in diagnosis.findings} == {"coulomb-friction", "step-disturbance"}


@pytest.mark.slow
def test_a_resonance_beyond_half_the_frame_rate_is_found_in_its_own_minimum(monkeypatch):
    plant, frequency = TransferFunction((3604.2,), (1.0, 6.5, 3622.7)), 252.0
    count, camera = 436, {"exposure": 0.4 * PERIOD}
    recording = record(
        effect("extra-mode", natural_frequency=frequency, damping=0.022),
        plant=plant,
        noise=0.01,
        count=count,
        signal=np.random.default_rng(10).choice([-1.0, 1.0], count),
        **camera,
    )
    given = believed(plant, sensor={"column": "y", "kind": "camera", **camera})

    def found():
        (first, *_) = camid.diagnose(recording, given).findings
        # Another name has no such number.
        return first.identifier, getattr(first.parameters.get("natural_frequency"), "value", None)

    assert found() == ("extra-mode", pytest.approx(frequency, rel=0.01))
    # Of one shape on a coarse grid, without the lines of the residual, and not from a mode in parallel, it is not.
    monkeypatch.setattr(modes.ParallelMode, "relatives", Effect.relatives)
    monkeypatch.setattr(hypothesis_search, "MOST_FURTHER_SHAPES", 0)
    monkeypatch.setattr(modes, "highest_lines", lambda situation, count: iter(()))
    assert found() != ("extra-mode", pytest.approx(frequency, rel=0.1))


@pytest.mark.slow
def test_an_exposure_is_found_along_a_valley_of_coefficients():
    """A fit that stops in the valley leaves a mode in parallel the better name."""
    plant = TransferFunction((28_000.0,), (1.0, 67.2, 905.0, 28_480.0))
    count = 1700
    signal = np.random.default_rng(8).standard_normal(count)
    recording = record(plant=plant, noise=0.002, count=count, signal=signal, sensor="instant", exposure=None)
    moved = {"numerator": [20_000.0], "denominator": [1.0, 60.0, 1100.0, 25_000.0]}
    given = simulation(plant={"transfer_function": moved})
    found = camid.diagnose(recording, given)
    assert [f.identifier for f in found.findings] == ["exposure"]


def test_the_model_holds_the_likeliest_name_of_each_effect():
    """Also where it is likelier by less than a swap asks for; last, as it was fitted."""
    friction, step = effect("coulomb-friction", force=0.15), effect("step-disturbance", size=0.6, time=6.0)
    file = load_simulation(simulation(sensor={"column": "y", "kind": "camera", "offset": 0.0}))
    recordings, experiments, _ = experiments_of([record(friction, step)], file, None)
    problem = problem_of(file, structure_of(file), recordings, experiments)
    base = problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))
    other = effect("quadratic-drag", coefficient=0.05)
    pairs = (other, step), (step, friction)
    current, likelier = (fit(problem, base.model.plus(one).plus(two)) for one, two in pairs)
    own = [Hypothesis(law.identifier, current) for law in (other, step)]
    without = [current, base]
    unchanged = [[own[0]], [own[1]]]
    assert effect_selection.with_likelier_name(current, unchanged, without) == (current, unchanged, without)
    rivals = [[Hypothesis("coulomb-friction", likelier), own[0]], [own[1]]]
    found = effect_selection.with_likelier_name(current, rivals, without)
    assert [e.identifier for e in found[0].model.effects] == ["step-disturbance", "coulomb-friction"]
    assert [ranked[0].identifier for ranked in found[1]] == ["step-disturbance", "coulomb-friction"]
    assert found[2] == [base, current]


def refitted(recording, **changes):
    """Problem of a recording, and the fit of its plant alone."""
    file = load_simulation(simulation(**changes))
    recordings, experiments, _ = experiments_of([recording], file, None)
    problem = problem_of(file, structure_of(file), recordings, experiments)
    return problem, problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))


def test_what_was_found_earlier_is_held_against_the_effects_of_a_model_where_nothing_is_searched():
    """A name that led beside fewer effects need not lead beside all of them."""
    friction, step = effect("coulomb-friction", force=0.15), effect("step-disturbance", size=0.6, time=6.0)
    problem, base = refitted(record(friction, step), sensor={"column": "y", "kind": "camera", "offset": 0.0})
    drag = effect("quadratic-drag", coefficient=0.05)
    earlier = [Hypothesis(law.identifier, fit(problem, base.model.plus(law))) for law in (drag, friction)]
    current = fit(problem, base.model.plus(drag).plus(step))
    found = effect_selection._known_in_place(problem, [earlier], current, 0)
    assert [h.identifier for h in found] == ["coulomb-friction", "quadratic-drag"]
    assert [e.identifier for e in found[0].fitted.model.effects] == ["coulomb-friction", "step-disturbance"]
    assert found[0].fitted.cost < 0.5 * current.cost
    # Where what is there is the likeliest, it stays.
    kept = effect_selection._known_in_place(problem, [earlier], found[0].fitted, 0)
    assert [h.identifier for h in kept] == ["coulomb-friction", "quadratic-drag"]
    assert kept[0].fitted is found[0].fitted


def test_a_special_case_takes_the_place_of_its_law_among_the_effects():
    """Rivals belong to places: of a model in another order they would be those of another effect."""
    friction, step = effect("coulomb-friction", force=0.15), effect("step-disturbance", size=0.6, time=6.0)
    problem, base = refitted(record(friction, step), sensor={"column": "y", "kind": "camera", "offset": 0.0})
    falling = effect("stribeck-friction", coulomb=0.14, breakaway=0.16, velocity=0.1)
    current = fit(problem, base.model.plus(falling).plus(step))
    found = effect_selection._known_in_place(problem, [], current, 0)
    assert found[0].identifier == "coulomb-friction"
    assert [e.identifier for e in found[0].fitted.model.effects] == ["coulomb-friction", "step-disturbance"]


@pytest.mark.parametrize(
    ("law", "plant"),
    [
        (effect("dead-zone", half_width=0.3), TransferFunction((20.0,), (1.0, 15.0, 0.0))),
        (effect("backlash", half_width=0.2), TransferFunction((2.0,), (1.0, 2.0))),
    ],
)
def test_friction_is_held_against_what_bends_the_input_as_much(law, plant):
    """Of a plant that integrates a dead zone, and of one without a mass a play."""
    recording = record(law, plant=plant)
    moved = [0.95 * plant.numerator[0]], [1.0, 1.05 * plant.denominator[1], *plant.denominator[2:]]
    given = {"transfer_function": dict(zip(("numerator", "denominator"), moved, strict=True))}
    problem, base = refitted(recording, plant=given)
    current = fit(problem, base.model.plus(effect("coulomb-friction", force=0.2)))
    found = effect_selection._known_in_place(problem, [], current, 0)
    assert found[0].identifier == law.identifier
    assert found[0].fitted.model.effects[0].vector == pytest.approx(law.vector, rel=0.05)
    # A mass on a spring is not driven by either, nor does it run away.
    assert (
        effect("coulomb-friction", force=0.2).relatives(
            SimpleNamespace(plant=TransferFunction((1.0,), (1.0, 1.0, 9.0)))
        )
        == ()
    )


def test_the_special_case_of_a_law_with_more_detail_is_fitted_from_there(monkeypatch):
    """Else a law with one number more leads, whose special case was fitted from elsewhere and with less detail."""
    law = GradualCoulombFriction(force=0.2, transition=0.4)
    problem, base = refitted(record(law, noise=0.002, count=900))
    uneven = GradualAsymmetricFriction(forward=0.21, backward=0.19, transition=0.3)
    general = Hypothesis("asymmetric-friction", fit(problem, base.model.plus(uneven)))
    monkeypatch.setattr(hypothesis_search, "finer_laws", lambda *_: [general])
    screened = [c for c in screen(problem, base) if c.effect.identifier == "coulomb-friction"]
    found = hypothesis_search.hypotheses(
        problem, base, screened, effort=hypothesis_search.FIRST_EFFECT, watch=Watch(), incumbent=None
    )
    assert [h.identifier for h in found] == ["coulomb-friction", "asymmetric-friction"]
    assert found[0].fitted.model.effects[0].values == pytest.approx(law.values, rel=0.05)


@pytest.mark.parametrize(("left", "swept"), [(4.0, False), (1.5, False), (1.0, True), (14.0, True), (0.0, True)])
def test_an_effect_that_another_one_takes_along_is_noticed(left, swept):
    """Beside coefficients that are bent without the other one it comes to nothing, or to what it is not."""
    file = load_simulation(simulation())
    model = model_of(problem_of(file, structure_of(file), *experiments_of([record()], file, None)[:2]), [])
    whole = model.plus(effect("cubic-stiffness", coefficient=4.0)).plus(effect("delay", delay=0.004))
    others = model.plus(effect("cubic-stiffness", coefficient=left))
    assert effect_selection._sweeps_along(whole, others, 1) is swept
    assert not effect_selection._sweeps_along(whole, model.plus(effect("delay", delay=0.004)), 0)


def test_names_that_were_found_without_what_falls_with_an_effect_are_fitted_beside_it():
    """A mode stands for a delay beside a spring; beside the plant alone the spring came to nothing."""
    file = load_simulation(simulation())
    spring, late = effect("cubic-stiffness", coefficient=4.0), effect("delay", delay=0.008)
    recordings, experiments, _ = experiments_of([record(spring, late, noise=0.001)], file, None)
    problem = problem_of(file, structure_of(file), recordings, experiments)
    model = problem.with_initial_states(model_of(problem, []))
    mode = effect("extra-mode", natural_frequency=150.0, damping=0.6)
    current = fit(problem, model.plus(spring).plus(mode), steps=30)
    alone = Hypothesis("delay", evaluate(problem, model.plus(effect("delay", delay=0.004))))
    (found,) = effect_selection._leading_in_place(problem, [alone], current, 1)
    assert [e.identifier for e in found.fitted.model.effects] == ["cubic-stiffness", "delay"]
    assert found.fitted.model.effects[1].values["delay"] == pytest.approx(0.008, abs=5e-4)
    assert found.fitted.cost < 1.05 * current.cost
