"""What is stated of the accuracy of numbers whose law has an edge."""

from dataclasses import replace

import numpy as np
import pytest

from camid.fitting.fit import evaluate
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.output_error import DIFFERENCE_STEP
from camid.fitting.problem import Problem
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import effect, record, simulation

BIAS = 0.2


def biased():
    believed = load_simulation(simulation())
    recordings, experiments, _ = experiments_of([record(effect("input-bias", bias=BIAS))], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    return problem.kind.refit(
        problem, problem.with_initial_states(model_of(problem, [effect("input-bias", bias=BIAS)]))
    )


def deviation_of_the_bias(fitted):
    place = fitted.packing.names.index("0 bias")
    return float(np.sqrt(fitted.covariance[place, place]))


@pytest.mark.parametrize("steepness", [1.0, 5.0])
def test_it_is_that_over_its_own_width(monkeypatch, steepness):
    """An output that goes in teeth with a parameter is as sure of it as the line through them.

    As an integrator's is that meets an edge in one of its steps: between two of them it is steeper, and then jumps.
    """
    fitted = biased()
    expected = deviation_of_the_bias(fitted)
    simulate, tooth = Problem.simulate_fitted, 4.0 * DIFFERENCE_STEP * BIAS

    def in_teeth(self, model):
        (bias,) = model.effects
        (value,) = bias.vector
        beyond = value - fitted.model.effects[0].vector[0]
        teeth = value + (steepness - 1.0) * (beyond - tooth * np.floor(beyond / tooth + 0.5))
        return simulate(self, replace(model, effects=(effect("input-bias", bias=float(teeth)),)))

    monkeypatch.setattr(Problem, "simulate_fitted", in_teeth)
    again = evaluate(fitted.problem, fitted.model)
    local = np.linalg.norm(again.sensitivities[:, again.packing.names.index("0 bias")])
    smooth = np.linalg.norm(fitted.sensitivities[:, fitted.packing.names.index("0 bias")])
    assert local == pytest.approx(steepness * smooth, rel=1e-3)
    assert deviation_of_the_bias(again) == pytest.approx(expected, rel=0.1)
