"""A fit simulates only as far as it needs to, and what it compares is the same."""

import numpy as np
import pandas as pd
import pytest

from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation

PERIOD, COUNT = 0.05, 300


def problem_and_model(hold, effects=()):
    random = np.random.default_rng(np.random.SeedSequence(9))
    believed = load_simulation(
        {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": hold},
            "plant": {"transfer_function": {"numerator": [4.0], "denominator": [1.0, 0.5, 4.0]}},
            "sensor": {"column": "y", "kind": "camera"},
        }
    )
    signal = np.convolve(random.standard_normal(COUNT), np.ones(5) / 5.0, "same")
    table = pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": random.standard_normal(COUNT)})
    recordings, experiments, _ = experiments_of([table, table], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    # The last third judges, and of the second recording everything.
    first, second = np.arange(COUNT) < 2 * COUNT // 3, np.zeros(COUNT, bool)
    return problem.with_used([first, second]), problem.with_initial_states(model_of(problem, list(effects)))


@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("hold", ["zoh", "foh", "band-limited"])
def test_fitted_rows_do_not_depend_on_those_that_judge(hold, friction):
    from camid.effects import known_effects

    effects = [known_effects()["coulomb-friction"](force=0.1)] if friction else []
    problem, model = problem_and_model(hold, effects)
    whole = problem.fitted(problem.simulate(model))
    np.testing.assert_allclose(problem.simulate_fitted(model), whole, rtol=0.0, atol=1e-12 * np.std(whole))


def test_an_effect_that_declares_a_band_limited_input_needs_all_of_it():
    from camid.effects import known_effects

    problem, model = problem_and_model("zoh", [known_effects()["input-hold"](hold="band-limited")])
    whole = problem.fitted(problem.simulate(model))
    np.testing.assert_allclose(problem.simulate_fitted(model), whole, rtol=0.0, atol=1e-12 * np.std(whole))
