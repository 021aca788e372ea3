"""Noise with heavy tails is no outliers: they are not named, and what lies far out is left out and said to be."""

import numpy as np
import pytest

import camid
from tests.support.mass_on_spring import record, simulation

COUNT, SPREAD = 1500, 0.005


def recording(seed, *, struck=0):
    """Of the mass on its spring, with noise of a Student distribution, or Gaussian with some rows struck."""
    table, generator = record(count=COUNT, noise=0.0), np.random.default_rng([41, seed])
    noise = generator.standard_t(4.0, COUNT) if not struck else generator.normal(size=COUNT)
    rows = generator.choice(COUNT, struck, replace=False)
    noise[rows] += 15.0 * generator.choice([-1.0, 1.0], struck)
    return table.assign(y=table["y"] + SPREAD * noise)


def left_out(diagnosis):
    """Warnings of readings that do not count."""
    return [w for w in diagnosis.warnings if "may be outliers" in w]


@pytest.mark.parametrize("seed", range(3))
def test_tails_are_no_outliers(seed):
    diagnosis = camid.diagnose(recording(seed), simulation())
    assert (diagnosis.verdict, diagnosis.findings) == ("adequate", [])
    (warning,) = left_out(diagnosis)
    count = int(warning.split()[0])
    assert 3 < count < 0.05 * COUNT
    assert "does not suffice to name outliers" in warning


def test_outliers_are_named_and_need_no_warning():
    table = recording(0, struck=12)
    diagnosis = camid.diagnose(table, simulation())
    (found,) = diagnosis.findings
    assert found.identifier == "outliers"
    assert found.evidence["false_alarm_probability"] < 0.05
    assert left_out(diagnosis) == []
    # Nor where the simulation declares them.
    again = camid.diagnose(table, diagnosis.improved.to_mapping())
    assert (again.verdict, left_out(again)) == ("adequate", [])
