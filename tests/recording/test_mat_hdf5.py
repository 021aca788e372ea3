"""MAT and HDF5 files written by others: which variables are columns, and what is said of those that are none."""

import gzip
import os
import zipfile

import h5py
import numpy as np
import pandas as pd
import pyarrow
import pyarrow.parquet
import pytest
from scipy.io import savemat

from camid.errors import InputError
from camid.recording.options import Reading
from camid.recording.read import read_recordings

T, U, Y = 0.1 * np.arange(50), np.sin(np.arange(50.0)), np.cos(np.arange(50.0))
GOOD = {"t": T, "u": U, "y": Y}


def read(path, group=None, columns=("u", "y"), **keys):
    return read_recordings(path, "t", columns, reading=Reading(group=group, **keys), holds={columns[0]: "zoh"})


def refusal(path, group=None, columns=("u", "y"), **keys):
    with pytest.raises(InputError) as caught:
        read(path, group, columns, **keys)
    message = str(caught.value)
    assert message.startswith((str(path), "simulation, recording"))
    assert "\n" not in message
    return message


def mat5(path, content):
    savemat(path, content)


def mat4(path, content):
    savemat(path, content, format="4")


def hdf5(path, content):
    def fill(node, part):
        for name, value in part.items():
            if isinstance(value, dict):
                fill(node.create_group(name), value)
            else:
                node[name] = value

    with h5py.File(path, "w") as file:
        fill(file, content)


def mat73(path, content):
    """As MATLAB lays it out: 512 bytes before the HDF5, axes reversed, the class of each variable as an attribute."""
    classes = {"f": b"double", "b": b"logical", "U": b"char", "c": b"double"}

    def fill(node, part):
        for name, value in part.items():
            if isinstance(value, dict):
                group = node.create_group(name)
                group.attrs["MATLAB_class"] = np.bytes_(b"struct")
                fill(group, value)
                continue
            array = np.asarray(value)
            stored = np.atleast_2d(array.T) if array.ndim != 1 else array[None, :]
            if array.dtype.kind == "U":
                stored = np.array([[ord(c)] for c in value], np.uint16)
            if array.dtype.kind == "b":
                stored = stored.astype(np.uint8)
            if array.dtype.kind == "c":
                pairs = np.zeros(stored.shape, [("real", float), ("imag", float)])
                pairs["real"], pairs["imag"] = stored.real, stored.imag
                stored = pairs
            dataset = node.create_dataset(name, data=stored)
            dataset.attrs["MATLAB_class"] = np.bytes_(classes[array.dtype.kind])

    with h5py.File(path, "w", userblock_size=512) as file:
        fill(file, content)
    with path.open("r+b") as stream:
        text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 ."
        stream.write(text.ljust(116) + bytes(8) + b"\x00\x02IM")


def parquet(path, content):
    pyarrow.parquet.write_table(pyarrow.table(content), path)


WRITERS = {"5.mat": mat5, "4.mat": mat4, "73.mat": mat73, "a.h5": hdf5, "a.hdf5": hdf5}
GROUPED = {name: writer for name, writer in WRITERS.items() if name != "4.mat"}


@pytest.fixture(params=WRITERS)
def write(request, tmp_path):
    return lambda content: WRITERS[request.param](tmp_path / request.param, content) or tmp_path / request.param


@pytest.fixture(params=GROUPED)
def write_groups(request, tmp_path):
    return lambda content: GROUPED[request.param](tmp_path / request.param, content) or tmp_path / request.param


@pytest.mark.parametrize("shape", [(50,), (50, 1), (1, 50)])
def test_columns_in_every_orientation(write, shape):
    (found,) = read(write({k: v.reshape(shape) for k, v in GOOD.items()}))
    np.testing.assert_array_equal(found.time, T)
    np.testing.assert_array_equal(found.columns["u"], U)
    np.testing.assert_array_equal(found.columns["y"], Y)


def test_parquet_of_another_writer(tmp_path):
    parquet(tmp_path / "a.parquet", {**GOOD, "note": ["x"] * 50})
    np.testing.assert_array_equal(read(tmp_path / "a.parquet")[0].columns["y"], Y)


def test_variables_of_other_lengths_are_ignored_unless_asked_for(write):
    path = write(GOOD | {"kp": 3.0, "other": np.arange(7.0), "wide": np.ones((50, 2))})
    assert set(read(path)[0].columns) == {"u", "y"}
    assert "'other' has 7 values, and 't' has 50; name columns of one length" in refusal(path, columns=("u", "other"))
    assert "'kp' is a single value" in refusal(path, columns=("kp", "y"))
    assert "no column 'v'; known here: other, t, u, wide[0], wide[1], y" in refusal(path, columns=("v", "y"))


def test_columns_of_a_matrix(write):
    both = np.column_stack([U, Y])
    for table in (both, both.T):
        (found,) = read(write({"t": T, "x": table}), columns=("x[0]", "x[1]"))
        np.testing.assert_array_equal(found.columns["x[1]"], Y)
    said = "'x' is a matrix of 2 columns, which are counted from 0: name one of them, x[0] (the first), x[1] (the last)"
    assert said in refusal(write({"t": T, "x": both}), columns=("x[0]", "x"))


@pytest.mark.parametrize(
    ("value", "said"), [(Y > 0.0, "truth values"), (Y + 1j, "complex"), ("word", "text"), ({"y": Y}, "a group")]
)
def test_variables_that_are_no_numbers(write_groups, value, said):
    assert f"'y' is {said}" in refusal(write_groups(GOOD | {"y": value})).replace("made of ", "")


