"""What a recording can have bounds what an effect can be: an exposure is at most the period."""

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.effects import known_effects
from camid.effects.modes import FASTEST
from camid.fitting.covariance import effect_deviations
from camid.fitting.fit import fit
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import PERIOD, effect, record, simulation

CAMERA = Acquisition(PERIOD, "zoh", "camera", 0.5 * PERIOD)


@pytest.mark.parametrize("identifier", [name for name, kind in known_effects().items() if not kind.noise_like])
def test_bounds_hold_those_of_the_parameters(identifier):
    kind = known_effects()[identifier]
    numeric = kind.numeric()
    given = [p for p in kind.parameters if p.default is None]
    values = {p.name: p.choices[0] if p.choices else np.clip(1.0, p.lower, p.upper) for p in given}
    bounds = kind(**values).bounds(CAMERA)
    assert len(bounds) == len(numeric)
    assert all(p.lower <= low <= high <= p.upper for p, (low, high) in zip(numeric, bounds, strict=True))


def test_an_exposure_is_at_most_the_period():
    long = effect("exposure", exposure=3.0 * PERIOD)
    assert long.within(CAMERA).values == {"exposure": PERIOD}
    assert effect("exposure", exposure=0.3 * PERIOD).within(CAMERA).values == {"exposure": 0.3 * PERIOD}


def test_a_fit_that_wants_a_longer_exposure_ends_at_the_period_with_a_deviation():
    """A latency that is not declared looks like a longer exposure."""
    recorded = record(latency=1.5 * PERIOD, count=300)
    believed = load_simulation(simulation(sensor={"column": "y", "kind": "camera", "exposure": 0.5 * PERIOD}))
    recordings, experiments, _ = experiments_of(recorded, believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    found = fit(problem, model_of(problem, [effect("exposure", exposure=0.8 * PERIOD)]))
    assert found.model.effects[-1].values["exposure"] == pytest.approx(PERIOD, rel=1e-3)
    assert found.model.effects[-1].values["exposure"] <= PERIOD
    deviation = effect_deviations(found)[-1]["exposure"]
    assert deviation is not None
    assert 0.0 < deviation < PERIOD


@pytest.mark.parametrize("identifier", ["extra-mode", "parallel-mode"])
def test_no_mode_far_beyond_the_frames_is_fitted(identifier):
    """What of it shows is a delay, a lag or a gain; one that is declared so fast stays what it is."""
    gain = {"gain": 1.0} if identifier == "parallel-mode" else {}
    place = [parameter.name for parameter in known_effects()[identifier].numeric()].index("natural_frequency")
    for rate, fastest in ((30.0, FASTEST * np.pi / PERIOD), (1e6, 1e6)):
        law = effect(identifier, natural_frequency=rate, damping=0.1, **gain)
        assert law.bounds(CAMERA)[place][1] == pytest.approx(fastest)
