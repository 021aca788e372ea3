"""Files that others write: runs side by side, cells, nested structures, sheets, dates, units, names in comments."""

import re
import zipfile
from datetime import datetime, timedelta
from xml.sax.saxutils import escape

import h5py
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from camid.errors import InputError
from camid.recording.mat_hdf5 import layouts, tables_of
from camid.recording.nature import nature_of, quantisation_step
from camid.recording.options import Reading
from camid.recording.recording import read_recordings
from camid.recording.sheets import tables_of_sheets
from camid.recording.units import Conversion, unit_in_header

COUNT = 60
T = 0.02 * np.arange(COUNT)
U = np.where(np.arange(COUNT) // 7 % 2 == 0, 1.0, -1.0)
Y = np.cumsum(U) * 0.1 + np.sin(3.0 * T)


def read(source, time="t", columns=("u", "y"), holds=("u",), conversions=None, **keys):
    return read_recordings(
        source, time, columns, (), Reading(**keys), dict.fromkeys(holds, "zoh"), conversions=conversions
    )


def refusal(source, **keys):
    with pytest.raises(InputError) as caught:
        read(source, **keys)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def check_one_line(refused):
    assert "\n" not in str(refused)
    assert refused.where is not None


def cells(*values):
    array = np.empty((1, len(values)), dtype=object)
    for i, value in enumerate(values):
        array[0, i] = value
    return array


def text_file(folder, content, name="recording.csv"):
    (folder / name).write_text(content, encoding="utf-8")
    return folder / name


# Runs side by side


def test_runs_side_by_side_of_different_lengths(tmp_path):
    table = pd.DataFrame({"t": T, "u1": U, "y1": Y, "u2": 2 * U, "y2": 3 * Y})
    table.loc[40:, ["u2", "y2"]] = np.nan
    table.to_csv(tmp_path / "recording.csv", index=False)
    runs = ({"u": "u1", "y": "y1"}, {"u": "u2", "y": "y2"})
    first, second = read(tmp_path / "recording.csv", runs=runs)
    assert (first.experiment, second.experiment) == ("u1, y1", "u2, y2")
    assert (len(first), len(second)) == (COUNT, 40)
    np.testing.assert_array_equal(second.columns["u"], 2 * U[:40])
    np.testing.assert_array_equal(second.columns["y"], 3 * Y[:40])
    said = refusal(tmp_path / "recording.csv", runs=({"u": "u1", "y": "y1"}, {"u": "u3", "y": "y2"}))
    assert "no column 'u3'; did you mean" in said
    table.loc[20, "y2"] = np.nan  # a hole is none of the end
    table.to_csv(tmp_path / "recording.csv", index=False)
    assert "line 22, column 'y'" in refusal(tmp_path / "recording.csv", runs=runs)


# MAT and HDF5


def test_cells_of_matrices_are_experiments(tmp_path):
    pair = cells(np.vstack([U, Y]), np.vstack([2 * U, Y])[:, :50])
    savemat(tmp_path / "a.mat", {"data": pair})
    columns = ("data[0]", "data[1]")
    for group in (None, "/"):
        found = read(tmp_path / "a.mat", columns=columns, holds=columns[:1], period=0.02, group=group)
        assert [len(one) for one in found] == [COUNT, 50]
        np.testing.assert_array_equal(found[1].columns["data[0]"], 2 * U[:50])
        assert any("cells is read as an experiment" in w for w in found[0].warnings) is (group is None)


@pytest.mark.parametrize(
    "content",
    [
        {"t": cells(T, T), "u": cells(U, 2 * U), "y": cells(Y, Y)},
        {"runs": cells({"t": T, "u": U, "y": Y}, {"t": T, "u": 2 * U, "y": Y})},
        {"runs": {"t": T, "a": {"u": U, "y": Y}, "b": {"u": 2 * U, "y": Y}}},  # one clock for all
    ],
    ids=["cells of vectors", "cells of structures", "time above the runs"],
)
def test_structures_of_runs(tmp_path, content):
    savemat(tmp_path / "a.mat", content)
    found = read(tmp_path / "a.mat", group="runs" if "runs" in content else "/")
    assert len(found) == 2
    for k, one in enumerate(found):
        np.testing.assert_array_equal(one.time, T)
        np.testing.assert_array_equal(one.columns["u"], (k + 1) * U)
    above = any("column 't' is that of the group around it" in w for w in found[0].warnings)
    assert above is isinstance(content.get("runs"), dict)


@pytest.mark.parametrize("suffix", ["mat", "h5"])
def test_time_and_values_at_different_levels(tmp_path, suffix):
    content = {"log": {"time": T, "signals": {"values": np.column_stack([U, Y])}}}
    path = tmp_path / f"a.{suffix}"
    if suffix == "mat":
        savemat(path, content)
    else:
        with h5py.File(path, "w") as file:
            file["log/time"], file["log/signals/values"] = T, content["log"]["signals"]["values"]
    for stroke in "/.":
        columns = (f"signals{stroke}values[0]", f"signals{stroke}values[1]")
        (found,) = read(path, "time", columns, columns[:1], group="log")
        np.testing.assert_array_equal(found.columns[columns[1]], Y)
    said = refusal(path, time="time", columns=("signals/values[1]", "signals/values[2]"), holds=(), group="log")
    assert "columns of a matrix are counted from 0" in said


arrays = st.builds(
    lambda shape, kind: np.arange(np.prod(shape, dtype=int)).reshape(shape).astype(kind),
    st.sampled_from([(), (0,), (9,), (9, 1), (2, 9), (9, 2), (3, 3, 3)]),
    st.sampled_from(["f8", "i2", "?", "c16", "U3"]),
)
leaves = arrays | st.floats() | st.integers() | st.text(max_size=3) | st.none()
trees = st.dictionaries(
    st.sampled_from(["t", "u", "y", "runs", "a/b", "[0]"]),
    st.recursive(
        leaves,
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["t", "u", "y", "x"]), inner, max_size=3)
        ),
        max_leaves=12,
    ),
    max_size=4,
)