def test_a_group_and_groups_of_experiments(write_groups):
    runs = {f"run{k}": {"t": T, "u": U * k, "y": Y, "fs": 10.0} for k in (10, 9, 2)}
    path = write_groups({"data": runs, "note": {"gain": 3.0}, "one": GOOD})
    assert read(path, "one")[0].experiment is None
    for name in ("data/run9", "data.run9"):
        np.testing.assert_array_equal(read(path, name)[0].columns["u"], 9 * U)
    found = read(path, "data")
    assert [r.experiment for r in found] == ["run2", "run9", "run10"]  # numbers count as numbers
    assert found[2].source == f"{path}, data/run10"
    np.testing.assert_array_equal(found[2].columns["u"], 10 * U)
    assert "nothing here is a column of numbers; it takes vectors of real numbers (groups: one;" in refusal(path)
    assert "no group 'dat'; did you mean 'data'?" in refusal(path, "dat")
    assert "no group 'data/run'; did you mean 'run9'?" in refusal(path, "data/run").replace("run2", "run9")
    assert "'one/u' is a variable and no group" in refusal(path, "one/u")
    assert "note: nothing here is a column of numbers" in refusal(path, "note")
    assert "has no header" in refusal(path, "one", header=False)
    assert "has no separator" in refusal(path, "one", separator=",")


def test_one_of_several_groups_without_a_column(write_groups):
    path = write_groups({"data": {"a": GOOD, "b": {"t": T, "y": Y}}})
    assert "data/b: no column 'u'" in refusal(path, "data")


def test_an_array_of_structures_holds_experiments(tmp_path):
    array = np.zeros((1, 2), dtype=[(name, object) for name in GOOD])
    for k in range(2):
        array[0, k] = (T[: 50 - k], U[: 50 - k], Y[: 50 - k])
    savemat(tmp_path / "runs.mat", {"runs": array})
    assert [len(r) for r in read(tmp_path / "runs.mat", "runs")] == [50, 49]
    assert len(read(tmp_path / "runs.mat", "runs/[1]")[0]) == 49


def test_a_compound_dataset_is_a_group(tmp_path):
    rows = np.rec.fromarrays([T, U, Y], names="t,u,y")
    hdf5(tmp_path / "a.h5", {"log": rows})
    np.testing.assert_array_equal(read(tmp_path / "a.h5", "log")[0].columns["y"], Y)


@pytest.mark.parametrize(
    ("writer", "name", "said"),
    [
        (mat5, "a.csv", "this is a MAT file, although its name ends in .csv; rename it to .mat"),
        (mat73, "a.h5", "this is a MAT file, although its name ends in .h5"),
        (hdf5, "a.mat", "this is an HDF5 file, although its name ends in .mat; rename it to .h5"),
        (parquet, "a.txt", "this is a Parquet file, although its name ends in .txt; rename it to .parquet"),
        (hdf5, "a.xlsx", "this is no spreadsheet, although its name ends in .xlsx; rename it"),
    ],
)
def test_suffixes_that_lie(tmp_path, writer, name, said):
    writer(tmp_path / name, GOOD)
    assert said in refusal(tmp_path / name)


def test_a_file_without_a_suffix_is_known_by_its_content(tmp_path):
    hdf5(tmp_path / "log", GOOD)
    np.testing.assert_array_equal(read(tmp_path / "log")[0].columns["y"], Y)


@pytest.mark.parametrize("kept", [0, 60, 300, 2000])
@pytest.mark.parametrize("name", ["5.mat", "73.mat", "a.h5"])
def test_damaged_files(tmp_path, name, kept):
    WRITERS[name](tmp_path / name, GOOD)
    os.truncate(tmp_path / name, kept)
    assert "cannot be read as" in refusal(tmp_path / name)


def test_packed_text(tmp_path):
    frame = pd.DataFrame(GOOD)
    frame.to_csv(tmp_path / "a.csv.gz", index=False)
    frame.to_csv(tmp_path / "a.zip", index=False, compression={"method": "zip", "archive_name": "a.csv"})
    for name in ("a.csv.gz", "a.zip"):
        np.testing.assert_array_equal(read(tmp_path / name)[0].columns["y"], Y)
    with zipfile.ZipFile(tmp_path / "two.zip", "w") as archive:
        archive.writestr("a.csv", "t,u,y")
        archive.writestr("b.csv", "t,u,y")
    assert "2 files in an archive; unpack it" in refusal(tmp_path / "two.zip")
    with zipfile.ZipFile(tmp_path / "book.csv", "w") as archive:
        archive.writestr("xl/workbook.xml", "")
    assert "this is a spreadsheet, although its name ends in .csv; rename it to .xlsx" in refusal(tmp_path / "book.csv")
    mat5(tmp_path / "a.mat", GOOD)
    (tmp_path / "a.mat.gz").write_bytes(gzip.compress((tmp_path / "a.mat").read_bytes()))
    assert "what is packed is not a text file" in refusal(tmp_path / "a.mat.gz")
    os.truncate(tmp_path / "a.csv.gz", 30)
    assert "cannot be unpacked" in refusal(tmp_path / "a.csv.gz")


@pytest.mark.parametrize("key", ["unit", "units"])
def test_units_in_the_attributes_of_a_dataset(tmp_path, key):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, values, unit in (("t", 1e3 * T, "ms"), ("u", U, "no unit"), ("y", Y, np.bytes_(b"mm"))):
            file[name] = values
            file[name].attrs[key] = unit
    (found,) = read_recordings(tmp_path / "a.h5", "t", ["u", "y"], holds={"u": "zoh"})
    assert found.period == pytest.approx(0.1)
    np.testing.assert_allclose(found.columns["y"], 1e-3 * Y)
    np.testing.assert_array_equal(found.columns["u"], U)
    assert "column 'y [mm]' is read in mm, as its header says" in " ".join(found.warnings)
