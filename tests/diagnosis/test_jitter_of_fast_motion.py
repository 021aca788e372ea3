"""Jitter of the time stamps where the motion turns round within a few frames."""

import numpy as np

import camid
from camid.chain.plant import TransferFunction
from camid.diagnosis.residual import mismatch_location
from camid.diagnosis.residual.mismatch_location import places
from camid.diagnosis.residual.uneven_noise import uneven_spread
from camid.effects import known_effects
from camid.fitting.fit import evaluate
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import PERIOD, record, simulation

# A resonance of five frames a turn.
PLANT = TransferFunction((3900.0,), (1.0, 4.0, 3900.0))
BELIEVED = {"transfer_function": {"numerator": [3900.0], "denominator": [1.0, 4.0, 3900.0]}}
COUNT, JITTER = 3000, 0.05 * PERIOD


def test_jitter_of_a_fast_motion_is_not_overestimated():
    step = 1e-3 * PERIOD
    recording, earlier = (
        record(count=COUNT, noise=0.0, plant=PLANT, latency=latency)["y"].to_numpy() for latency in (0.0, step)
    )
    rate = (recording - earlier) / step
    random = np.random.default_rng(11)
    output = recording + JITTER * random.standard_normal(COUNT) * rate + 0.01 * random.standard_normal(COUNT)
    table = record(count=COUNT, noise=0.0, plant=PLANT).assign(y=output)
    diagnosis = camid.diagnose(table, simulation(plant=BELIEVED))
    (found,) = (f.parameters["std"] for f in diagnosis.findings if f.identifier == "timestamp-jitter")
    assert abs(found.value - JITTER) < 2.5 * found.standard_deviation


def test_what_large_jitter_does_to_the_mean_of_a_bent_motion_is_no_structure(monkeypatch):
    """Times that scatter lower the peaks of a swing: by half of their variance times its second derivative."""
    step, jitter = 0.02 * PERIOD, 0.3 * PERIOD
    now, earlier, earliest = (
        record(count=COUNT, noise=0.0, plant=PLANT, latency=latency)["y"].to_numpy()
        for latency in (0.0, step, 2 * step)
    )
    rate, bend = (now - earlier) / step, (now - 2.0 * earlier + earliest) / step**2
    random = np.random.default_rng(12)
    times = jitter * random.standard_normal(COUNT)
    output = now + times * rate + 0.5 * times**2 * bend + 0.01 * random.standard_normal(COUNT)
    believed = load_simulation(simulation(plant=BELIEVED))
    tables = [record(count=COUNT, noise=0.0, plant=PLANT).assign(y=output)]
    recordings, experiments, _ = experiments_of(tables, believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    # The true plant, so that no coefficient takes any of it.
    fitted = evaluate(problem, problem.with_initial_states(model_of(problem, [])))
    spread = uneven_spread(problem, fitted, [known_effects()["timestamp-jitter"](std=jitter)])
    with_it = {test.place: test.p_value for test in places(problem, fitted, spread)}
    nothing = lambda problem, fitted, motions: np.zeros((len(fitted.residual), 1))  # noqa: E731
    monkeypatch.setattr(mismatch_location, "_bend_of_the_reading", nothing)
    without = {test.place: test.p_value for test in places(problem, fitted, spread)}
    assert without["sensor"] < 1e-6
    assert min(with_it.values()) > 1e-3
