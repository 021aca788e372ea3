"""The recording contract: what is read, what is refused and in which words, and that files are written whole."""

import os
from itertools import product

import numpy as np
import pandas as pd
import pytest

from camid.errors import InputError
from camid.recording.options import Reading
from camid.recording.read import read_recording
from camid.writing import write_table, write_whole

ROWS = ["0.0,1,0.5", "0.1,2,0.25", "0.2,3,-1e-3", "0.3,4,0"]
HEADER = "t,u,y"


def csv_file(folder, *lines, name="recording.csv", ending="\n", encoding="utf-8"):
    path = folder / name
    path.write_bytes("".join(line + ending for line in lines).encode(encoding))
    return path


def read(source, reading=None):
    return read_recording(source, "t", ["u", "y"], reading=reading, holds={"u": "zoh"})


def refusal(source, reading=None):
    with pytest.raises(InputError) as caught:
        read(source, reading)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    ("header", "rows"),
    [
        (HEADER, ROWS),
        ("t, u, y", [row.replace(",", ", ") for row in ROWS]),
        ("t,u,y,", [row + "," for row in ROWS]),  # commas at the end of every line
        (HEADER, [row + "," for row in ROWS]),  # … but not of the header
        ("y,note,t,u", [f"{r[2]},'{r[0]}',{r[0]},{r[1]}" for r in (row.split(",") for row in ROWS)]),
        ('"t","u","y"', ROWS),
        ("", [HEADER, *ROWS[:2], "", "   ", *ROWS[2:]]),  # blank lines count for nothing
    ],
)
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_ways_to_write_the_same_table(tmp_path, header, rows, ending, encoding):
    recording = read(csv_file(tmp_path, header, *rows, ending=ending, encoding=encoding))
    np.testing.assert_array_equal(recording.time, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(recording.columns["u"], [1, 2, 3, 4])
    np.testing.assert_array_equal(recording.columns["y"], [0.5, 0.25, -0.001, 0.0])
    assert recording.period == pytest.approx(0.1, rel=1e-12)


def test_parquet_and_tables_read_like_csv(tmp_path):
    path = csv_file(tmp_path, HEADER, *ROWS)
    table = pd.read_csv(path)
    table.to_parquet(tmp_path / "recording.parquet")
    for source in (table, tmp_path / "recording.parquet", str(path)):
        np.testing.assert_array_equal(read(source).columns["y"], read(path).columns["y"])


def test_numbers_are_read_to_the_last_bit(tmp_path):
    values = np.random.default_rng(3).standard_normal(200) * 10.0 ** np.arange(-135, 65)
    lines = [f"{0.1 * k},{v!r},{v!r}" for k, v in enumerate(values.tolist())]
    np.testing.assert_array_equal(read(csv_file(tmp_path, HEADER, *lines)).columns["u"], values)


def test_files_that_are_no_recordings(tmp_path):
    assert refusal(tmp_path / "none.csv") == f"{tmp_path / 'none.csv'}: no such file; check the path"
    assert "this is a folder" in refusal(tmp_path)
    assert "the file is empty" in refusal(csv_file(tmp_path))
    assert "the file is empty" in refusal(csv_file(tmp_path, "", "", ""))
    assert "0 rows" in refusal(csv_file(tmp_path, HEADER))
    assert "2 rows" in refusal(csv_file(tmp_path, HEADER, *ROWS[:2]))
    picture = tmp_path / "picture.csv"
    picture.write_bytes(bytes(range(256)) * 40)
    assert "not UTF-8 text" in refusal(picture)
    assert "not UTF-8 text" in refusal(csv_file(tmp_path, HEADER, *ROWS, encoding="utf-16-le"))


@pytest.mark.parametrize("kept", [0, 10, 0.5, 0.99])
def test_truncated_parquet(tmp_path, kept):
    path = tmp_path / "recording.parquet"
    pd.DataFrame({"t": np.arange(1000.0), "u": 1.0, "y": 2.0}).to_parquet(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(kept * len(whole)) if kept < 1 else kept])
    assert "cannot be read" in refusal(path)


