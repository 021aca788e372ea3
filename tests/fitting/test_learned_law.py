"""A law without a name, fitted with the plant through the whole chain."""

import numpy as np
import pytest

from camid.effects.learned import LearnedForce
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.learned_law import judged_to_first_order, learn
from camid.fitting.possible_laws import blank_laws
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import effect, record, simulation


def refitted(*effects, **changes):
    """Problem of a recording, and the plant re-estimated without the effects."""
    believed = load_simulation(simulation(sensor={"column": "y", "kind": "camera", "offset": 0.0}))
    random = np.random.default_rng(np.random.SeedSequence((changes.get("seed", 1), 3)))
    signal = np.repeat(random.uniform(-1.5, 1.5, 188), 8)[:1500]
    recorded = record(*effects, count=1500, signal=signal, **changes)
    recordings, experiments, _ = experiments_of([recorded], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    return problem, problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))


LAWS = {
    "position": (effect("cubic-stiffness", coefficient=0.02), lambda y: 0.02 * y**3),
    "velocity": (effect("quadratic-drag", coefficient=0.001), lambda v: 0.001 * v * np.abs(v)),
    "input": (effect("saturation", limit=1.2), lambda u: np.clip(u, -1.2, 1.2)),
    "reading": (effect("lens-distortion", k1=0.004), lambda y: y + 0.004 * y**3),
}


@pytest.mark.parametrize("name", LAWS)
def test_the_law_is_found_where_it_is(name):
    concealed, law = LAWS[name]
    problem, base = refitted(concealed)
    laws = blank_laws(problem, base)
    assert set(laws) > set(LAWS)
    first = judged_to_first_order(problem, base, laws)
    assert max(first, key=lambda key: first[key]) == name
    found = learn(problem, base, laws[name])
    assert found.log_evidence - found.without > 20.0
    noise = 0.005**2 * len(base.residual)
    assert (base.cost - found.fitted.cost) / (base.cost - noise) > 0.95
    # A straight line is the plant's; what is left of both curves has to agree.
    knots, heights = found.law.knots, found.law.heights
    difference, inner = heights - law(knots), np.abs(knots) < 0.8 * np.max(np.abs(knots))
    # Straight lines between knots follow a curve to a few per cent of what bends it.
    bend = np.ptp(law(knots) - knots * np.polyfit(knots, law(knots), 1)[0])
    weights = 1.0 / np.maximum(found.deviations, 0.04 * bend)
    line = np.polyval(np.polyfit(knots[inner], difference[inner], 1, w=weights[inner]), knots)
    assert np.mean(np.abs(difference - line)[inner] * weights[inner] < 2.5) > 0.8


def test_a_narrow_law_is_followed_on_more_knots():
    """A fiftieth of the velocities wide: on few knots what is left has a colour."""
    grid = np.linspace(-40.0, 40.0, 401)
    narrow = 0.6 * np.exp(-(((grid - 5.0) / 1.5) ** 2))
    problem, base = refitted(LearnedForce(variables="velocity", knots=grid.tolist(), values=narrow.tolist()))
    law = learn(problem, base, blank_laws(problem, base)["velocity"])
    first = law.fitted
    assert len(first.noise.whitening) > 1
    for _ in range(2):
        before = law
        law = learn(problem, base, law.law.refined(), coarser=law)
        assert law.gain_on(base) > before.gain_on(base)
    assert len(law.fitted.noise.whitening) == 1
    assert law.fitted.cost < 0.05 * first.cost
    assert np.interp(5.0, law.law.knots, law.law.heights) == pytest.approx(0.6, rel=0.15)


def test_there_is_no_law_in_noise():
    problem, base = refitted(seed=4)
    for blank in blank_laws(problem, base).values():
        found = learn(problem, base, blank)
        assert found.log_evidence - found.without < 3.0
        assert found.fitted.cost == pytest.approx(base.cost, rel=0.02)


def test_a_law_beside_the_plant_leaves_its_coefficients_less_certain():
    problem, base = refitted(LAWS["position"][0])
    found = learn(problem, base, blank_laws(problem, base)["position"])
    alone = found.fitted.problem.kind.refit(problem, found.fitted.model)
    with_law, without = (np.sqrt(np.diag(f.covariance))[:3] for f in (found.fitted, alone))
    assert np.all(with_law >= 0.999 * without)
    assert with_law[2] > 1.05 * without[2]
    truth = np.array([100.0, 2.0, 100.0])
    # The stiffness is that of the line through the law; the gain and the damping are the plant's.
    assert np.all(np.abs(found.fitted.model.coefficients - truth)[:2] < 4.0 * with_law[:2])
