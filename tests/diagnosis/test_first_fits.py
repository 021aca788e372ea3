"""First fits of hypotheses: where they begin, and what leads them astray."""

from types import SimpleNamespace

import numpy as np
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.diagnosis.search import hypothesis_search
from camid.diagnosis.search.screening import ScreenedEffect, may_be_more_than_chance
from camid.diagnosis.search.settled_laws import finer_in_place, finer_instead, settled_laws
from camid.diagnosis.watch import Watch
from camid.effects import known_effects
from camid.effects.actuator import LEAST_LAG
from camid.effects.gradual_friction import GradualAsymmetricFriction, GradualCoulombFriction
from camid.effects.gradual_saturation import GradualSaturation
from camid.fitting.fit import fit
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import PERIOD, command, effect, record, simulation


def refitted(recording, *effects):
    """Problem and re-estimated model of a recording, with effects that are known."""
    file = load_simulation(simulation(sensor={"column": "y", "kind": "camera", "offset": 0.0}))
    recordings, experiments, _ = experiments_of([recording], file, None)
    problem = problem_of(file, structure_of(file), recordings, experiments)
    model = problem.with_initial_states(model_of(problem, []))
    for each in effects:
        model = model.plus(each)
    return problem, fit(problem, model)


@pytest.mark.parametrize("factor", [30.0, 3000.0])
def test_a_fit_that_leads_nowhere_begins_again_with_a_small_effect(factor, monkeypatch):
    problem, base = refitted(record(effect("cubic-stiffness", coefficient=4.0), noise=0.001))
    guess = effect("cubic-stiffness", coefficient=0.2)
    too_large = ScreenedEffect(guess, gain=500.0, factor=factor, visible=20.0)
    found = hypothesis_search._fitted_first(problem, Watch(), base, [too_large], too_large)
    assert found.fitted.cost < 0.1 * base.cost
    monkeypatch.setattr(hypothesis_search, "STEPS_FROM_SMALL", 1)
    lost = hypothesis_search._fitted_first(problem, Watch(), base, [too_large], too_large)
    assert lost is None or lost.fitted.cost > 0.1 * base.cost


def test_the_likeliest_candidates_are_fitted_whatever_is_done():
    problem, base = refitted(record(effect("cubic-stiffness", coefficient=4.0), noise=0.001))
    spring = ScreenedEffect(effect("cubic-stiffness", coefficient=2.0), gain=500.0, factor=1.0, visible=20.0)
    stop = ScreenedEffect(effect("end-stop", position=1.0, stiffness=5.0), gain=90.0, factor=1.0, visible=20.0)
    spent = Watch(effort=1.0)
    spent.count(SimpleNamespace(seconds=1e9), 1000)
    spent.take_stock()
    screened = [spring, spring, stop]
    assert hypothesis_search._fitted_first(problem, spent, base, screened, spring).fitted.cost < base.cost
    assert hypothesis_search._fitted_first(problem, spent, base, screened, stop) is None
    assert spent.left_out == ["end-stop"]


def test_a_number_that_does_nothing_stays_where_it_is():
    """The lower limit of a clipping that the motion never reaches."""
    recording = record(effect("clipping", low=-50.0, high=1.2), effect("actuator-lag", time_constant=0.008))
    problem, base = refitted(recording, effect("clipping", low=-50.0, high=1.25))
    column = base.packing.names.index("0 low")
    assert np.linalg.norm(base.sensitivities[:, column]) < 1e-9
    assert base.model.effects[0].values["low"] == -50.0
    # A fit that begins with the derivatives of the model without the lag finds it, as with derivatives of its own.
    start = base.model.plus(effect("actuator-lag", time_constant=0.007))
    quick = fit(problem, start, steps=8, base=base, refreshes=0, finest=False)
    assert quick.cost == pytest.approx(fit(problem, start).cost, rel=0.01)


@pytest.mark.slow
def test_what_a_law_lacks_shows_when_what_hid_it_is_found():
    laws = known_effects()["encoder-eccentricity"].finer_laws
    (law,) = laws
    wobble = law(amplitude=0.06, period=0.8, phase=0.4, harmonic="second", harmonic_amplitude=0.02, harmonic_phase=-1.0)
    recording = record(wobble, effect("coulomb-friction", force=0.25), noise=0.001, count=1200)
    plain = effect("encoder-eccentricity", amplitude=0.06, period=0.8, phase=0.4)
    problem, base = refitted(recording, plain, effect("coulomb-friction", force=0.25))
    found = finer_in_place(problem, base)
    assert {type(e) for e in found.model.effects} == {law, known_effects()["coulomb-friction"]}
    assert found.cost < 0.1 * base.cost
    assert finer_in_place(problem, found).cost == pytest.approx(found.cost, rel=1e-3)
    both = camid.diagnose(recording, simulation())
    assert {f.identifier for f in both.findings} == {"encoder-eccentricity", "coulomb-friction"}
    assert any("harmonic" in declared.parameters for declared in both.improved.effects)


