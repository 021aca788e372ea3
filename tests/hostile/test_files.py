"""Files that were made to hurt: one line and exit code 2, soon; `make test-faults` gives them gigabytes to unpack."""

import time

import pytest

from camid.cli import main
from camid.recording import size_limits
from camid.recording.units import is_unit
from tests.support import hostile_files
from tests.support import linear_rig as rig
from tests.support.command_lines import contents

# Seconds on a loaded machine; a file that hurts would take minutes, or all memory.
SOON = 60.0


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rig.recording().to_csv("recording.csv", index=False)
    rig.write_yaml(rig.simulation(), tmp_path / "S.yaml")
    return tmp_path


def answer(capfd, arguments):
    """Exit code and lines of the error stream, warnings left out."""
    started = time.perf_counter()
    code = main(arguments)
    assert time.perf_counter() - started < SOON
    out, err = capfd.readouterr()
    assert "Traceback" not in out + err
    return code, [line for line in err.splitlines() if not line.startswith("camid: warning: ")]


def refused(capfd, arguments):
    """Run a command that has to refuse, in one line and without a trace."""
    before = {path: content for path, content in contents().items() if not str(path).startswith("bomb")}
    code, lines = answer(capfd, arguments)
    assert (code, len(lines)) == (2, 1), lines
    assert lines[0].startswith("camid: error: ")
    assert {path: content for path, content in contents().items() if not str(path).startswith("bomb")} == before
    return lines[0]


def test_simulations_that_hurt_are_refused(bench, capfd):
    owned = bench / "owned"
    for name, text in hostile_files.simulations(owned).items():
        (bench / f"{name}.yaml").write_text(text)
        line = refused(capfd, ["identify", "recording.csv", "--simulation", f"{name}.yaml", "--output", "model.yaml"])
        assert f"{name}.yaml" in line
    assert not owned.exists()


SAID = {
    "bomb.csv.gz": "more than 8 MiB of data",
    "bomb.csv.zip": "more than 8 MiB of data",
    "bomb.h5": "more than 8 MiB of data",
    "bomb.mat": "more than 8 MiB of data",
    "bomb.parquet": "more than 8 MiB of data",
    "circle.h5": "groups without end",
    "elsewhere.h5": "y: a link to another file",
    "far.xlsx": "cannot be read as spreadsheet (its reader ends without an answer, as for want of memory)",
    "many-columns.csv": "line 1: 50,000 columns",
    "one-line.csv": "line 2: a line of more than 1,000,000 characters",
    "open-quote.csv": "line 2: a line of more than 1,000,000 characters",
    "pipe.csv": "this is a device or a pipe",
    "virtual.h5": "y: its values are in another file",
    "zeros.csv": "not UTF-8 text",
}


def test_recordings_that_hurt_are_refused(bench, capfd, monkeypatch):
    monkeypatch.setattr(size_limits, "MOST_BYTES", 2**23)
    (bench / "hostile").mkdir()
    found = {}
    for path in hostile_files.recordings(bench / "hostile", unpacked=2**23):
        for arguments in (["identify", str(path), "--simulation", "S.yaml"], ["init", "recording", str(path)]):
            code, lines = answer(capfd, arguments)
            assert code == 0 or (code == 2 and len(lines) == 1), (path, lines)
        found[path.name] = answer(capfd, ["identify", str(path), "--simulation", "S.yaml"])[1][0]
    for name, said in SAID.items():
        assert said in found[name], name


def test_pictures_and_playlists_that_hurt_are_refused(bench, capfd):
    (bench / "videos").mkdir()
    for path in hostile_files.videos(bench / "videos"):
        refused(capfd, ["track", str(path), "--bright", "--frame-rate", "50", "--output", "tracked.csv"])


@pytest.mark.parametrize(
    "unit", ["m**9**9**9", "m ** 9 ** 9 ** 9", "s^99999", "x" * 300_000, "(" * 50 + "m" + ")" * 50]
)
def test_units_that_hurt_are_refused_at_once(unit):
    started = time.perf_counter()
    assert not is_unit(unit)
    assert time.perf_counter() - started < SOON


@pytest.mark.parametrize("unit", ["m/s^2", "m^2 s^-2", "kg*m^2/s^3", "N*m**2"])
def test_units_with_several_powers_are_units(unit):
    assert is_unit(unit)


def test_memory_that_does_not_suffice_is_said(bench, capfd, monkeypatch):
    from camid.recording import experiment_rows

    def too_much(*_):
        raise MemoryError

    monkeypatch.setattr(experiment_rows, "grid_of", too_much)
    line = refused(capfd, ["identify", "recording.csv", "--simulation", "S.yaml", "--output", "model.yaml"])
    assert "there is not enough memory" in line
