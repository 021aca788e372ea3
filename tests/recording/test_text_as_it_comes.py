"""Text that others write: names in comments, units in the header, dates."""

from datetime import datetime, timedelta

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camid.errors import InputError
from camid.recording.files import read_tables
from camid.recording.options import Reading
from camid.recording.read import read_recordings
from camid.recording.units import Conversion, unit_in_header, with_bracketed_unit
from tests.support.recordings import COUNT, T, U, Y, read, refusal, text_file


@pytest.mark.parametrize("separator", [" ", ",", ";"])
@pytest.mark.parametrize("header", ["t, u, y", "t u y", "t; u; y"])
def test_names_in_the_comment_that_numpy_writes(tmp_path, separator, header):
    np.savetxt(tmp_path / "a.csv", np.column_stack([T, U, Y]), delimiter=separator, header=header)
    (found,) = read(tmp_path / "a.csv")
    np.testing.assert_allclose(found.columns["y"], Y)
    assert found.warnings == ()


def test_an_error_counts_the_lines_of_a_file_with_names_in_a_comment(tmp_path):
    rows = "\n".join(f"{t} {u} {'x' if i == 5 else 1}" for i, (t, u) in enumerate(zip(T, U, strict=True)))
    assert "line 8, column 'y': 'x'" in refusal(text_file(tmp_path, f"# made by hand\n# t u y\n{rows}\n"))


def test_a_comment_of_as_many_words_does_not_replace_the_header(tmp_path):
    rows = "\n".join(f"{t},{u},{y}" for t, u, y in zip(T, U, Y, strict=True))
    assert len(read(text_file(tmp_path, f"# made by hand\nt,u,y\n{rows}\n"))[0]) == COUNT


@pytest.mark.parametrize(
    "head",
    ["t [ms],u (V),angle [deg]", "t,u,angle\nms,V,deg", "t,u,angle\n[ms],-,[deg]", "t/ms,u / V,angle/deg"],
)
def test_units_in_the_header(tmp_path, head):
    rows = "\n".join(f"{1e3 * t:.0f},{u},{y}" for t, u, y in zip(T, U, Y, strict=True))
    path = text_file(tmp_path, f"{head}\n{rows}\n")
    (found,) = read(path, columns=("u", "angle"))
    assert found.period == pytest.approx(0.02)
    np.testing.assert_allclose(found.columns["angle"], np.deg2rad(Y), atol=1e-12)
    said = " ".join(found.warnings)
    assert "column 't [ms]' is read in ms, as its header says" in said
    assert "column 'angle [deg]' is read in deg" in said
    declared = {"angle": Conversion(unit="mm")}  # what is declared counts
    (found,) = read(path, columns=("u", "angle"), conversions=declared)
    np.testing.assert_allclose(found.columns["angle"], 1e-3 * Y, atol=1e-12)
    (found,) = read(path, columns=("u", "angle"), conversions={"angle": Conversion(unit="dimensionless")})
    np.testing.assert_allclose(found.columns["angle"], Y, atol=1e-12)
    rows = rows.replace("\n", "\nx", 1)
    lines = 2 + head.count("\n") + 1
    assert f"line {lines}, column 't'" in refusal(text_file(tmp_path, f"{head}\n{rows}\n"), columns=("u", "angle"))


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        ("t/ms", "t [ms]"),
        ("v/(m/s)", "v [m/s]"),
        ("v / m/s", "v [m/s]"),
        ("m/s", "m/s"),
        ("run/other", "run/other"),
        ("a/b/V", "a/b/V"),
        ("/ms", "/ms"),
        ("t [ms]", "t [ms]"),
    ],
)
def test_a_quantity_over_its_unit(header, expected):
    assert with_bracketed_unit(header) == expected


def test_a_column_is_found_by_the_header_as_it_stands(tmp_path):
    rows = "\n".join(f"{1e3 * t:.0f},{u},{y}" for t, u, y in zip(T, U, Y, strict=True))
    path = text_file(tmp_path, f"t/ms,u,angle/deg\n{rows}\n")
    (found,) = read(path, columns=("u", "angle/deg"))
    np.testing.assert_allclose(found.columns["angle/deg"], np.deg2rad(Y), atol=1e-12)


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("angle [deg]", "angle", "deg"),
        ("u(V)", "u", "V"),
        ("drive current (mA)", "drive current", "mA"),
        ("x [0]", "x [0]", None),
        ("x[1]", "x[1]", None),
        ("angle (filtered)", "angle (filtered)", None),
        ("[mm]", "[mm]", None),
        ("share [%]", "share", "%"),
        ("phi [°]", "phi", "°"),
    ],
)
def test_what_is_a_unit_in_a_header(header, name, unit):
    assert unit_in_header(header) == (name, unit)


@given(st.text(max_size=20))
@settings(max_examples=200, deadline=None)
def test_any_header_has_a_name_and_perhaps_a_unit(header):
    name, unit = unit_in_header(header)
    assert name in header
    assert unit is None or unit in header


START = datetime(2026, 3, 1, 23, 59, 59, 500000)