def test_detail_shows_in_what_is_white():
    """Along a fast way no reading tells the next one's error, and still a harmonic explains all of them."""
    (law,) = known_effects()["encoder-eccentricity"].finer_laws
    values = {"amplitude": 0.05, "period": 0.8, "phase": 0.4}
    detail = {"harmonic": "second", "harmonic_amplitude": 0.02, "harmonic_phase": -1.0}
    plain = effect("encoder-eccentricity", **values)
    for shape, shows in ((law(**values, **detail), True), (plain, False)):
        problem, base = refitted(record(shape, noise=0.001, count=1200), plain)
        start = base.model.without(0).plus(law(**base.model.effects[0].values, **detail))
        assert may_be_more_than_chance(problem, base, start) == shows


def test_a_lag_is_no_shorter_than_what_differs_from_a_delay():
    problem, base = refitted(record(signal=np.roll(command(), 1)), effect("actuator-lag", time_constant=0.5 * PERIOD))
    assert base.packing.lower[base.packing.names.index("0 time_constant")] * base.packing.units[
        base.packing.names.index("0 time_constant")
    ] == pytest.approx(LEAST_LAG * PERIOD)
    assert base.model.effects[0].values["time_constant"] >= LEAST_LAG * PERIOD
    assert problem.acquisition.period == pytest.approx(PERIOD)


def test_a_knee_that_a_fit_makes_as_sharp_as_it_may_is_a_corner():
    """In its place: what bends a command does so before what follows it."""
    recording = record(effect("saturation", limit=0.8), effect("input-bias", bias=0.2), noise=0.001)
    knee = GradualSaturation(limit=0.85, sharpness=19.0)
    problem, base = refitted(recording, knee, effect("input-bias", bias=0.1))
    assert base.model.effects[0].values["sharpness"] == pytest.approx(20.0, abs=0.01)
    settled = settled_laws(problem, base, 0)
    corner, bias = settled.model.effects
    assert (type(corner), type(bias)) == (known_effects()["saturation"], known_effects()["input-bias"])
    assert corner.values["limit"] == pytest.approx(0.8, abs=0.003)
    assert bias.values["bias"] == pytest.approx(0.2, abs=0.003)
    assert settled.cost < base.cost


def test_detail_of_one_law_may_do_what_another_effect_was_found_for():
    uneven = GradualAsymmetricFriction(forward=0.3, backward=0.2, transition=0.4)
    problem, base = refitted(record(uneven, noise=0.001), GradualCoulombFriction(force=0.25, transition=0.4))
    (best, law), *_ = sorted(finer_instead(problem, base, 0), key=lambda each: each[0].fitted.cost)
    assert type(law) is GradualCoulombFriction
    (found,) = best.fitted.model.effects
    np.testing.assert_allclose(found.vector, uneven.vector, rtol=0.1)
    assert best.fitted.cost < 0.5 * base.cost


def test_a_constant_behind_an_actuator_that_bends_its_input_is_another_one():
    """Where a plant integrates, the constant at its input is estimated with it, and is no effect of the catalogue."""
    table = record(plant=TransferFunction((20.0,), (1.0, 2.0, 0.0)))
    believed = load_simulation(simulation(plant={"transfer_function": {"numerator": [19.0], "denominator": [1, 2, 0]}}))
    recordings, experiments, _ = experiments_of([table], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    model = problem.with_initial_states(model_of(problem, []))
    assert problem.kind.bias_free
    for each, asked in ((None, False), ("saturation", True), ("actuator-lag", False), ("coulomb-friction", False)):
        values = {
            "saturation": {"limit": 0.9},
            "actuator-lag": {"time_constant": 0.1},
            "coulomb-friction": {"force": 0.1},
        }
        beside = model if each is None else model.plus(effect(each, **values[each]))
        assert (problem.kind.unseen_beside(known_effects()["input-bias"], beside) is None) == asked
    assert problem.kind.unseen_beside(known_effects()["delay"], model) == problem.kind.unseen(known_effects()["delay"])