@given(trees, st.sampled_from([None, "/", "runs", "runs/[0]", "[0]", "t.u"]))
@settings(max_examples=200, deadline=None)
def test_any_tree_is_read_or_refused_in_one_line(tree, group):
    try:
        for table in tables_of(tree, "a.mat", ["t", "u"], Reading(group=group)):
            assert all(np.ndim(column) == 1 for column in table.columns.values())
    except InputError as refused:
        check_one_line(refused)
    for _, tables in layouts(tree, "a.mat"):
        assert tables


cell_values = st.sampled_from(["", "t", "u", "mm", "-", 1.0, 2.5, -3.0, True]) | st.floats(-9.0, 9.0) | st.dates()


@given(
    st.dictionaries(
        st.sampled_from(["A", "B"]), st.lists(st.lists(cell_values, min_size=1, max_size=4), min_size=1, max_size=8)
    ),
    st.sampled_from([None, "/", "A", "C"]),
    st.booleans(),
)
@settings(max_examples=200, deadline=None)
def test_any_sheets_are_read_or_refused_in_one_line(sheets, group, header):
    sheets = {name: rows for name, rows in sheets.items() if any(c != "" for row in rows for c in row)}
    reading = Reading(group=group, header=header, columns=() if header else ("t", "u"))
    try:
        tables = tables_of_sheets(sheets, "a.xlsx", ["t", "u"], reading)
        for table in tables:
            assert len({len(column) for column in table.columns.values()}) <= 1
            for column in table.columns:
                table.column(column)
    except InputError as refused:
        check_one_line(refused)


# Text


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


@pytest.mark.parametrize("head", ["t [ms],u (V),angle [deg]", "t,u,angle\nms,V,deg", "t,u,angle\n[ms],-,[deg]"])
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


# Spreadsheets


def workbook(path, sheets):
    """A minimal .xlsx: lists of rows by the names of the sheets."""

    def cell(value):
        if isinstance(value, str):
            return f'<c t="inlineStr"><is><t>{escape(value)}</t></is></c>'
        return f"<c><v>{value!r}</v></c>"

    main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    package = "http://schemas.openxmlformats.org/package/2006"
    kind = "application/vnd.openxmlformats-officedocument.spreadsheetml"
    count = range(1, len(sheets) + 1)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "[Content_Types].xml",
            f'<Types xmlns="{package}/content-types">'
            '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
            f'<Override PartName="/xl/workbook.xml" ContentType="{kind}.sheet.main+xml"/>'
            + "".join(
                f'<Override PartName="/xl/worksheets/sheet{k}.xml" ContentType="{kind}.worksheet+xml"/>' for k in count
            )
            + "</Types>",
        )
        relations = f'<Relationships xmlns="{package}/relationships">'
        archive.writestr(
            "_rels/.rels",
            f'{relations}<Relationship Id="r1" Type="{office}/officeDocument" Target="xl/workbook.xml"/>'
            "</Relationships>",
        )
        archive.writestr(
            "xl/workbook.xml",
            f'<workbook xmlns="{main}" xmlns:r="{office}"><sheets>'
            + "".join(f'<sheet name="{n}" sheetId="{k}" r:id="r{k}"/>' for k, n in zip(count, sheets, strict=True))
            + "</sheets></workbook>",
        )
        archive.writestr(
            "xl/_rels/workbook.xml.rels",
            relations
            + "".join(
                f'<Relationship Id="r{k}" Type="{office}/worksheet" Target="worksheets/sheet{k}.xml"/>' for k in count
            )
            + "</Relationships>",
        )
        for k, rows in zip(count, sheets.values(), strict=True):
            body = "".join(f"<row>{''.join(cell(v) for v in row)}</row>" for row in rows)
            archive.writestr(
                f"xl/worksheets/sheet{k}.xml",
                f'<worksheet xmlns="{main}"><sheetData>{body}</sheetData></worksheet>',
            )


