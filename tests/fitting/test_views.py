"""What first guesses are told of a recording: positions as the plant has them, and as the sensor reads them."""

from dataclasses import replace

import numpy as np
import pytest

import camid
from camid.effects.periodic_in_position import Cogging
from camid.effects.sensor_reading import Clipping, SensorOffset
from tests.diagnosis.test_noise_of_uneven_rows import fitted_to
from tests.support.mass_on_spring import effect, record, simulation

COUNT, RATE = 1500, 0.04


def drift():
    return effect("sensor-drift", rate=RATE)


def test_forces_see_the_motion_and_not_what_the_sensor_makes_of_it():
    problem, fitted = fitted_to(record(drift(), count=COUNT, noise=1e-4), drift())
    views, undrifted = problem.situations(fitted.model), record(count=COUNT, noise=0.0)["y"].to_numpy()
    seen, read = views.of(Cogging), views.of(SensorOffset)
    # The exposure is open over a whole period, so that the camera lags behind the motion by half of one.
    half = 0.5 * (seen.position[1:] + seen.position[:-1])
    assert np.std(half - undrifted[1:]) < 0.01 * np.std(undrifted)
    np.testing.assert_allclose(seen.recorded - seen.position, read.recorded - read.position, atol=1e-12)
    slope = np.polyfit(problem.times[0], read.position - seen.position, 1)[0]
    assert slope == pytest.approx(RATE, rel=0.02)


def test_effects_are_guessed_where_the_motion_is_finite():
    """A fit says nothing of the rows behind those that it is made of, and a motion may run away there."""
    problem, fitted = fitted_to(record(count=COUNT))
    whole = problem.situations(fitted.model).of(Clipping)
    assert whole.while_finite() is whole
    away = replace(whole, position=np.where(np.arange(COUNT) < 900, whole.position, np.inf))
    begin = away.while_finite()
    assert [len(each) for each in (begin.time, begin.residual, begin.used)] == [900, 900, 900]
    guesses = [guess.scaled(3.0) for guess in Clipping.candidates(begin)]
    assert np.all(np.isfinite([guess.vector for guess in guesses]))


def test_without_effects_of_the_sensor_forces_see_what_it_reads_from_its_zero():
    problem, fitted = fitted_to(record(count=COUNT))
    views, offset = problem.situations(fitted.model), fitted.model.constants["offset"]
    np.testing.assert_array_equal(views.of(Cogging).position, views.of(SensorOffset).position - offset)


@pytest.mark.slow
def test_a_wave_along_the_way_is_found_beside_a_drift_of_several_of_its_periods():
    cogging = effect("cogging", amplitude=0.04, period=0.25, phase=1.9)
    diagnosis = camid.diagnose(record(cogging, drift(), count=COUNT, noise=0.01, seed=5), simulation())
    assert {f.identifier for f in diagnosis.findings} == {"sensor-drift", "cogging"}
    (period,) = (f.parameters["period"] for f in diagnosis.findings if f.identifier == "cogging")
    assert abs(period.value - 0.25) < 4.0 * period.standard_deviation < 0.02