def test_missing_column_offers_the_nearest_name(tmp_path):
    assert "no column 'y'; known here: t, u, z" in refusal(csv_file(tmp_path, "t,u,z", *ROWS))
    assert "no column 'y'; did you mean 'yy'?" in refusal(csv_file(tmp_path, "t,u,yy", *ROWS))
    assert "no column 't'; did you mean 't1'?" in refusal(csv_file(tmp_path, "t1,u,y", *ROWS))


def separated(lines, separator, decimal="."):
    return [line.replace(",", "\0").replace(".", decimal).replace("\0", separator) for line in lines]


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "   ", "; ", " \t", ";;"])
@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("quoted", [False, True])
def test_separator_and_decimal_mark_are_found(tmp_path, separator, decimal, quoted):
    """Whatever stands between the cells; a decimal comma is found unless commas stand there, too."""
    if separator == ";;":  # a separator at the end of every line, and of the rows only
        lines = [line + ";" for line in separated([HEADER, *ROWS], ";", decimal)]
        assert read(csv_file(tmp_path, lines[0][:-1], *lines[1:])).period == pytest.approx(0.1)
    else:
        header = HEADER.replace(",", separator)
        if quoted:
            header = '"' + header.replace(separator, f'"{separator}"') + '"'
        lines = [header, *separated(ROWS, separator, decimal)]
    path = csv_file(tmp_path, *lines)
    if decimal == separator == ",":
        assert "more cells than the header" in refusal(path)
        return
    recording = read(path)
    np.testing.assert_array_equal(recording.time, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(recording.columns["y"], [0.5, 0.25, -0.001, 0.0])


def test_rows_of_blanks_and_decimal_commas_are_no_rows_of_commas(tmp_path):
    path = csv_file(tmp_path, "0,0 1 0,5", "0,1 2 0,25", "0,2 3 -1e-3", "0,3 4 0")
    reading = Reading(header=False, columns=("t", "u", "y"))
    np.testing.assert_array_equal(read(path, reading).columns["y"], [0.5, 0.25, -0.001, 0.0])
    dated = csv_file(tmp_path, "when,t,u,y", *[f"2024-01-01 10:00:0{k},{row}" for k, row in enumerate(ROWS)])
    np.testing.assert_array_equal(read(dated).time, [0.0, 0.1, 0.2, 0.3])


@pytest.mark.parametrize("head", [["# made by hand", "% 1,2;3", ""], ["sep=;"], ["#", "", "sep=;"]])
def test_lines_before_the_header_are_skipped_and_counted(tmp_path, head):
    lines = [*head, *separated([HEADER, *ROWS], ";")]
    np.testing.assert_array_equal(read(csv_file(tmp_path, *lines)).columns["u"], [1, 2, 3, 4])
    lines[-1] = "0.3;4;broken"
    assert f"line {len(lines)}, column 'y': 'broken'" in refusal(csv_file(tmp_path, *lines))


def test_latin_letters_in_the_header_only(tmp_path):
    path = csv_file(tmp_path, "# 20 °C", "t,u,y,Winkel in °", *[row + ",1" for row in ROWS], encoding="latin-1")
    assert read(path).columns["u"].tolist() == [1, 2, 3, 4]
    assert "not UTF-8 text" in refusal(csv_file(tmp_path, HEADER, *ROWS[:3], "0.3,4,°", encoding="latin-1"))


def test_no_header_line(tmp_path):
    for name in ("recording.csv", "recording.txt"):
        path = csv_file(tmp_path, *ROWS, name=name)
        reading = Reading(header=False, columns=("t", "u", "y"))
        assert read(path, reading).columns["y"].tolist() == [0.5, 0.25, -0.001, 0.0]
        assert read(csv_file(tmp_path, *[r + "," for r in ROWS], name=name), reading).period == pytest.approx(0.1)
    assert "line 1: the first line holds numbers, not names; say header: false and columns:" in refusal(path)
    assert "line 2: the first line holds numbers" in refusal(csv_file(tmp_path, "# a b c", *["1,1,2"] * 4))
    assert "line 1: a line of names (t, u, y) in a file declared to have none; remove header" in refusal(
        csv_file(tmp_path, HEADER, *ROWS), reading
    )
    for columns in (("t", "u"), ("t", "u", "y", "z")):
        message = refusal(csv_file(tmp_path, *ROWS), Reading(header=False, columns=columns))
        assert f"line 1: 3 cells, and {len(columns)} columns are named" in message
    assert "line 3, column 'y': 'x'" in refusal(csv_file(tmp_path, *ROWS[:2], "0.2,3,x", ROWS[3]), reading)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["t;u;y", *ROWS], "line 1: semicolons between the cells, where most lines have commas"),
        ([HEADER, *ROWS[:2], "0.2;3;0.1", ROWS[3]], "line 4: semicolons between the cells, where most lines have com"),
        (["t;u;y", "0,0;1;0,5", "0,1;2;0,5", "0,2,3,0,5"], "line 4: commas between the cells, where most lines have s"),
        ([HEADER, *ROWS[:2], "0.2\t3\t0.1", ROWS[3]], "line 4: tabs between the cells, where most lines have commas"),
        ([HEADER, *ROWS[:3], '0.3,"4,5",0'], "line 5, column 'u': '4,5' where a number should be; write all numbers"),
        (["t;u;y", "0.1;1;0,5", "0.2;1;0,5", "0.3;1;0,5"], "line 2, column 'y': '0,5' where a number should be; write"),
        ([HEADER, *ROWS[:3], '0.3,"1,234.5",0'], "'1,234.5' where a number should be; write the number without marks"),
        (["t;u;y", "0,1;1;5", "0,2;1;0.5", "0,3;1;0,5"], "line 2, column 't': '0,1' where a number should be; write a"),
    ],
)
def test_mixed_separators_and_decimal_marks(tmp_path, lines, said):
    assert said in refusal(csv_file(tmp_path, *lines))


