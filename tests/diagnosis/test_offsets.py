"""A sensor whose zero lies far from the motion, as that of a camera that counts pixels from the corner."""

import numpy as np
import pytest

import camid
from camid.proof.concealed.generator import make, plan
from tests.support.mass_on_spring import effect, record, simulation

SEED, RIGS = 31337, 200


def said(diagnosis):
    return diagnosis.verdict, sorted(f.identifier for f in diagnosis.findings)


@pytest.mark.slow
def test_an_offset_of_thousands_of_standard_deviations_hides_no_effect():
    recording = record(effect("cubic-stiffness", coefficient=0.3))
    shifted = recording.assign(y=recording["y"] - 6000.0 * np.std(recording["y"]))
    first, second = (camid.diagnose(table, simulation()) for table in (recording, shifted))
    assert said(first) == said(second) == ("explained", ["cubic-stiffness"])
    assert second.fit.improved == pytest.approx(first.fit.improved, rel=1e-4)
    one, other = (d.findings[0].parameters["coefficient"] for d in (first, second))
    assert other.value == pytest.approx(one.value, rel=1e-3)
    assert other.standard_deviation == pytest.approx(one.standard_deviation, rel=1e-2)


def coefficients(result):
    plant = result.simulation.plant.monic
    return np.array([*plant.numerator, *plant.denominator[1:]])


@pytest.mark.slow
def test_two_hundred_rigs_with_offsets_up_to_ten_thousand_standard_deviations():
    """Made by the code of the sealed proof, which shares nothing with the tool; each diagnosed with and without one."""
    draws = np.random.default_rng(SEED)
    sizes = np.where(draws.random(RIGS) < 0.1, 0.0, 10.0 ** draws.uniform(-1.0, 4.0, RIGS))
    sizes *= draws.choice([-1.0, 1.0], RIGS)
    errors, otherwise = [], []
    for case, size in zip(plan(SEED, RIGS), sizes, strict=True):
        concealed = make(case)
        concealed.simulation["sensor"].pop("offset", None)
        plain = concealed.recording
        shifted = plain.assign(y=plain["y"] + size * np.std(plain["y"]))
        first, second = (camid.diagnose(table, concealed.simulation, time_limit=None) for table in (plain, shifted))
        if said(first) != said(second):
            otherwise.append((case, size, said(first), said(second)))
            continue
        assert second.fit.improved == pytest.approx(first.fit.improved, rel=0.02), (case, size)
        if case.kind == "none":
            results = [camid.identify(table, concealed.simulation) for table in (plain, shifted)]
            estimates = [coefficients(r) for r in results]
            np.testing.assert_allclose(estimates[1], estimates[0], rtol=1e-6)
            truth = concealed.truth["plant"]
            true = np.array([*truth["numerator"], *truth["denominator"][1:]])
            errors.append((estimates[1] - true) / results[1].estimate.standard_deviations)
    # Where two names explain the same, the digits that an offset costs may turn the scales.
    assert len(otherwise) <= 2, otherwise
    # The stated standard deviations are those of the Cramér–Rao bound at the estimate (tests/identification).
    assert 0.85 < np.sqrt(np.mean(np.square(errors))) < 1.15
