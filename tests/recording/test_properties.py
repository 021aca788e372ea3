"""Text tables and time grids of any kind: what is written is read, and what cannot be read is an InputError."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from camid.errors import InputError
from camid.recording.options import Reading
from camid.recording.read import read_recording
from camid.recording.time_grid import grid_of
from camid.recording.units import Conversion, si_factor

PERIOD = 0.05
numbers = st.floats(-1e9, 1e9, allow_subnormal=False).map(lambda value: round(value, 6))
words = st.text(st.characters(codec="ascii", categories=["L"]), min_size=1, max_size=6)
# Separator between the cells and decimal mark; commas in both would not be told apart.
LAYOUTS = [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ",")]


@st.composite
def tables(draw):
    names = draw(st.lists(words, min_size=2, max_size=3, unique_by=str.lower))
    assume(not {n.lower() for n in names} & {"t", "nan", "inf", "infinity", "none", "null", "na", "true", "false"})
    rows = draw(st.integers(3, 8))
    columns = {name: draw(st.lists(numbers, min_size=rows, max_size=rows)) for name in names}
    return pd.DataFrame({"t": np.round(PERIOD * np.arange(rows), 6), **columns})


@given(
    tables(),
    st.sampled_from(LAYOUTS),
    st.sampled_from(["", "# made by a logger\n", "% x\n\n"]),
    st.sampled_from(["\n", "\r\n"]),
    st.sampled_from(["utf-8", "utf-8-sig"]),
    st.booleans(),
)
@settings(max_examples=80, deadline=None)
def test_a_text_table_is_read_as_it_was_written(tmp_path_factory, table, layout, comment, end, encoding, trailing):
    separator, decimal = layout
    path = tmp_path_factory.getbasetemp() / "table.csv"
    text = table.to_csv(sep=separator, decimal=decimal, index=False, float_format="%.6f", lineterminator="\n")
    if trailing and separator != " ":
        text = text.replace("\n", f"{separator}\n")
    path.write_bytes((comment + text).replace("\n", end).encode(encoding))
    found = read_recording(path, "t", list(table.columns[1:]))
    for name in table.columns[1:]:
        np.testing.assert_allclose(found.columns[name], table[name], rtol=1e-12, atol=1e-9)
    assert found.period == pytest.approx(PERIOD, rel=1e-6)


@given(tables(), st.sampled_from(LAYOUTS))
@settings(max_examples=60, deadline=None)
def test_a_table_without_a_header_is_read_by_the_names_declared(tmp_path_factory, table, layout):
    separator, decimal = layout
    path = tmp_path_factory.getbasetemp() / "bare.txt"
    table.to_csv(path, sep=separator, decimal=decimal, index=False, header=False, float_format="%.6f")
    reading = Reading(header=False, columns=tuple(table.columns), separator=separator, decimal=decimal)
    found = read_recording(path, "t", list(table.columns[1:]), reading=reading)
    for name in table.columns[1:]:
        np.testing.assert_allclose(found.columns[name], table[name], rtol=1e-12, atol=1e-9)
    with pytest.raises(InputError):
        read_recording(path, "t", list(table.columns[1:]))


def reads_or_refuses(path, **options):
    try:
        return read_recording(path, "t", ["u", "y"], **options)
    except InputError as error:
        refusal = str(error)
    assert refusal
    return None


@given(
    st.binary(max_size=300), st.sampled_from([b"", b"t,u,y\n", b"t;u;y\n0;1;2\n", b"PK\x03\x04", b"\x1f\x8b", b"PAR1"])
)
@settings(max_examples=80, deadline=None)
def test_any_bytes_are_read_or_refused(tmp_path_factory, data, head):
    path = tmp_path_factory.getbasetemp() / "junk.csv"
    path.write_bytes(head + data)
    reads_or_refuses(path)


@given(
    st.lists(st.lists(st.sampled_from(["0.1", "1,5", "x", "", "1e3", "nan", '"', "1;2", "-", "1.000,5"]), max_size=4))
)
@settings(max_examples=80, deadline=None)
def test_any_cells_are_read_or_refused(tmp_path_factory, rows):
    path = tmp_path_factory.getbasetemp() / "cells.csv"
    path.write_text("t,u,y\n" + "\n".join(",".join(cells) for cells in rows))
    found = reads_or_refuses(path)
    if found is not None:
        assert all(np.all(np.isfinite(values)) for values in found.columns.values())


@given(
    st.sampled_from(["mm", "deg", "rpm", "mV", "N*m", "m/s^2", "degC"]),
    st.floats(1e-6, 1e6),
    st.floats(-1e6, 1e6),
    st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=5),
)
@settings(deadline=None)  # the first unit loads pint's registry
def test_a_conversion_is_linear_in_the_si_value(unit, scale, offset, cells):
    factor, base = si_factor(unit, "here")
    expected = scale * (factor * np.array(cells) + base) + offset
    size = scale * (np.abs(factor * np.array(cells)) + abs(base)) + abs(offset)  # sums may cancel
    try:
        values = Conversion(unit, scale, offset)(np.array(cells))
    except InputError as error:
        refusal = str(error)
    else:
        refusal = None
        assert np.all(np.abs(values - expected) <= 1e-14 * size)
    assert refusal is None or "makes every number zero" in refusal


@given(st.text(max_size=12))
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_unit_is_a_factor_or_refused(unit):
    try:
        factor, base = si_factor(unit, "here")
    except InputError as error:
        refusal = str(error)
    else:
        refusal = None
        assert np.isfinite(factor)
        assert np.isfinite(base)
    assert refusal is None or refusal.startswith("here: ")


# -- time grids -------------------------------------------------------------------------------------------------------


def row(index):
    return f"row {index}"


starts, periods = st.floats(-1e4, 1e4), st.floats(1e-3, 10.0)


@given(starts, periods, st.integers(2, 200))
def test_regular_times_stay_as_they_are(start, period, count):
    time = start + period * np.arange(count)
    grid = grid_of(time, row)
    assert grid.regular
    np.testing.assert_array_equal(grid.time, time)
    assert grid.period == pytest.approx(period, rel=1e-6 + 1e-11 * abs(start) / period)


@given(st.integers(10, 240), st.integers(3, 5), st.integers(10, 200))
def test_rounded_times_are_regular(rate, decimals, count):
    time = np.round(np.arange(count) / rate, decimals)
    assume(10.0**-decimals <= 0.25 / rate)
    grid = grid_of(time, row)
    assert grid.regular
    # Rounding moves the first and the last time by half a digit each; steps that it makes equal show nothing of it.
    rounding = 10.0**-decimals / (count - 1)
    assert abs(grid.period - 1.0 / rate) <= (grid.uncertainty or rounding) * (1.0 + 1e-9)


@given(starts, periods, st.integers(20, 200), st.floats(0.01, 0.3), st.integers(0, 2**32 - 1))
@settings(deadline=None)
def test_jitter_ends_on_a_grid_as_long_as_the_recording(start, period, count, jitter, seed):
    random = np.random.default_rng(seed)
    time = start + period * (np.arange(count) + jitter * random.uniform(-1.0, 1.0, count))
    grid = grid_of(time, row)
    assert len(grid.time) == count
    assert np.all(np.diff(grid.time) > 0.0)
    assert np.max(np.abs(grid.time - (start + period * np.arange(count)))) < 2.0 * jitter * period
    line = 3.0 + 0.5 * (time - start)
    values, missing = grid.interpolated(line)
    inside = (grid.time >= time[0]) & (grid.time <= time[-1]) & ~missing
    np.testing.assert_allclose(values[inside], (3.0 + 0.5 * (grid.time - start))[inside], rtol=1e-6)


@given(st.lists(st.floats(1e-6, 1e6), min_size=1, max_size=40))
@settings(max_examples=80, deadline=None)
def test_any_increasing_times_have_a_grid_or_are_refused(steps):
    time = np.concatenate([[0.0], np.cumsum(steps)])
    assume(np.all(np.diff(time) > 0.0))
    try:
        grid = grid_of(time, row)
    except InputError as error:
        refusal = str(error)
    else:
        refusal = None
        assert np.all(np.diff(grid.time) > 0.0)
        assert grid.period > 0.0
        assert len(grid.time) <= 100 * len(time)
    assert refusal is None or refusal.startswith("row ")
