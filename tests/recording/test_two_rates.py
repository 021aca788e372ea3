"""Frames with times of their own: what is read of them, and what is refused in one line."""

import numpy as np
import pandas as pd
import pytest

from camid.errors import InputError
from camid.identification.from_recordings import load_recordings
from camid.simulation.file import load_simulation
from tests.support.two_rates import SIMULATION, two_rates


def simulation(**parts):
    content = {**SIMULATION, **{k: v for k, v in parts.items() if k != "sensor"}}
    return load_simulation({**content, "sensor": {**SIMULATION["sensor"], **parts.get("sensor", {})}})


def read(table, **parts):
    (found,) = load_recordings(table, simulation(**parts), output_needed=True)
    return found


def test_rows_are_frames_and_the_input_keeps_its_samples():
    table = two_rates()
    frames = table["frame"].dropna().to_numpy()
    found = read(table, initial_state="estimate")
    np.testing.assert_allclose(found.time, frames)
    assert found.period == pytest.approx(1.0 / 47.3)
    np.testing.assert_array_equal(found.columns["y"], table["y"].dropna())
    np.testing.assert_array_equal(found.logs["u"].time, table["t"])
    np.testing.assert_array_equal(found.logs["u"].values, table["u"])
    assert not found.missing.any()
    assert found.warnings == ()


def test_a_rig_at_rest_is_simulated_from_where_the_log_begins():
    table = two_rates()
    found = read(table)
    assert found.time[0] <= 0.0 < found.time[1]
    assert np.count_nonzero(found.missing) == np.count_nonzero(found.time < 0.3 - 1e-9)
    np.testing.assert_array_equal(found.columns["y"][~found.missing], table["y"].dropna())


def test_lost_frames_and_blank_cells_are_missing():
    table = two_rates()
    given = np.flatnonzero(table["frame"].notna())
    table.loc[given[100:103], ["frame", "y"]] = np.nan
    table.loc[given[200], "y"] = np.nan
    with pytest.raises(InputError, match="an empty cell or NaN"):
        read(table, initial_state="estimate")
    found = read(table, initial_state="estimate", recording={"missing": "leave-out"})
    assert np.count_nonzero(found.missing) == 4
    assert len(found.time) == len(given)


def test_frames_without_a_time_are_counted():
    table = two_rates()
    given = np.flatnonzero(table["frame"].notna())
    table.loc[given[[5, 9]], "frame"] = np.nan
    table.loc[given[12], ["frame", "y"]] = np.nan
    found = read(table, initial_state="estimate")
    assert "recording: 2 frames have an output and no time in column 'frame', and are left out" in found.warnings
    assert not any("no time in column" in said for said in read(two_rates(), initial_state="estimate").warnings)


def test_times_in_the_unit_of_the_header_and_inputs_that_add_up():
    table = two_rates()
    table["v"] = 2.0
    renamed = table.rename(columns={"t": "t [ms]", "frame": "frame [ms]"})
    renamed[["t [ms]", "frame [ms]"]] *= 1e3
    driven = {"column": "u", "hold": "zoh", "added": [{"column": "v", "scale": 0.5}]}
    found = read(renamed, initial_state="estimate", input=driven)
    np.testing.assert_allclose(found.time, table["frame"].dropna(), rtol=1e-12)
    np.testing.assert_allclose(found.logs["u"].values, table["u"] + 1.0)
    np.testing.assert_allclose(found.columns["u"], read(table, initial_state="estimate").columns["u"] + 1.0)


def test_frames_outside_the_log_are_left_out_and_said():
    table = two_rates()
    given = np.flatnonzero(table["frame"].notna())
    table.loc[given, "frame"] += 5.0
    found = read(table, initial_state="estimate")
    assert found.time[-1] < table["t"].iloc[-1] + 0.01
    assert "frames before or after the log of the input are left out" in found.warnings[0]
    table.loc[given, "frame"] += 50.0
    with pytest.raises(InputError, match="none of the 553 frames lies within the log of the input"):
        read(table)


def _with_gap(table):
    return table.drop(index=range(300, 340))


def _twice(table):
    given = np.flatnonzero(table["frame"].notna())
    table.loc[given[5], "frame"] = table["frame"][given[4]]
    return table


@pytest.mark.parametrize(
    ("change", "parts", "said"),
    [
        (_with_gap, {}, "rows seem to be missing, and what the input did is unknown"),
        (_twice, {}, "appears twice"),
        (lambda t: t.drop(columns="frame"), {}, "no column 'frame'"),
        (lambda t: t.assign(frame=np.nan), {}, "column 'frame' is empty"),
        (lambda t: t, {"time": {"period": 0.01}}, "frames have times of their own, and the input has none"),
        (lambda t: t, {"input": None, "initial_state": "estimate"}, "without an input the times of the frames"),
        (lambda t: t, {"sensor": {"time": "t"}}, "are the same column 't'"),
        (
            lambda t: t,
            {"controller": {"reference": "u", "position_gain": 1.0, "velocity_gain": 1.0}},
            "a controller samples where its input changes",
        ),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(change, parts, said):
    with pytest.raises(InputError) as refused:
        read(change(two_rates()), **parts)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_gap_in_which_the_input_was_held():
    table = two_rates()
    table.loc[310:350, "u"] = table["u"][310]
    found = read(table.drop(index=range(320, 340)), recording={"gaps": "hold", "missing": "leave-out"})
    assert isinstance(table, pd.DataFrame)
    assert len(found.logs["u"].time) == len(table) - 20
