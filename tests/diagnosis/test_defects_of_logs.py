"""What goes wrong where input and reading are logged: rows that do not belong together, wires that couple, gains that
flicker, and times that are printed."""

import numpy as np
import pytest

import camid
from camid.effects.modes import ExtraMode
from camid.effects.rows_of_the_log import noise_of_command
from tests.support.mass_on_spring import PERIOD, record, simulation

INSTANT = {"column": "y", "kind": "instant"}


def diagnosed(table):
    return camid.diagnose(table, simulation(sensor=INSTANT))


def parameter_of(diagnosis, identifier):
    """The only parameter of the only finding."""
    (finding,) = diagnosis.findings
    assert finding.identifier == identifier
    (value,) = finding.parameters.values()
    return value


@pytest.mark.parametrize("rows", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_a_command_that_is_logged_late_is_told_from_a_mode(rows):
    table = record(noise=0.002, sensor="instant")
    signal = table["u"].to_numpy()
    late = table.assign(u=np.concatenate([np.zeros(rows), signal[:-rows]]))
    found = diagnosed(late)
    lead = parameter_of(found, "late-command")
    assert abs(lead.value - rows * PERIOD) < 4.0 * lead.standard_deviation
    # The improved simulation knows how late.
    assert camid.diagnose(late, found.improved.to_mapping()).verdict == "adequate"


@pytest.mark.parametrize("before", [0, 1])
def test_a_command_that_couples_into_the_reading_is_told_from_the_plant(before):
    table = record(noise=0.002, sensor="instant")
    picked = 0.08 * np.concatenate([np.zeros(before), table["u"].to_numpy()])[: len(table)]
    found = diagnosed(table.assign(y=table["y"] + picked))
    (finding,) = found.findings
    assert finding.identifier == "input-pickup"
    coefficient = finding.parameters["coefficient"]
    assert abs(coefficient.value - 0.08) < 4.0 * coefficient.standard_deviation
    assert ("row" in finding.parameters) == (before == 1)


def test_a_sequence_of_few_levels_may_be_picked_up_however_often_it_switches():
    """What switches in every row is no controller's answer to noise."""
    random = np.random.default_rng(12)
    command = random.choice([-1.0, -0.4, 0.3, 0.9], 1200)
    table = record(noise=0.002, sensor="instant", count=1200, signal=command)
    coefficient = parameter_of(diagnosed(table.assign(y=table["y"] + 0.03 * table["u"])), "input-pickup")
    assert abs(coefficient.value - 0.03) < 4.0 * coefficient.standard_deviation


def test_a_hum_that_is_no_sine_is_one_hum():
    table = record(noise=0.002, sensor="instant", count=1500)
    time = table["t"].to_numpy()
    hum = 0.05 * np.sin(21.0 * time + 0.4) + 0.012 * np.sin(42.0 * time + 2.0)
    (finding,) = diagnosed(table.assign(y=table["y"] + hum)).findings
    assert finding.identifier == "sensor-oscillation"
    for name, true in (("amplitude", 0.05), ("frequency", 21.0), ("harmonic_amplitude", 0.012)):
        found = finding.parameters[name]
        assert abs(found.value - true) < 4.0 * found.standard_deviation


def test_noise_in_proportion_to_the_reading_is_no_physics():
    table = record(noise=0.0, sensor="instant", count=1500)
    random = np.random.default_rng(8)
    reading = 1.5 + table["y"].to_numpy().copy()
    found = diagnosed(table.assign(y=reading * (1.0 + 0.02 * random.standard_normal(len(reading)))))
    share = parameter_of(found, "multiplicative-noise")
    assert abs(share.value - 0.02) < 4.0 * share.standard_deviation
    assert found.verdict == "explained"
    assert not found.structured


def test_noise_that_becomes_louder_strikes_no_outliers():
    table = record(noise=0.0, sensor="instant", count=1500)
    random = np.random.default_rng(9)
    spread = np.where(table["t"] < 0.5 * table["t"].iloc[-1], 0.003, 0.015)
    louder = table.assign(y=table["y"] + spread * random.standard_normal(len(table)))
    assert diagnosed(louder).findings == []
    struck = louder["y"].to_numpy().copy()
    struck[50:700:60] += 0.2
    assert [f.identifier for f in diagnosed(louder.assign(y=struck)).findings] == ["outliers"]


def test_frames_that_repeat_are_found_among_times_of_nine_digits():
    """Such times are not exactly even, and readings that were interpolated would not repeat."""
    table = record(noise=0.003, sensor="instant", count=1200)
    random = np.random.default_rng(10)
    reading = table["y"].to_numpy().copy()
    for row in np.flatnonzero(random.random(len(table)) < 0.05)[1:]:
        reading[row] = reading[row - 1]
    scale = 0.05 / 3.0 / PERIOD  # sixty frames a second
    table = table.assign(y=reading, t=[float(f"{scale * t:.9g}") for t in table["t"]])
    found = camid.diagnose(table, simulation(sensor=INSTANT))
    assert "dropped-frames" in {f.identifier for f in found.findings}
    assert "outliers" not in {f.identifier for f in found.findings}


def test_readings_far_off_beside_a_mode_that_hides_them_are_no_blows():
    """What the mode leaves is larger than they are, but lasts for several frames."""
    table = record(ExtraMode(natural_frequency=31.0, damping=0.03), noise=0.003, sensor="instant", count=2000)
    random = np.random.default_rng(21)
    struck = np.sort(random.choice(np.arange(20, 2000), 25, replace=False))
    far = random.choice([-1.0, 1.0], 25) * random.uniform(0.12, 0.6, 25)
    table.loc[struck, "y"] += far
    found = diagnosed(table)
    assert {f.identifier for f in found.findings} == {"extra-mode", "outliers"}
    outliers = next(f for f in found.findings if f.identifier == "outliers")
    # No structure has single readings so far from all others.
    assert outliers.weight == 1.0
    fraction = outliers.parameters["fraction"]
    assert abs(fraction.value - 25 / 2000) < 3.0 * fraction.standard_deviation


@pytest.mark.parametrize("rows", [2, 64, 511, 512, 540, 575, 576, 700, 1100])
def test_the_noise_of_a_command_is_known_of_any_number_of_rows(rows):
    noise = np.random.default_rng(rows).standard_normal(rows)
    assert 0.0 <= noise_of_command(noise) < 5.0