def rows_of(gain=1.0, header=("t", "u", "y"), units=None):
    body = [[float(t), gain * float(u), float(y)] for t, u, y in zip(T, U, Y, strict=True)]
    return [list(header), *([units] if units else []), *body]


def test_sheets(tmp_path):
    path = tmp_path / "a.xlsx"
    workbook(path, {"notes": [["made by hand"]], "first": rows_of(), "second": [["Run 2"], *rows_of(2.0)]})
    assert "the sheets first, second all have these columns; say group: first under recording" in refusal(path)
    found = read(path, group="/")
    assert [one.experiment for one in found] == ["first", "second"]
    np.testing.assert_array_equal(found[1].columns["u"], 2 * U)
    np.testing.assert_array_equal(read(path, group="second")[0].columns["u"], 2 * U)
    assert "no sheet 'third'; known here: notes, first, second" in refusal(path, group="third")
    assert "a spreadsheet file has no separator" in refusal(path, separator=";")
    workbook(path, {"notes": [["made by hand"]], "first": rows_of()})
    assert "the sheet 'first' of 2 is read" in read(path)[0].warnings[0]


def test_one_sheet_with_units_without_names_and_with_a_wrong_cell(tmp_path):
    path = tmp_path / "a.xlsx"
    workbook(path, {"Sheet1": rows_of(units=["ms", "V", "mm"])})
    (found,) = read(path)
    assert found.period == pytest.approx(2e-5)
    np.testing.assert_allclose(found.columns["y"], 1e-3 * Y)
    workbook(path, {"Sheet1": rows_of()[1:]})
    assert "row 1: the first row holds numbers, not names; say header: false" in refusal(path)
    reading = Reading(header=False, columns=("t", "u", "y"))
    assert len(read_recordings(path, "t", ("u", "y"), (), reading, {"u": "zoh"})[0]) == COUNT
    wrong = rows_of()
    wrong[8][2] = "x"
    workbook(path, {"Sheet1": wrong})
    assert "row 9, column 'y': 'x' where a number should be" in refusal(path)


# What an error offers, and what columns look like


def test_an_error_offers_the_columns_that_would_do():
    table = pd.DataFrame({"clock": T, "volts": U, "angle": Y, "note": "a"})
    assert "columns that would do as the time: clock (a clock, steps of 0.02)" in refusal(table)
    assert "columns that would do as the input: volts (held, 2 levels), angle" in refusal(table, time="clock")
    said = refusal(table, time="clock", columns=("volts", "y"), holds=("volts",))
    assert "columns that would do as the output: angle (smooth)" in said
    assert "note" not in said.partition("would do")[2]


def test_natures():
    generator = np.random.default_rng(1)
    assert nature_of(T).kind == "clock"
    assert nature_of(np.delete(T, [5, 20])).period == pytest.approx(0.02)
    assert nature_of(np.ones(9)).kind == "constant"
    assert nature_of(U).kind == "held"
    assert nature_of(np.repeat(generator.normal(size=20), 5)).kind == "held"
    assert nature_of(generator.normal(size=500)).kind == "rough"
    swing = np.sin(0.05 * np.arange(2000))
    assert nature_of(swing).kind == "smooth"
    encoder = nature_of(0.05 * np.round(swing / 0.05))
    assert encoder.kind == "smooth"  # a slow encoder repeats its readings and is no command
    assert encoder.step == pytest.approx(0.05)
    assert nature_of(np.array([np.nan, 1.0])) is None


@given(st.floats(1e-6, 1e6), st.floats(-1e3, 1e3), st.integers(0, 100))
@settings(max_examples=50, deadline=None)
def test_the_step_of_an_encoder_is_found_in_any_unit(step, offset, seed):
    counts = np.cumsum(np.random.default_rng(seed).integers(-1, 2, 1000))
    assert quantisation_step(step * (counts + offset)) == pytest.approx(step, rel=1e-3)
    assert quantisation_step(np.random.default_rng(seed).normal(size=1000)) is None


# Scatter of the times


@pytest.mark.parametrize(("scatter", "said"), [(2e-5, False), (0.2, True)])
def test_scatter_of_the_times_is_told_by_its_size_where_it_matters(scatter, said):
    generator = np.random.default_rng(5)
    time = 0.01 * (np.arange(500) + scatter * generator.uniform(-1.0, 1.0, 500))
    output = np.round(np.sin(2.0 * time), 3)
    (found,) = read(pd.DataFrame({"t": time, "y": output}), columns=("y",), holds=())
    assert any("off a regular grid of 10" in w for w in found.warnings) is said
    assert not any("100 %" in w for w in found.warnings)
    if said:
        size = re.search(r"by (\S+) ms RMS and at most \S+ ms \((\d+) % of the period\)", found.warnings[0])
        assert float(size[1]) == pytest.approx(2.0 / np.sqrt(3.0), rel=0.1)
        assert int(size[2]) == pytest.approx(20, abs=2)