def test_a_late_line_with_other_separators(tmp_path):
    lines = [f"{0.1 * k:.1f},1,2" for k in range(400)]
    lines[350] = lines[350].replace(",", ";")
    message = refusal(csv_file(tmp_path, HEADER, *lines))
    assert "line 352, column 't': '35.0;1;2'" in message
    assert "separate the cells as in the other lines" in message


def test_quoted_decimal_commas_between_commas_if_told(tmp_path):
    lines = [HEADER, *[",".join(f'"{cell}"' for cell in row.replace(".", "_").split(",")) for row in ROWS]]
    path = csv_file(tmp_path, *[line.replace("_", ",") for line in lines])
    assert "'0,0' where a number should be" in refusal(path)
    recording = read(path, Reading(decimal=","))
    np.testing.assert_array_equal(recording.columns["y"], [0.5, 0.25, -0.001, 0.0])


def test_what_is_told_counts(tmp_path):
    path = csv_file(tmp_path, *separated([HEADER, *ROWS], "|"))
    assert "no column 't'" in refusal(path)
    assert read(path, Reading(separator="|")).columns["u"].tolist() == [1, 2, 3, 4]
    assert "no column 't'" in refusal(csv_file(tmp_path, HEADER, *ROWS), Reading(separator=";"))
    for key in ({"separator": ";"}, {"decimal": ","}, {"header": False}, {"group": "run1"}):
        assert f"a DataFrame has no {next(iter(key))}" in refusal(pd.DataFrame({"t": [1.0]}), Reading(**key))
    assert "a text file has no group" in refusal(path, Reading(group="run1"))


def test_empty_columns(tmp_path):
    assert "column 'y' is empty; fill it" in refusal(csv_file(tmp_path, HEADER, *[f"{k},1," for k in range(5)]))
    assert "column 'y' is empty" in refusal(csv_file(tmp_path, HEADER, *[f"{k},1" for k in range(5)]))


@pytest.mark.parametrize(
    "rows",
    [
        ["0,0,1,0,5", "0,1,2,0,25", "0,2,3,0,1"],  # decimal commas in every row
        ["0.0,1,0.5,7", "0.1,2,0.25,7", "0.2,3,0.1,7"],
        ["0.0,1,0.5", "0.1,2,0.25", "0.2,3,0,1", "0.3,4,0"],  # … in one
    ],
)
def test_rows_longer_than_the_header_are_not_cut(tmp_path, rows):
    message = refusal(csv_file(tmp_path, HEADER, *rows))
    assert "more cells than the header" in message or "Expected 3 fields in line 4, saw 4" in message


