"""Forces that act once, where a sum of squares has other minima than the one of the time when they act."""

import pytest

import camid
from camid.diagnosis.search.settled_laws import in_least_minima
from camid.effects.disturbance import ImpulseDisturbance, StepDisturbance
from camid.effects.passing_disturbance import PassingDisturbance
from camid.fitting.fit import fit
from tests.diagnosis.test_noise_of_uneven_rows import fitted_to
from tests.support.mass_on_spring import PERIOD, effect, record, simulation

# Of a mass on a spring of 10 rad/s, half a period.
HALF = 0.314


def test_a_blow_that_was_fitted_half_a_period_away_with_the_other_sign_is_brought_back():
    problem, base = fitted_to(record(ImpulseDisturbance(size=-0.05, time=6.513), noise=0.05))
    away = fit(problem, base.model.plus(ImpulseDisturbance(size=0.04, time=6.513 + HALF)))
    assert away.model.effects[0].values["time"] > 6.513 + 0.5 * HALF
    found = in_least_minima(problem, away, 0)
    assert found.cost < away.cost
    assert found.model.effects[0].values["time"] == pytest.approx(6.513, abs=0.02)
    assert found.model.effects[0].values["size"] == pytest.approx(-0.05, rel=0.1)


@pytest.mark.parametrize("duration", [0.5, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_force_that_passes_is_found_with_its_end(duration):
    passing = PassingDisturbance(size=0.1, time=5.207, duration=duration)
    found = camid.diagnose(record(passing, seed=4), simulation())
    assert [f.identifier for f in found.findings] == ["step-disturbance"]
    assert found.verdict == "explained"
    parameters = found.findings[0].parameters
    for name, value in passing.values.items():
        assert abs(parameters[name].value - value) < 4.0 * parameters[name].standard_deviation
    assert parameters["duration"].standard_deviation < 2.0 * PERIOD


def test_a_force_that_stays_has_no_end():
    found = camid.diagnose(record(StepDisturbance(size=0.1, time=5.207), seed=4), simulation())
    assert [f.identifier for f in found.findings] == ["step-disturbance"]
    assert set(found.findings[0].parameters) == {"size", "time"}


def test_it_acts_from_its_onset_to_its_end():
    law = effect("step-disturbance", size=0.3, time=2.0).with_keys({"duration"})(size=0.3, time=2.0, duration=1.0)
    values = list(law.vector)
    acting = [law.force.at(time, 0.0, 0.0, 0.0, 0.0, values=values) for time in (1.9, 2.0, 2.9, 3.1)]
    assert acting == [0.0, -0.3, -0.3, 0.0]
    assert law.breaks() == (2.0, 3.0)