@pytest.mark.parametrize(
    "form",
    [
        lambda at: at.isoformat(),
        lambda at: at.isoformat(sep=" ", timespec="milliseconds"),
        lambda at: f"{at.isoformat(timespec='milliseconds')}Z",
        lambda at: f"{at.isoformat(timespec='milliseconds')}+02:00",
    ],
)
def test_dates_become_seconds(tmp_path, form):
    rows = [f"{form(START + timedelta(seconds=float(t)))},{u},{y}" for t, u, y in zip(T, U, Y, strict=True)]
    path = text_file(tmp_path, "t,u,y\n" + "\n".join(rows) + "\n")
    (found,) = read(path, start=0.2)
    np.testing.assert_allclose(found.time, T[10:], atol=1e-9)
    assert "holds dates: its times are seconds after 2026-03-01" in found.warnings[0]
    with pytest.raises(InputError, match="holds dates, and a unit is declared"):
        read_recordings(path, "t", ("y",), reading=Reading(time=Conversion(unit="ms")))


def test_times_of_day_and_dates_in_another_order(tmp_path):
    rows = [f"12:00:{t:06.3f},{u},{y}" for t, u, y in zip(T, U, Y, strict=True)]
    (found,) = read(text_file(tmp_path, "t,u,y\n" + "\n".join(rows) + "\n"))
    assert found.period == pytest.approx(0.02)
    rows = [f"01.03.2026 12:00:{t:06.3f},{u},{y}" for t, u, y in zip(T, U, Y, strict=True)]
    said = refusal(text_file(tmp_path, "t,u,y\n" + "\n".join(rows) + "\n"))
    assert "write dates as ISO 8601 has them" in said


@given(st.integers(0, 2**31), st.integers(1, 10**6), st.integers(5, 50))
@settings(max_examples=50, deadline=None)
def test_dates_are_read_to_the_microsecond(second, step, count):
    origin = datetime(1970, 1, 1) + timedelta(seconds=second)
    dates = [(origin + timedelta(microseconds=step * k)).isoformat(timespec="microseconds") for k in range(count)]
    (found,) = read(pd.DataFrame({"t": dates, "y": np.arange(count)}), columns=("y",), holds=())
    np.testing.assert_allclose(found.recorded_time, 1e-6 * step * np.arange(count), rtol=1e-12, atol=1e-12)


def test_frames_with_dates():
    for time in (pd.date_range(START, periods=COUNT, freq="20ms"), pd.to_timedelta(T, unit="s")):
        (found,) = read(pd.DataFrame({"t": time, "u": U, "y": Y}))
        np.testing.assert_allclose(found.time, T, atol=1e-9)


def test_columns_that_cannot_be_told_apart_by_name(tmp_path):
    """Found by the fuzzer: a header in brackets over rows of other lengths leaves columns without names."""
    (tmp_path / "r.csv").write_bytes(b"t [\t\t\t1870tm\t\t\t%\t\tms] y[ ,m\nm\nm]2\n")
    with pytest.raises(InputError, match="several columns are"):
        read_tables(tmp_path / "r.csv", ("t", "y"), Reading())


@pytest.mark.parametrize("separator", [";", ",", "\t"])
@pytest.mark.parametrize(
    "title",
    ["Rig 3{s}{s}{s}\nOperator: Bob{s}{s}{s}\n{s}{s}{s}\n", "Rig 3\nOperator{s}Bob\n\n", "Rig 3\n\n\n", "mass{s}2.5\n"],
)
@pytest.mark.parametrize("units", ["", "s{s}V{s}mm{s}\n"])
def test_titles_above_the_names_are_passed_over_as_in_a_spreadsheet(tmp_path, separator, title, units):
    rows = "".join(f"{t};{u};{y};\n" for t, u, y in zip(T, U, Y, strict=True)).replace(";", separator)
    path = text_file(tmp_path, f"{title}t{{s}}u{{s}}y{{s}}\n{units}".format(s=separator) + rows)
    (found,) = read(path)
    np.testing.assert_allclose(found.columns["y"], (1e-3 if units else 1.0) * np.array(Y))
    path.write_text(path.read_text().replace(f"{T[3]}{separator}", f"x{separator}", 1))
    line = path.read_text().splitlines().index(next(r for r in path.read_text().splitlines() if r.startswith("x"))) + 1
    assert f"line {line}, column 't'" in refusal(path)


def test_a_column_without_a_name_has_none_of_pandas(tmp_path):
    rows = "".join(f"{t},{u},{y},a,\n" for t, u, y in zip(T, U, Y, strict=True))
    said = refusal(text_file(tmp_path, f"t,u,angle,,\n{rows}"))
    assert "known here: t, u, angle, column4;" in said


def test_a_video_is_for_the_tracker_and_a_line_of_text_is_no_list_of_names(tmp_path):
    (tmp_path / "clip.MP4").write_bytes(b"abc" * 200)
    assert refusal(tmp_path / "clip.MP4").endswith("this is a video; camid track makes a recording of it")
    assert len(refusal(text_file(tmp_path, "abc" * 200 + "\n1\n2\n"))) < 200