@pytest.mark.parametrize("header", ["t,u,y,y", "t,u,y, y", '"t",u,y,"y"', "\nt,u,y,y"])
def test_repeated_columns(tmp_path, header):
    assert "two columns are named 'y'" in refusal(csv_file(tmp_path, header, *[r + ",9" for r in ROWS]))


def test_repeated_columns_of_a_table():
    table = pd.DataFrame(np.arange(12.0).reshape(3, 4), columns=["t", "u", "y", "y"])
    assert "two columns are named 'y'" in refusal(table)


@pytest.mark.parametrize(
    ("cell", "shown"),
    [
        ("", "an empty cell"),
        ("nan", "NaN"),
        ("NA", "NaN"),
        ("inf", "'inf'"),
        ("-Infinity", "'-Infinity'"),
        ("1e999", "'1e999'"),
        ("broken", "'broken'"),
        ("True", "'True'"),
        ('"0,5"', "'0,5'"),
        ("1 2", "'1 2'"),
        ("2024-01-01", "'2024-01-01'"),
    ],
)
@pytest.mark.parametrize("column", [0, 2])
def test_a_cell_that_is_no_number_is_named(tmp_path, cell, shown, column):
    cells = ROWS[2].split(",")
    cells[column] = cell
    # Blank lines and a quoted cell over two lines stand before it: the row is line 8 of the file.
    lines = [
        "note," + HEADER,
        '"one\nnote",' + ROWS[0],
        "",
        "  ",
        "x," + ROWS[1],
        "x," + ",".join(cells),
        "x," + ROWS[3],
    ]
    message = refusal(csv_file(tmp_path, *lines))
    assert f"line 7, column '{HEADER.split(',')[column]}'" in message
    assert shown in message


def test_a_comment_with_carriage_returns_is_read(tmp_path):
    """Found by the fuzzer: the csv module refuses them outside of quotes."""
    path = tmp_path / "recording.csv"
    path.write_bytes(b"#\r\r\r,s1\n0.00,1,\x1e\x1e6\n")
    assert "recording.csv" in refusal(path)


def test_a_short_row_is_an_empty_cell(tmp_path):
    message = refusal(csv_file(tmp_path, HEADER, *ROWS, "0.4,5"))
    assert "line 6, column 'y': an empty cell" in message


def test_columns_that_nobody_asked_for_may_hold_anything(tmp_path):
    lines = ["t,u,y,note", *[f"{row},{word}" for row, word in zip(ROWS, ["a", "", "nan", '"b,c"'], strict=True)]]
    assert set(read(csv_file(tmp_path, *lines)).columns) == {"u", "y"}


DATES = [pd.date_range("2024-01-01", periods=4, freq="s"), pd.to_timedelta(np.arange(4), unit="s")]
NO_NUMBERS = [np.array([True, False, True, True]), np.array([1.0, True, 2.0, 3.0], dtype=object), np.arange(4) * 1j]


@pytest.mark.parametrize(("name", "column"), [*product("ty", NO_NUMBERS), *product("y", DATES)])
def test_dates_truth_values_and_complex_numbers_are_no_numbers(name, column):
    table = pd.DataFrame({"t": np.arange(4.0), "u": 1.0, "y": 2.0})
    table[name] = column
    assert f"column '{name}'" in refusal(table)
    assert "where a number should be" in refusal(table)


def recorded(time, folder, form="{!r}"):
    return csv_file(folder, HEADER, *[f"{form.format(float(t))},1,{np.sin(t)}" for t in time])


def test_unsorted_and_repeated_times(tmp_path):
    assert "line 5, column 't': the time goes back from 0.3 s to 0.2 s" in refusal(
        recorded([0.0, 0.1, 0.3, 0.2], tmp_path)
    )
    assert "line 4, column 't': the time 0.1 s appears twice" in refusal(recorded([0.0, 0.1, 0.1, 0.2], tmp_path))


