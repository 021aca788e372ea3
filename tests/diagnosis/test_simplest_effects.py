"""Where no law is exact: few names, an honest verdict, and a remainder that the next diagnosis knows."""

import numpy as np
import pytest

import camid
from camid.proof.concealed.generator import make, plan
from camid.proof.sealed_files import RECORDING, SIMULATION, write_case
from tests.support import pendulum_and_drive as rigs


@pytest.fixture(scope="module")
def recording():
    """Dry friction that changes along the screw, which no effect of the catalogue does."""
    return rigs.drive(mass=12.0, viscous=30.0, friction=6.0, ripple=0.25, noise=0.05)


@pytest.fixture(scope="module")
def diagnosis(recording):
    return camid.diagnose(recording, rigs.drive_simulation(10.0, 50.0))


def test_no_names_for_what_corrects_the_law(diagnosis):
    """Thousands of samples call for a further effect; friction alone is named, and something is said to be left."""
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]
    assert diagnosis.verdict == "partly-explained"
    assert abs(diagnosis.findings[0].parameters["force"].value - 6.0) < 0.6
    assert any(name == "unlisted" for name, _ in diagnosis.findings[0].alternatives)


def test_remainder_is_the_size_of_what_is_left(recording, diagnosis):
    """On the rows that were fitted, or on the others: the larger."""
    left = diagnosis.signals.recorded - diagnosis.signals.improved
    fitted = diagnosis.signals.fitted
    size = max(np.sqrt(np.mean(left[rows] ** 2)) for rows in (fitted, diagnosis.signals.validates))
    assert diagnosis.improved.remainder == pytest.approx(size, rel=0.02)
    again = camid.diagnose(recording, diagnosis.improved)
    assert again.verdict == "adequate"
    assert "remainder" in again.explanation
    assert again.known_remainder == diagnosis.improved.remainder
    assert diagnosis.known_remainder is None


def test_what_is_beyond_the_remainder_is_looked_for(recording, diagnosis):
    """A blow on the same rig, in another recording of it."""
    struck = recording.copy()
    rows = slice(1500, 1700)
    struck.loc[struck.index[rows], "u"] += 4.0
    assert camid.diagnose(struck, diagnosis.improved).verdict != "adequate"


@pytest.fixture(scope="module")
def loaded_bearing():
    """A pendulum whose dry friction grows with the pull at its bearing, which no effect of the catalogue does."""
    recording = rigs.pendulum(
        natural_frequency=6.0, damping=0.002, rest=0.0, angle=1.6, friction=0.008, load=0.02, count=1000, noise=3e-4
    )
    return recording, rigs.pendulum_simulation(natural_frequency=5.5, damping=0.004, rest=0.0)


@pytest.mark.slow
def test_what_stands_for_the_law_is_modelled_and_not_claimed(loaded_bearing):
    """Its weight is below one half: it acts like drag, and is physics outside the catalogue."""
    diagnosis = camid.diagnose(*loaded_bearing)
    assert [f.identifier for f in diagnosis.findings if f.weight >= 0.5] == ["coulomb-friction"]
    (_, added) = diagnosis.improved.effects
    assert added.identifier in {"quadratic-drag", "amplitude-dependent-damping"}
    assert "physics outside the catalogue, which acts like" in diagnosis.explanation
    assert diagnosis.fit.improved < 0.2 * diagnosis.fit.refitted


def test_what_a_law_at_another_place_cannot_do_is_no_correction_of_it(tmp_path):
    """A gap with soft flanks, which the catalogue's has not, beside gravity, which shows less than what those leave.

    One frame of the rows that judge is far off: it stands out beside whatever is left.
    """
    case = plan(9001, 1000)[638]
    folders = [tmp_path / name for name in ("recordings", "held_out", "truths")]
    write_case(case.index, make(case), *folders)
    own = folders[0] / str(case.index)
    diagnosis = camid.diagnose(own / RECORDING, own / SIMULATION)
    assert {f.identifier for f in diagnosis.findings} == {"backlash", "pendulum-gravity", "outliers"}
