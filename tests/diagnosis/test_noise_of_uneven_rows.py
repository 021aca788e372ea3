"""Rows weigh as much as they say where times that scatter make the noise of a fast motion larger than a slow one's."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

import camid
from camid.diagnosis.residual.uneven_noise import relative_noise, with_rate_of_reading
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.unseen import WHY_INTERPOLATED
from camid.identification.from_recordings import experiments_of, load_recordings
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import PERIOD, effect, record, simulation

COUNT, NOISE = 2000, 0.002
PLAIN = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [60.0], "denominator": [1.0, 4.0, 70.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def jittered(*effects, jitter, seed, noise=NOISE, count=COUNT, command_seed=1):
    """A recording with frames that come early or late, to second order in time, in seconds."""
    step = 0.02 * PERIOD
    options = {"count": count, "seed": command_seed, "noise": 0.0}
    tables = [record(*effects, latency=latency, **options) for latency in (0.0, step, 2 * step)]
    now, earlier, earliest = (table["y"].to_numpy() for table in tables)
    rate, bend = (3.0 * now - 4.0 * earlier + earliest) / (2.0 * step), (now - 2.0 * earlier + earliest) / step**2
    random = np.random.default_rng(seed)
    times = jitter * random.standard_normal(count)
    output = now + times * rate + 0.5 * times**2 * bend + noise * random.standard_normal(count)
    return tables[0].assign(y=output)


def fitted_to(table, *effects):
    """The simulation with some effects, re-estimated, and its problem."""
    believed = load_simulation(simulation())
    recordings, experiments, _ = experiments_of([table], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    return problem, problem.kind.refit(problem, problem.with_initial_states(model_of(problem, list(effects))))


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_friction_that_shows_where_the_motion_is_slow_is_found_beside_jitter(seed):
    table = jittered(effect("coulomb-friction", force=0.004), jitter=0.2 * PERIOD, seed=seed)
    diagnosis = camid.diagnose(table, simulation())
    assert {f.identifier for f in diagnosis.findings} == {"coulomb-friction", "timestamp-jitter"}
    (friction,) = (f.parameters["force"] for f in diagnosis.findings if f.identifier == "coulomb-friction")
    assert abs(friction.value - 0.004) < 3.0 * friction.standard_deviation
    # With all rows alike it is three times as large.
    assert friction.standard_deviation < 0.0007
    other = jittered(effect("coulomb-friction", force=0.004), jitter=0.2 * PERIOD, seed=seed + 10)
    assert camid.diagnose(other, diagnosis.improved.to_mapping()).verdict == "adequate"


@pytest.mark.slow
def test_the_rows_of_several_recordings_are_weighed_by_their_own_noise():
    friction, jitter = effect("coulomb-friction", force=0.004), 0.2 * PERIOD
    tables = [jittered(friction, jitter=jitter, seed=seed, count=1200, command_seed=seed) for seed in (3, 4)]
    diagnosis = camid.diagnose(tables, simulation())
    assert {f.identifier for f in diagnosis.findings} == {"coulomb-friction", "timestamp-jitter"}


def test_jitter_is_named_beside_noise_that_has_a_colour():
    table = jittered(jitter=0.1 * PERIOD, noise=0.0, seed=4)
    random = np.random.default_rng(6)
    colour = lfilter([0.02], [1.0, -0.8], random.standard_normal(COUNT))
    diagnosis = camid.diagnose(table.assign(y=table["y"] + colour), simulation())
    assert {f.identifier for f in diagnosis.findings} == {"timestamp-jitter", "coloured-noise"}
    assert not diagnosis.structured


@pytest.mark.parametrize("jitter", [0.02, 0.1])
def test_the_noise_is_as_uneven_as_jitter_makes_it(jitter):
    jitter *= PERIOD
    table, still = jittered(jitter=jitter, seed=5), jittered(jitter=0.0, noise=0.0, seed=5)["y"].to_numpy()
    problem, fitted = fitted_to(table)
    (found,) = relative_noise(problem, fitted)
    expected = np.sqrt(NOISE**2 + (jitter * np.gradient(still, PERIOD)) ** 2)
    expected /= np.sqrt(np.mean(expected**2))
    assert np.mean(found**2) == pytest.approx(1.0)
    assert np.corrcoef(np.log(found), np.log(expected))[0, 1] > 0.9


def test_noise_that_is_even_or_hardly_uneven_is_taken_for_even():
    for jitter in (0.0, 0.005):
        assert relative_noise(*fitted_to(jittered(jitter=jitter * PERIOD, seed=5))) is None


def test_structure_that_grows_with_the_speed_is_no_uneven_noise():
    """Its square grows with that of the speed, too, but it goes on from frame to frame."""
    table = record(effect("quadratic-drag", coefficient=0.5), count=COUNT, noise=NOISE)
    assert relative_noise(*fitted_to(table)) is None


def test_times_that_scatter_so_far_that_the_mean_of_the_readings_bends_are_left_out_of_account():
    assert relative_noise(*fitted_to(jittered(jitter=2.0 * PERIOD, seed=5))) is None


def test_rows_are_compared_over_their_noise_and_errors_with_them():
    problem, fitted = fitted_to(jittered(jitter=0.1 * PERIOD, seed=5))
    (noise,) = relative_noise(problem, fitted)
    weighed = replace(problem, relative_noise=(noise,))
    rows = problem.experiments[0].used
    assert weighed.output == pytest.approx(problem.output / noise[rows])
    assert weighed.in_units(weighed.output) == pytest.approx(problem.output)
    simulated = weighed.simulate_fitted(fitted.model)
    assert simulated == pytest.approx(problem.simulate_fitted(fitted.model) / noise[rows])
    errors = weighed.errors(fitted.model, [rows])
    assert errors == pytest.approx(weighed.output - simulated)
    assert relative_noise(weighed, fitted) is None


def test_jitter_that_one_recording_seems_to_show_is_refuted_by_a_faster_one():
    slow, fast = jittered(jitter=0.2 * PERIOD, seed=8), jittered(jitter=0.0, seed=9, count=1500, command_seed=2)
    believed = load_simulation(simulation())
    for second, refuted in ((fast, True), (jittered(jitter=0.2 * PERIOD, seed=9, count=1500, command_seed=2), False)):
        recordings, experiments, _ = experiments_of([slow, second], believed, None)
        problem = problem_of(believed, structure_of(believed), recordings, experiments)
        fitted = problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))
        assert (relative_noise(problem, fitted) is None) == refuted


def resampled(steps, seed=0):
    """Noisy positions of a mass on a spring that a force moves at 1.1 Hz, in rows that lie so many seconds apart."""
    random = np.random.default_rng(seed)
    time = np.concatenate([[0.0], np.cumsum(steps)])
    frequency = 7.0j
    motion = 60.0 / (frequency**2 + 4.0 * frequency + 70.0) * np.exp(frequency * time)
    output = motion.imag + 0.02 * random.standard_normal(len(time))
    return pd.DataFrame({"t": time, "u": np.sin(7.0 * time), "y": output})


def test_readings_between_irregular_times_have_a_colour_that_the_sensor_has_not():
    random = np.random.default_rng(1)
    wandering = resampled(0.02 + 0.003 * random.uniform(-1.7, 1.7, 1500))
    (recording,) = load_recordings(wandering, load_simulation(PLAIN), output_needed=True)
    assert recording.interpolated
    missing = resampled(np.where(random.uniform(size=600) < 0.1, 0.04, 0.02)).assign(u=0.0)
    decay = load_simulation(PLAIN | {"input": None, "initial_state": "estimate"})
    (recording,) = load_recordings(missing, decay, output_needed=True)
    assert not recording.interpolated
    plain = PLAIN | {"input": {"column": "u", "hold": "foh"}, "initial_state": "estimate"}
    found = camid.diagnose(wandering, plain)
    assert found.verdict == "adequate"
    (unseen,) = [each for each in found.undetectable if each.identifier == "coloured-noise"]
    assert unseen.reason == WHY_INTERPOLATED


def test_a_latency_says_no_rate_where_an_observer_pulls():
    """It moves the motion itself there, and may drive it away."""
    believed = load_simulation(simulation(observer={"rate": 3.0}, initial_state="estimate"))
    recordings, experiments, _ = experiments_of([record(count=300)], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    model = problem.with_initial_states(model_of(problem, []))
    assert problem.chain(model, 0).pull is not None
    found = with_rate_of_reading(problem, model, 0)
    np.testing.assert_array_equal(found.velocity, problem.situation(model, 0).velocity)
