"""Where no law is exact: few names, an honest verdict, and a remainder that the next diagnosis knows."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import camid
from camid.diagnosis import decided
from camid.proof.concealed.generator import make, plan
from camid.proof.sealed_files import RECORDING, SIMULATION, write_case
from tests.support import pendulum_and_drive as rigs
from tests.support.mass_on_spring import effect, record, simulation
from tests.support.runge_kutta import positions


@pytest.fixture(scope="module")
def recording():
    """Dry friction that changes along the screw, which no effect of the catalogue does."""
    return rigs.drive(mass=12.0, viscous=30.0, friction=6.0, ripple=0.25, noise=0.05)


@pytest.fixture(scope="module")
def diagnosis(recording):
    return camid.diagnose(recording, rigs.drive_simulation(10.0, 50.0))


@pytest.mark.slow
def test_no_names_for_what_corrects_the_law(diagnosis):
    """Thousands of samples call for a further effect; friction alone is named, and something is said to be left."""
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]
    assert diagnosis.verdict == "partly-explained"
    assert abs(diagnosis.findings[0].parameters["force"].value - 6.0) < 0.6
    assert any(name == "unlisted" for name, _ in diagnosis.findings[0].alternatives)


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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


ROWS, PERIOD, DRIFT, SETTLES = 3000, 0.005, 0.5, 5.0


def buffered(seed):
    """Positions in mm of a mass on leaf springs that meets a rubber buffer, seen by a laser that warms up.

    The buffer's force grows without bound towards a depth of 4 mm, as none of the catalogue's does.
    """
    random = np.random.default_rng([91, seed])
    time = PERIOD * np.arange(ROWS)
    tones = zip(random.uniform(0.5, 5.0, 12), random.uniform(0.0, 2.0 * np.pi, 12), strict=True)
    signal = 0.35 * np.sum([np.sin(2.0 * np.pi * tone * time + phase) for tone, phase in tones], axis=0)

    def rate(state, drive):
        depth = max(state[0] - 2.5, 0.0)
        pushed = 3.2 * depth / (1.0 - min(depth, 3.99) / 4.0) * max(1.0 + 0.004 * state[1], 0.0)
        return np.array([state[1], 835.0 * (drive - pushed) - 2.3 * state[1] - 379.0 * state[0]])

    found = positions(rate, signal, PERIOD, 4)
    drift = DRIFT * (1.0 - np.exp(-time / SETTLES))
    noise = 0.004 * np.std(found) * random.standard_normal(ROWS)
    return pd.DataFrame({"t": time, "u": signal, "y": found + drift + noise})


@pytest.mark.slow
def test_a_drift_corrects_no_law_of_the_plant():
    """It explains a thousandth of the mismatch, and most of what a stop that is not exact leaves."""
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [1000.0], "denominator": [1.0, 1.6, 450.0]}},
        "sensor": {"column": "y", "kind": "instant"},
    }
    diagnosis = camid.diagnose(buffered(1), nominal)
    assert {"end-stop", "sensor-drift"} <= {finding.identifier for finding in diagnosis.findings}
    drift = next(f for f in diagnosis.findings if f.identifier == "sensor-drift")
    assert drift.parameters["rate"].value == pytest.approx(DRIFT / SETTLES, rel=0.1)


def test_two_laws_that_turn_into_each_other_end(monkeypatch):
    """What took the place of a law of impossible values may be stretched to it again, for ever."""
    rounds = []

    def another(problem, decision, *_):
        rounds.append(decision)
        return replace(decision)

    monkeypatch.setattr(decided, "without_wandered", another)
    monkeypatch.setattr(decided, "_wandered", lambda setting, model: set(range(len(model.effects))))
    diagnosis = camid.diagnose(record(effect("coulomb-friction", force=0.02)), simulation(), time_limit=None)
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]
    assert len(rounds) == decided.MOST_REPLACED + 1
