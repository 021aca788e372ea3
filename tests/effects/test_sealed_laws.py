"""Effects against the sealed proof's own mechanics: another integrator, and laws that were written independently."""

import numpy as np
import pytest

from camid.chain.exact import sample
from camid.effects import known_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run
from camid.proof.concealed.cases import CATALOGUE, Case
from camid.proof.concealed.drawn_recording import Built, draw_recording

# Strengths other than a fifth of what the machine has of the kind, and the largest error in standard deviations of the
# output: the outflow of a trickle and an edge are smoothed, and a motion over poles is sensitive.
STRENGTHS = {"amplitude-dependent-damping": 1.0, "square-root-outflow": 1.0, "overflow": 0.5, "cogging": 0.03}
ERRORS = {
    "asymmetric-friction": 1e-3,
    "position-dependent-friction": 1e-3,
    "load-dependent-friction": 1e-3,
    "amplitude-dependent-damping": 1e-4,
    "cogging": 2e-3,
    "parallel-mode": 1e-4,
    "square-root-outflow": 5e-3,
    "overflow": 2e-2,
    "encoder-eccentricity": 1e-4,
    "output-backlash": 5e-3,
    "input-quantisation": 1e-4,
}
FRAMES = 300


def machine_with(identity):
    """A machine at rest with the catalogue's law, as it was drawn, and the law with its strength."""
    for index in range(600, 700):
        case = Case(8, index, "several", (identity,))
        draws, effect_draws = (np.random.default_rng(c) for c in np.random.SeedSequence([8, index]).spawn(2))
        draft = draw_recording(case, draws)
        if draft.setup.moving or draft.images:
            continue
        effect = CATALOGUE[identity].law(effect_draws, draft.context(), False)
        return draft, Built(effect, STRENGTHS.get(identity, 0.2), None)
    raise AssertionError(f"no {identity}")


@pytest.mark.parametrize("identity", ERRORS)
def test_the_engine_moves_as_the_machine_does(identity):
    draft, built = machine_with(identity)
    setup = draft.setup_with([built])
    expected = draft.output(setup, draft.command)[:FRAMES]
    signal = draft.recorded(draft.command)[:FRAMES]
    parameters = built.effect.parameters(built.strength)
    effect = known_effects()[identity](**{name: 0.0 if value is None else value for name, value in parameters.items()})
    plant, acquisition = setup.rig.transfer_function(), draft.belief.acquisition
    found = run(Chain(plant, acquisition, (effect,)), signal, setup.period * np.arange(FRAMES))
    spread = np.std(expected)
    error = np.max(np.abs(found - expected)) / spread
    without = np.max(np.abs(sample(plant, signal, acquisition) - expected)) / spread
    assert error < ERRORS[identity]
    assert without > 10.0 * error
