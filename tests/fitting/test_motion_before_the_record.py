"""A recording that begins in motion: what of it has faded before the fitted rows, and what a force remembers of it."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.diagnosis.search.screening import beginnings, signature
from camid.effects import known_effects
from camid.fitting.first_rows import FirstRows
from camid.fitting.fit import evaluate, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import LinearPlant
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from tests.support.runge_kutta import motion

PERIOD, LEAD, COUNT, STEPS = 0.01, 150, 700, 20
STAGE = {"numerator": [280.0], "denominator": [1.0, 80.0, 780.0]}
STRENGTH, SHAPE = 0.6, 1.5


def rig(strength=STRENGTH, noise=0.01, seed=3):
    """A damped stage with hysteresis that is in motion when its record begins: t, u, y and z, by Runge and Kutta."""
    random = np.random.default_rng(np.random.SeedSequence(seed))
    levels = np.repeat(random.choice([-6.0, -3.0, 2.0, 5.0], (LEAD + COUNT) // 10), 10)

    def rates(state, drive):
        position, speed, memory = state
        force = 280.0 * (drive - strength * memory) - 80.0 * speed - 780.0 * position
        loop = SHAPE * (speed - 0.5 * abs(speed) * memory - 0.5 * speed * abs(memory))
        return np.array([speed, force, loop])

    table = motion(rates, levels, PERIOD, STEPS, states=3)[LEAD:]
    y = table[:, 0] + noise * np.std(table[:, 0]) * random.standard_normal(COUNT)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": levels[LEAD:], "y": y, "z": table[:, 2]})


def believed(*effects, **plant):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {**STAGE, **plant}},
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": "estimate",
        "effects": list(effects),
    }


def problem_of(table, left_out):
    structure = Structure.fixed(TransferFunction(tuple(STAGE["numerator"]), tuple(STAGE["denominator"])))
    used = np.arange(len(table)) >= left_out
    experiment = Experiment(
        table["u"].to_numpy(), table["y"].to_numpy(), Acquisition(PERIOD, sensor="instant"), used, True
    )
    return Problem(structure, [experiment], [table["t"].to_numpy()], LinearPlant(), 0.1)


def test_what_has_faded_before_the_fitted_rows_begins_where_the_first_ones_show_it():
    table = rig(strength=0.0)
    problem = problem_of(table, left_out=14)
    model = Model(problem.structure.coefficients())
    start = problem.with_initial_states(model)
    for fitted in (evaluate(problem, start), fit(problem, start)):
        position, _ = problem.motion(fitted.model)[0]
        assert np.max(np.abs(position[:14] - table["y"][:14])) < 0.2 * np.std(table["y"])
        # It costs nothing: the fitted rows leave noise alone.
        assert fitted.cost / len(fitted.residual) < 1.1 * (0.01 * np.std(table["y"])) ** 2


def test_rows_that_say_how_the_motion_began_say_it_alone():
    table = rig(strength=0.0)
    model = Model(problem_of(table, 4).structure.coefficients())
    assert FirstRows.of(problem_of(table, 4), model) is None  # exp(-69 · 0.04)
    first = FirstRows.of(problem_of(table, 14), model)
    assert first.compared.tolist() == [False] * 14 + [True] * (len(table) - 14)
    assert first.weight(np.full(5, 1e-4 * np.std(table["y"]))) == pytest.approx(1e-3, rel=0.02)
    assert first.weight(np.full(5, np.std(table["y"]))) == 0.3


def test_what_a_force_remembers_of_motion_before_the_record_is_estimated():
    table = rig(noise=0.002)
    problem = problem_of(table, 0)
    effect = known_effects()["hysteresis"](strength=STRENGTH, shape=SHAPE)
    start = problem.with_initial_states(Model(problem.structure.coefficients()))
    fitted = fit(problem, start.plus(effect))
    assert fitted.packing.names[-1] == "initial 0 of 0"
    assert abs(table["z"][0]) > 0.3
    assert fitted.model.initial[0][-1] == pytest.approx(table["z"][0], abs=0.05)
    # With none it leaves more.
    at_rest = start.plus(effect)
    assert problem.with_states_of_effects(at_rest).initial[0][-1] == 0.0
    assert fitted.cost < 0.7 * evaluate(problem, at_rest).cost


def test_a_screening_knows_what_an_effect_may_remember():
    table = rig(noise=0.002)
    problem = problem_of(table, 0)
    base = fit(problem, problem.with_initial_states(Model(problem.structure.coefficients())))
    effect = known_effects()["hysteresis"](strength=STRENGTH, shape=SHAPE)
    change = signature(problem, base, effect)
    assert beginnings(problem, base, effect, change).shape == (len(change), 1)
    coulomb = known_effects()["coulomb-friction"](force=STRENGTH)
    assert beginnings(problem, base, coulomb, signature(problem, base, coulomb)) is None


@pytest.mark.slow
def test_hysteresis_of_a_stage_in_motion_is_found_and_simulated():
    table = rig()
    found = camid.diagnose(table[["t", "u", "y"]], believed(numerator=[300.0]))
    (effect,) = found.findings
    assert effect.identifier == "hysteresis"
    # The saturated force may be reached in this record or not: what is certain is the slope of small loops.
    slope = effect.parameters["strength"].value * effect.parameters["shape"].value
    assert slope == pytest.approx(STRENGTH * SHAPE, rel=0.25)
    truth = {"id": "hysteresis", "parameters": {"strength": STRENGTH, "shape": SHAPE}}
    simulated = camid.simulate(table[["t", "u", "y"]], believed(truth))
    assert np.std(simulated["simulated"] - table["y"]) / np.std(table["y"]) < 0.012
