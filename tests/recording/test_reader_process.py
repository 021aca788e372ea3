"""Readers in a process of their own: whatever becomes of it, there is one line."""

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from camid.errors import InputError
from camid.recording import reader_process
from camid.recording.files import read_tables
from camid.recording.options import Reading


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as written:
        written["t"], written["y"] = np.arange(5.0), np.arange(5.0) ** 2
    return path


def refusal(path):
    with pytest.raises(InputError) as raised:
        read_tables(path, ("t", "y"), Reading())
    return str(raised.value)


def test_a_reader_that_ends_its_process_is_said(file, tmp_path, monkeypatch):
    ends = tmp_path / "ends"
    ends.write_text("#!/bin/sh\nkill -SEGV $$\n")
    ends.chmod(0o700)
    monkeypatch.setattr(reader_process.sys, "executable", str(ends))
    assert "r.h5: cannot be read as HDF5 (its reader ends without an answer" in refusal(file)


def test_a_reader_that_does_not_end_is_said(file, monkeypatch):
    monkeypatch.setattr(reader_process, "MOST_TIME", 0.001)
    assert "cannot be read as HDF5 (it takes more than 0.001 s)" in refusal(file)


def test_nothing_is_imported_from_the_folder_of_the_call(file, monkeypatch):
    (file.parent / "pickle.py").write_text("raise SystemExit(7)\n")
    monkeypatch.chdir(file.parent)
    (table,) = read_tables("r.h5", ("t", "y"), Reading())
    np.testing.assert_array_equal(table.columns["y"], np.arange(5.0) ** 2)


def test_what_a_reader_refuses_names_the_file_as_it_was_given(file, tmp_path, monkeypatch):
    with h5py.File(file, "a") as written:
        written["elsewhere"] = h5py.ExternalLink("other.h5", "/t")
    monkeypatch.chdir(tmp_path)
    assert refusal("r.h5").startswith("r.h5")


def test_mat_variables_come_through(tmp_path):
    savemat(tmp_path / "r.mat", {"t": np.arange(4.0), "y": np.arange(4.0) + 1.0, "on": np.array([True, False] * 2)})
    (table,) = read_tables(tmp_path / "r.mat", ("t", "y"), Reading())
    np.testing.assert_array_equal(table.columns["y"], np.arange(4.0) + 1.0)
