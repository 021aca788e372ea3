"""Two tables on two clocks: offset and skew are those that were put in, and the rows hold what they should."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.cli import main
from camid.errors import InputError
from camid.joining.clocks import CommonSignal, aligned, first_alignment
from camid.joining.rows import joined_rows

FRAME = 0.02


def motion(time):
    """A smooth motion that repeats nowhere."""
    return np.sin(3.0 * time) + 0.6 * np.sin(7.7 * time + 1.0) + 0.3 * np.sin(0.9 * time**1.3)


def integral(time, count=40):
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return np.array([0.5 * t * (weights @ motion(0.5 * t * (nodes + 1.0))) for t in time])


@pytest.mark.parametrize("seed", range(4))
def test_clocks_of_a_motion_that_both_tables_hold(seed):
    generator = np.random.default_rng(seed)
    offset, skew = generator.uniform(-20.0, 20.0), generator.normal(0.0, 3e-4)
    drive_time = np.arange(0.0, 30.0, 0.004)
    drive = motion(drive_time) + 1e-3 * generator.standard_normal(len(drive_time))
    delivered = np.arange(1.0, 29.0, FRAME)
    time = (delivered - offset) / (1.0 + skew)
    seen = 5.0 - 40.0 * motion(delivered) + 0.5 * generator.standard_normal(len(time))
    start = first_alignment(time, seen, drive_time, drive)
    clocks = aligned(time, seen, CommonSignal(drive_time, drive, 0.0), start[:2])
    assert abs(clocks.offset - offset) < 4.0 * clocks.offset_deviation
    assert abs(clocks.skew - skew) < 4.0 * clocks.skew_deviation
    assert clocks.uncertainty(float(time.mean())) < 0.02 * FRAME


@pytest.mark.parametrize("flashes", [((10.0, 10.6),), ((4.0, 4.5), (22.3, 22.9))], ids=["one", "two"])
def test_a_flash_that_both_saw(flashes, tmp_path):
    """It tells the offset to a part of a frame, and two of them the skew."""
    offset, skew, frame, exposure = 2.5, 1.5e-4, 1.0 / 30.0, 0.02
    drive_time = np.arange(0.0, 30.0, 0.005)
    led = np.zeros(len(drive_time))
    for start, end in flashes:
        led[(drive_time >= start) & (drive_time < end)] = 1.0
    bright = np.append(0.0, np.cumsum(led) * 0.005)
    delivered = np.arange(1.0043, 29.0, frame)
    ends = [np.interp(delivered - late, np.append(drive_time, 30.0), bright) for late in (0.0, exposure)]
    clip = pd.DataFrame(
        {"t": (delivered - offset) / (1.0 + skew), "brightness": 50.0 + 150.0 * (ends[0] - ends[1]) / exposure}
    )
    clip.to_csv(tmp_path / "clip.csv", index=False)
    pd.DataFrame({"t": drive_time, "led": led}).to_csv(tmp_path / "drive.csv", index=False)
    clocks = camid.join(tmp_path / "clip.csv", tmp_path / "drive.csv", match=("brightness", "led")).clocks
    middle = float(clip["t"].mean())
    error = clocks.offset + (1.0 + clocks.skew) * middle - offset - (1.0 + skew) * middle
    assert abs(error) < 2.0 * clocks.uncertainty(middle) < frame
    assert abs(clocks.skew - skew) < 2.0 * clocks.skew_deviation < (2e-3 if len(flashes) == 1 else 1e-3)


def test_blank_cells_of_the_clip_are_frames_that_are_missing(tmp_path):
    drive_time = np.arange(0.0, 20.0, 0.02)
    delivered = np.arange(1.0, 19.0, FRAME)
    clip = pd.DataFrame({"t": delivered - 3.0, "x": motion(delivered)})
    clip.loc[300:340, "x"] = np.nan
    clip.to_csv(tmp_path / "clip.csv", index=False)
    pd.DataFrame({"t": drive_time, "encoder": motion(drive_time)}).to_csv(tmp_path / "drive.csv", index=False)
    found = camid.join(tmp_path / "clip.csv", tmp_path / "drive.csv", match=("x", "encoder"), exposure=0.0)
    assert found.clocks.offset == pytest.approx(3.0, abs=1e-5)
    assert found.frames == 900 - 41
    assert found.table["x"].count() == found.table[found.frame_time].count() == 900 - 41


def test_a_gap_in_the_log_of_the_drive_is_refused(tmp_path, tables):
    drive = pd.read_csv(tables[1]).drop(index=range(200, 230))
    drive.to_csv(tmp_path / "gap.csv", index=False)
    with pytest.raises(InputError, match=r"0\.62 s are missing after t = 3\.98"):
        camid.join(tables[0], tmp_path / "gap.csv", match=("y", "u"))


def test_times_of_a_computer_and_in_milliseconds(tmp_path):
    drive_time = np.arange(0.0, 20.0, 0.02)
    delivered = np.arange(1.0, 19.0, FRAME)
    pd.DataFrame({"t [ms]": 1e3 * (delivered - 0.5), "x": motion(delivered)}).to_csv(tmp_path / "clip.csv", index=False)
    pd.DataFrame({"t": 1.7e9 + drive_time, "encoder": motion(drive_time)}).to_csv(tmp_path / "drive.csv", index=False)
    found = camid.join(tmp_path / "clip.csv", tmp_path / "drive.csv", exposure=0.0)
    assert found.clocks.offset == pytest.approx(1.7e9 + 0.5, abs=1e-4)
    assert found.table["t"].iloc[0] == 1.7e9


def test_the_exposure_is_averaged_over():
    drive_time = np.arange(0.0, 10.0, 0.002)
    signal = CommonSignal(drive_time, motion(drive_time), 0.2)
    ends = np.array([2.0, 5.0, 9.9])
    wanted = (integral(ends) - integral(ends - 0.2)) / 0.2
    np.testing.assert_allclose(signal.at(ends), wanted, atol=1e-6)
    step = 1e-5
    np.testing.assert_allclose(
        signal.rate(ends), (signal.at(ends + step) - signal.at(ends - step)) / (2 * step), atol=1e-4
    )


def test_neither_table_is_changed():
    drive_time = np.arange(500) * 0.01
    frames = 1.003 + np.arange(100) / 29.97
    values, input_ = np.arange(100.0), np.sign(np.sin(9.0 * drive_time))
    rows = joined_rows(drive_time, {"u": input_}, frames, {"y": values}, "t")
    np.testing.assert_array_equal(rows.columns["t"], np.round(drive_time, 9))
    np.testing.assert_array_equal(rows.columns["u"], input_)
    filled = np.flatnonzero(np.isfinite(rows.columns["y"]))
    np.testing.assert_array_equal(rows.columns["y"][filled], values)
    np.testing.assert_allclose(rows.columns["frame_time"][filled], frames, atol=1e-9)
    delay = rows.columns["frame_time"][filled] - rows.columns["t"][filled]
    assert np.all((delay >= -1e-9) & (delay < 0.01 + 1e-9))
    assert rows.frames == 100


def test_a_row_holds_one_frame():
    drive_time = np.arange(100) * 0.05
    frames = 1.0 + np.arange(200) / 60.0
    held = np.repeat([-1.0, 1.0], 50)
    rows = joined_rows(drive_time, {"u": held, "encoder": motion(drive_time)}, frames, {"y": motion(frames)}, "t")
    assert rows.period == pytest.approx(0.0125)
    assert "takes 4 rows" in rows.remarks[0]
    assert set(rows.columns["u"]) == {-1.0, 1.0}
    np.testing.assert_allclose(rows.columns["encoder"][::4], motion(drive_time))
    assert np.count_nonzero(np.isfinite(rows.columns["y"])) == 200


def test_frames_outside_the_log_have_no_row():
    drive_time = np.arange(0.0, 12.0, 0.02)
    frames = np.delete(-1.0 + np.arange(400) * 0.02, slice(100, 110))
    rows = joined_rows(drive_time, {"u": motion(drive_time)}, frames, {"y": frames}, "t")
    assert rows.frames == np.count_nonzero(frames >= 0.0)
    with pytest.raises(ValueError, match="overlap in 5 frames; 40 are needed"):
        joined_rows(drive_time, {"u": motion(drive_time)}, frames[:55], {"y": frames[:55]}, "t")


def test_a_name_that_both_have_and_that_of_the_times():
    drive_time = np.arange(100) * 0.05
    rows = joined_rows(drive_time, {"frame_time": drive_time}, drive_time, {"y": drive_time}, "t")
    assert rows.frame_time == "frame_time_clip"


@pytest.fixture
def tables(tmp_path):
    drive_time = np.arange(0.0, 20.0, 0.02)
    u = np.repeat(np.random.default_rng(1).choice([-1.0, 1.0], 250), 4)
    pd.DataFrame({"time": drive_time, "u": u}).to_csv(tmp_path / "drive.csv", index=False)
    pd.DataFrame({"t": np.arange(500) * 0.02, "y": np.random.default_rng(2).standard_normal(500)}).to_csv(
        tmp_path / "clip.csv", index=False
    )
    return tmp_path / "clip.csv", tmp_path / "drive.csv"


SIMULATION = {
    "schema": 1,
    "time": {"column": "time"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [100.0], "denominator": [1.0, 4.0, 100.0]}},
    "sensor": {"column": "y", "kind": "camera", "exposure": 0.01},
}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "no column of the clip follows one of the drive"),
        ({"match": ("x", "u")}, "no column 'x'"),
        ({"match": ("y", "v")}, "no column 'v'"),
        ({"clip_time": "s"}, "no column 's'"),
        ({"exposure": -1.0}, "--exposure -1"),
        ({"match": ("y", "u"), "simulation": SIMULATION}, "keep one of them"),
        ({"simulation": {**SIMULATION, "input": None, "initial_state": "estimate"}}, "a free decay has no input"),
        ({"simulation": SIMULATION}, "does not lead from 'u' to 'y'"),
    ],
)
def test_what_cannot_be_joined_is_refused_in_one_line(tables, options, said):
    with pytest.raises(InputError) as refused:
        camid.join(*tables, **options)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_signal_that_does_not_change(tmp_path):
    time = np.arange(100) * 0.02
    for name, values in (("clip", motion(time)), ("drive", np.zeros(100))):
        pd.DataFrame({"t": time, "x": values}).to_csv(tmp_path / f"{name}.csv", index=False)
    with pytest.raises(InputError, match="does not change"):
        camid.join(tmp_path / "clip.csv", tmp_path / "drive.csv", match=("x", "x"))


def test_the_noise_of_an_encoder_is_no_slope():
    """Stated deviations hold where what the drive measures is noisy."""
    errors = []
    for seed in range(12):
        generator = np.random.default_rng(100 + seed)
        drive_time = np.arange(0.0, 20.0, 0.0025)
        drive = motion(drive_time) + 0.05 * generator.standard_normal(len(drive_time))
        delivered = np.arange(1.0, 19.0, FRAME) + generator.uniform(0.0, FRAME)
        seen = motion(delivered) + 0.01 * generator.standard_normal(len(delivered))
        time = delivered - 2.0
        start = first_alignment(time, seen, drive_time, drive)
        clocks = aligned(time, seen, CommonSignal(drive_time, drive, 0.0, FRAME), start[:2])
        middle = float(time.mean())
        error = clocks.offset + clocks.skew * middle - 2.0
        errors.append(error / clocks.uncertainty(middle))
    assert np.sqrt(np.mean(np.square(errors))) < 1.7


def test_what_the_simulation_says_wrongly_is_named(tables):
    """Not that nothing follows anything."""
    with pytest.raises(InputError, match=r"exposure = 3\.0 s is longer than the period"):
        camid.join(*tables, simulation={**SIMULATION, "sensor": {**SIMULATION["sensor"], "exposure": 3.0}})


def test_a_command_is_not_taken_for_the_position_that_it_drives(tmp_path):
    """They agree somewhat, and at a skew that no clocks have."""
    generator = np.random.default_rng(5)
    time = 0.01 * np.arange(2500)
    u = np.repeat(generator.choice([-2.0, -1.0, 1.0, 2.0], 125), 20)
    modes = np.exp((-1.0 + 10.2j) * time)
    position = np.imag(np.convolve(u, modes)[: len(time)]) * 0.01
    clip_time = np.arange(0.0, 20.0, 0.025)
    seen = np.interp(3.2 + 1.0002 * clip_time, time, position)
    pd.DataFrame({"t": time, "u": u, "encoder": position}).to_csv(tmp_path / "drive.csv", index=False)
    pd.DataFrame({"t": clip_time, "x": seen}).to_csv(tmp_path / "clip.csv", index=False)
    files = tmp_path / "clip.csv", tmp_path / "drive.csv"
    with pytest.raises(InputError, match="does not follow 'u' of the drive"):
        camid.join(*files, match=("x", "u"))
    assert not any("same quantity" in r for r in camid.join(*files, match=("x", "encoder")).remarks)
    pd.DataFrame({"t": 1.01 * clip_time, "x": seen}).to_csv(tmp_path / "slow.csv", index=False)
    with_skew = camid.join(tmp_path / "slow.csv", files[1], match=("x", "encoder"))
    assert "clocks hardly run apart by more than 1000·10⁻⁶" in with_skew.remarks[0]


def test_rows_without_a_frame_are_blank_in_the_file(tmp_path, capsys):
    drive_time = np.arange(0.0, 20.0, 0.01)
    delivered = np.arange(1.0, 19.0, FRAME)
    pd.DataFrame({"t": drive_time, "encoder": motion(drive_time)}).to_csv(tmp_path / "drive.csv", index=False)
    pd.DataFrame({"t": delivered - 0.4, "x": motion(delivered)}).to_csv(tmp_path / "clip.csv", index=False)
    arguments = [str(tmp_path / "clip.csv"), str(tmp_path / "drive.csv"), "--match", "x=encoder"]
    assert main(["join", *arguments, "--output", str(tmp_path / "joined.csv")]) == 0
    capsys.readouterr()
    first, second = (tmp_path / "joined.csv").read_text().splitlines()[1:3]
    assert first.endswith(",,")
    assert second.endswith(",,")