def test_irregular_times(tmp_path):
    time = 0.1 * np.arange(20)
    assert "line 12, column 't': a step of 0.2 s where the others have 0.1 s: a row seems to be missing" in refusal(
        recorded(np.delete(time, 10), tmp_path)
    )
    assert "line 12" in (message := refusal(recorded(np.delete(time, [10, 11, 12]), tmp_path)))
    assert "3 rows seem to be missing" in message
    jittered = read(recorded(time + np.where(np.arange(20) == 7, 1.23e-3, 0.0), tmp_path))
    assert "the times are off a regular grid of 100 ms by 266" in jittered.warnings[0]
    assert "at most 1.1" in jittered.warnings[0]
    assert jittered.recorded_time[7] == pytest.approx(0.70123)
    assert jittered.time[7] == pytest.approx(0.7, abs=1e-4)
    assert read(recorded(time + np.where(np.arange(20) == 7, 5e-8, 0.0), tmp_path)).warnings == ()


@pytest.mark.parametrize("offset", [0.0, -5.0, 1.7e9])
@pytest.mark.parametrize("decimals", [2, 3, 4, 6])
@pytest.mark.parametrize("as_table", [False, True])
def test_rounded_times_are_regular(tmp_path, offset, decimals, as_table):
    time = np.round(offset + np.arange(300) / 30.0, decimals)
    source = recorded(time, tmp_path, f"{{:.{decimals}f}}")
    recording = read(pd.read_csv(source) if as_table else source)
    assert abs(recording.period - 1.0 / 30.0) < 10.0**-decimals / 299
    assert abs(recording.period - 1.0 / 30.0) <= recording.period_uncertainty


@pytest.mark.parametrize("decimals", [1, 2, 3])
@pytest.mark.parametrize("lost", [1, 50, 98])
@pytest.mark.parametrize("rate", [10.0, 30.0])
def test_rounding_hides_no_missing_row(tmp_path, decimals, lost, rate):
    """With one decimal, 0.1 s steps and a missing row look like rounded times to whoever looks at steps alone."""
    time = np.round(np.delete(np.arange(100) / rate, lost), decimals)
    if np.any(np.diff(time) == 0.0):
        assert "appears twice" in refusal(recorded(time, tmp_path))
        return
    assert "column 't': a step of" in refusal(recorded(time, tmp_path, f"{{:.{decimals}f}}"))


def test_whole_seconds_with_a_missing_row(tmp_path):
    assert "line 5, column 't': a step of 2 s" in refusal(recorded([0, 1, 2, 4, 5], tmp_path, "{:.0f}"))


def test_seconds_since_1970(tmp_path):
    time = 1.7e9 + 0.02 * np.arange(500)
    recording = read(recorded(time, tmp_path))
    assert recording.period == pytest.approx(0.02, rel=1e-8)
    assert recording.time[0] == 1.7e9


@pytest.mark.parametrize("name", ["table.csv", "table.parquet"])
def test_tables_are_written_whole_or_not_at_all(tmp_path, name):
    table = pd.DataFrame({"t": 0.1 * np.arange(3), "u": [1.0, 2.0, 3.0], "y": np.pi})
    write_table(table, tmp_path / name)
    np.testing.assert_array_equal(read(tmp_path / name).columns["y"], table["y"])
    before = (tmp_path / name).read_bytes()

    def fails_halfway(path):
        path.write_text("half")
        raise RuntimeError

    with pytest.raises(RuntimeError):
        write_whole(tmp_path / name, fails_halfway)
    assert (tmp_path / name).read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_what_cannot_be_written(tmp_path):
    table = pd.DataFrame({"t": [1.0]})
    with pytest.raises(InputError, match="no such folder"):
        write_table(table, tmp_path / "none" / "table.csv")
    with pytest.raises(InputError, match="this is a folder"):
        write_table(table, tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="a device or a pipe"):
        write_table(table, tmp_path / "pipe")
    assert [p.name for p in tmp_path.iterdir()] == ["pipe"]


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "link.csv").symlink_to(tmp_path / "file.csv")
    write_table(pd.DataFrame({"t": [1.0]}), tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "file.csv").read_text() == "t\n1.0\n"
    write_table(pd.DataFrame({"t": [1.0]}), tmp_path / ("n" * 250 + ".csv"))
