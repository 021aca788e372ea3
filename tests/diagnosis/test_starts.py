"""The diagnosis does not depend on the coefficients that the user believed in."""

import numpy as np
import pytest

import camid
from tests.support.mass_on_spring import BELIEVED, effect, record, simulation

DRAWS, FEW_DRAWS = 20, 2
SPREAD = (0.5, 1.5)  # of every coefficient
RIGS = {
    "nothing": (),
    "coulomb-friction": (effect("coulomb-friction", force=0.15),),
    "dead-zone": (effect("dead-zone", half_width=0.3),),
    "cubic-stiffness": (effect("cubic-stiffness", coefficient=0.4),),
}


def believed(draw):
    """Coefficients drawn all around, the leading one excepted."""
    factors = np.random.default_rng([31, draw]).uniform(*SPREAD, 3)
    numerator, (one, *denominator) = BELIEVED["numerator"], BELIEVED["denominator"]
    moved = np.array([*numerator, *denominator]) * factors
    return {"numerator": moved[:1].tolist(), "denominator": [one, *moved[1:].tolist()]}


@pytest.mark.parametrize(
    ("name", "draws"),
    [("coulomb-friction", FEW_DRAWS), *(pytest.param(name, DRAWS, marks=pytest.mark.slow) for name in RIGS)],
)
def test_the_diagnosis_is_the_same_from_many_nominal_plants(name, draws):
    recording = record(*RIGS[name])
    found = [
        camid.diagnose(recording, simulation(plant={"transfer_function": believed(draw)})) for draw in range(draws)
    ]
    assert {tuple(f.identifier for f in each.findings) for each in found} == {(name,) if RIGS[name] else ()}
    assert {each.verdict for each in found} == {"explained" if RIGS[name] else "adequate"}
    improved = np.array([each.improved.plant.monic.denominator for each in found])
    np.testing.assert_allclose(improved, np.broadcast_to(improved[0], improved.shape), rtol=2e-3)
