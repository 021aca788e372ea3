"""Several runs in a file: side by side, and in cells and nested structures."""

import h5py
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from camid.errors import InputError
from camid.recording.mat_hdf5 import layouts, tables_of
from camid.recording.options import Reading
from tests.support.recordings import COUNT, T, U, Y, cells, check_one_line, read, refusal

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
