"""The simulation as given errs as much as ``camid simulate`` shows."""

import numpy as np

import camid
from camid.chain.plant import TransferFunction
from tests.support.mass_on_spring import PERIOD, effect, record

SWING = TransferFunction((1.0,), (1.0, 0.12, 16.8))
AMPLITUDE = 300.0


def test_a_decay_with_a_declared_effect_begins_as_it_is_simulated():
    """The motion never forgets where it began, and the state that suits the plant without the effect is another."""
    gravity = effect("pendulum-gravity", amplitude=AMPLITUDE)
    state = np.array([0.0, 3600.0])
    table = record(gravity, plant=SWING, state=state, signal=np.zeros(500), count=500, noise=0.3)
    simulation = {
        "schema": 1,
        "time": {"column": "t"},
        "input": None,
        "plant": {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 0.12, 16.8]}},
        "sensor": {"column": "y", "kind": "camera", "exposure": PERIOD},
        "initial_state": "estimate",
        "effects": [{"id": "pendulum-gravity", "parameters": {"amplitude": AMPLITUDE}}],
    }
    simulated = camid.simulate(table, simulation)
    diagnosis = camid.diagnose(table, simulation)
    held_out = diagnosis.signals.validates
    left = (table["y"] - simulated["simulated"])[held_out]
    assert np.ptp(table["y"]) > AMPLITUDE
    expected = np.sqrt(np.mean(left**2)) / np.std(table["y"][held_out])
    assert diagnosis.fit.nominal < 1.1 * expected
    np.testing.assert_allclose(diagnosis.signals.nominal, simulated["simulated"], atol=1.0)
