"""What ``camid diagnose`` refuses: one line, exit code 2, and nothing half-written."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.cli import INTERRUPTED, main
from camid.diagnosis.results_folder import FILES, write_diagnosis
from camid.errors import InputError
from tests.support import linear_rig as rig
from tests.support import written_diagnoses
from tests.support.mass_on_spring import effect, record, simulation

COMMAND = ["diagnose", "recording.csv", "--simulation", "S.yaml", "--output", "found"]
SIMULATE = ["simulate", *COMMAND[1:-1], "found.csv"]


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    """A whole diagnosis, so that no test's command is the first one and says that it compiles."""
    camid.diagnose(record(count=200), simulation())


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with a recording and the simulation that fits it."""
    monkeypatch.chdir(tmp_path)
    record(count=200).to_csv("recording.csv", index=False)
    rig.write_yaml(simulation(), tmp_path / "S.yaml")
    return tmp_path


def everything():
    """Content of all files below the current folder."""
    return {str(p): p.read_bytes() if p.is_file() else None for p in sorted(Path().rglob("*"))}


def refusal(capsys, arguments=COMMAND):
    """Message of a command that has to fail and to leave everything as it was."""
    before = everything()
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("camid: error: ")
    assert (err.count("\n"), err[-1]) == (1, "\n")
    assert everything() == before
    return err


def known(identifier, **parameters):
    return {"effects": [{"id": identifier, "parameters": parameters}]}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (known("coulomb-fricton", force=0.1), "no effect 'coulomb-fricton'; did you mean 'coulomb-friction'?"),
        (
            known("magic", force=0.1),
            "no effect 'magic'; an effect of your own needs its file: --effects FILE.py; known",
        ),
        (known("coulomb-friction", forces=0.1), "no parameter 'forces'; did you mean 'force'?"),
        (known("absolute-value", size=0.1), "absolute-value has no parameter 'size'; it has none"),
        (known("coulomb-friction"), "coulomb-friction needs the parameter 'force'"),
        (known("coulomb-friction", force=-0.1), "coulomb-friction, force = -0.1; it must be at least 0"),
        (known("dropped-frames", fraction=1.5), "fraction = 1.5; it must be from 0 to 1"),
        (known("coulomb-friction", force="big"), "'big' is not a finite number"),
        (known("coulomb-friction", force=[1.0]), "[1.0] is not a finite number"),
        (known("coulomb-friction", force=None), "None is not a finite number"),
        (known("coulomb-friction", force=True), "True is not a finite number"),
        (known("input-hold", hold="cubic"), "input-hold, hold: 'cubic' is not one of zoh, foh"),
        ({"effects": 2 * known("dead-zone", half_width=0.1)["effects"]}, "the effect 'dead-zone' is declared twice"),
    ],
)
@pytest.mark.parametrize("command", [COMMAND, SIMULATE], ids=["diagnose", "simulate"])
def test_wrong_effects(folder, capsys, command, changes, said):
    rig.write_yaml(simulation(**changes), folder / "S.yaml")
    message = refusal(capsys, command)
    assert said in message
    assert message.startswith("camid: error: S.yaml, line ")


@pytest.mark.parametrize("command", [COMMAND, SIMULATE], ids=["diagnose", "simulate"])
def test_an_effect_without_meaning_for_the_plant(folder, capsys, command):
    """Friction on a plant whose motion jumps with the input."""
    plant = rig.plant([1.0, 2.0, 100.0], [1.0, 2.0, 100.0])
    rig.write_yaml(simulation(plant=plant, **known("coulomb-friction", force=0.1)), folder / "S.yaml")
    message = refusal(capsys, command)
    assert "coulomb-friction depends on a motion that jumps with the input" in message
    assert "S.yaml, line" in message


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"plant": rig.plant([2.0], [1.0])}, "S.yaml: the plant has no dynamics"),
        ({"plant": rig.plant([2.0], [1.0, -3.0, 100.0])}, "unstable: poles at 1.5"),
        ({"input": None}, "S.yaml: without input and at rest nothing moves; set initial_state: estimate"),
        ({"validation": {"start": 90.0, "end": 99.0}}, "no row of the recording lies between 90 s and 99 s"),
        ({"validation": {"start": 0.0, "end": 99.0}}, "leave no row to fit"),
        ({"sensor": {"column": "y", "kind": "camera", "exposure": 0.03}}, "longer than the period"),
        ({"sensor": {"column": "z", "kind": "camera"}}, "no column 'z'"),
        ({"time": {"column": "u"}, "input": {"column": "u", "hold": "zoh"}}, "time and input are the same column"),
    ],
)
def test_wrong_simulations(folder, capsys, changes, said):
    rig.write_yaml(simulation(**changes), folder / "S.yaml")
    assert said in refusal(capsys)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t.iloc[:99], "99 samples are too few to diagnose a plant of 3 unknowns; record at least 100"),
        (lambda t: t.assign(y=2.0), "column 'y' is constant"),
        (lambda t: t.assign(y=t["y"].where(t.index != 7)), "column 'y'"),
        (lambda t: t.assign(u=t["u"].where(t.index != 7)), "recording.csv, line 9, column 'u'"),
        (lambda t: t.drop(index=7), "a row seems to be missing"),
        (lambda t: t.assign(t=t["t"].iloc[::-1].to_numpy()), "the time goes back"),
        (lambda t: t.assign(y=np.inf), "column 'y'"),
    ],
)
def test_wrong_recordings(folder, capsys, change, said):
    change(pd.read_csv("recording.csv")).to_csv("recording.csv", index=False)
    message = refusal(capsys)
    assert said in message
    assert "recording.csv" in message


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ("S.yaml", "S.yaml: this is a file; name a folder for the results"),
        ("no/folder", "no: no such folder; make it, or write elsewhere"),
        ("occupied", "report.html: this is a folder"),
        ("own", "diagnosis.json would overwrite what it is made from"),
    ],
)
def test_wrong_outputs(folder, capsys, output, said):
    (folder / "occupied" / "report.html").mkdir(parents=True)
    (folder / "own").mkdir()
    (folder / "own" / "diagnosis.json").write_bytes((folder / "S.yaml").read_bytes())
    arguments = [*COMMAND[:-1], output]
    if output == "own":
        arguments[3] = "own/diagnosis.json"
    assert said in refusal(capsys, arguments)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_without_the_right_to_write(folder, capsys):
    (folder / "found").mkdir(mode=0o500)
    assert "found: no permission to write here" in refusal(capsys)


def test_the_same_recording_twice(folder, capsys):
    arguments = [*COMMAND[:2], "./recording.csv", *COMMAND[2:]]
    assert "the same recording is named twice" in refusal(capsys, arguments)


def test_recordings_of_different_columns(folder, capsys):
    pd.read_csv("recording.csv").rename(columns={"y": "z"}).to_csv("second.csv", index=False)
    assert "second.csv: no column 'y'" in refusal(capsys, [*COMMAND[:2], "second.csv", *COMMAND[2:]])


def test_no_file_is_written_if_one_cannot_be_made(tmp_path, monkeypatch):
    def broken(diagnosis):
        raise RuntimeError("no picture")

    monkeypatch.setattr("camid.diagnosis.report.page.render", broken)
    with pytest.raises(RuntimeError):
        write_diagnosis(written_diagnoses.diagnosis("explained"), tmp_path / "found")
    assert not (tmp_path / "found").exists()


def test_a_full_disk_is_said_with_what_was_written_before(tmp_path, monkeypatch):
    """The third file fails: the first two are whole, the others are those of before."""
    folder = tmp_path / "found"
    write_diagnosis(written_diagnoses.diagnosis("adequate"), folder)
    older = {name: (folder / name).read_bytes() for name in FILES}
    written = Path.write_bytes

    def full(path, data):
        if path.suffix == ".csv":
            written(path, data[:10])
            raise OSError(28, "No space left on device")
        return written(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError) as caught:
        write_diagnosis(written_diagnoses.diagnosis("explained"), folder)
    assert "No space left on device" in str(caught.value)
    assert "written before: diagnosis.json, improved.yaml" in str(caught.value)
    assert sorted(p.name for p in folder.iterdir()) == sorted(FILES)
    assert [(folder / name).read_bytes() == older[name] for name in FILES] == [False, False, True, True]


def test_no_report_of_an_earlier_diagnosis_stays(tmp_path):
    write_diagnosis(written_diagnoses.diagnosis("adequate"), tmp_path / "found")
    (tmp_path / "found" / "learned_effect.py").write_text("# what an earlier camid diagnose learned\n")
    for report, expected in ((True, FILES), (False, FILES[:3])):
        written = write_diagnosis(written_diagnoses.diagnosis("explained"), tmp_path / "found", report=report)
        assert [p.name for p in written] == list(expected)
        assert sorted(p.name for p in (tmp_path / "found").iterdir()) == sorted(expected)


def test_the_recording_is_a_table_or_a_path():
    with pytest.raises(InputError, match="no recording is given"):
        camid.diagnose([], simulation())


@pytest.mark.parametrize(
    "step",
    ["commands.diagnose.investigate", "diagnosis.results_folder.residuals", "diagnosis.results_folder.write_whole"],
)
def test_an_interrupt_leaves_nothing_half_written(folder, capsys, monkeypatch, step):
    """Ctrl-C while it is computed, while the files are made and while they are written."""

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"camid.{step}", interrupted)
    assert main(COMMAND) == INTERRUPTED
    out, err = capsys.readouterr()
    assert out == ""
    assert err.strip() == "camid: interrupted; no file is half-written"
    assert [p for p in folder.rglob("*") if p.is_file() and p.parent != folder] == []


def test_as_many_zeros_as_poles(folder, capsys):
    """Identified and simulated as it is; a diagnosis needs a velocity, and says what gives it one."""
    biproper = rig.plant([1.0, 2.0, 100.0], [1.0, 2.0, 60.0])
    rig.write_yaml(simulation(plant=biproper), folder / "S.yaml")
    message = refusal(capsys)
    assert message.startswith("camid: error: S.yaml, plant: ")
    assert "as many zeros as poles" in message
    assert "add a fast pole" in message
    assert "remove the effect" not in message


@pytest.mark.slow  # the fast pole makes the steps of the integrator short
def test_the_advice_for_as_many_zeros_as_poles_is_right():
    """With a fast pole the diagnosis finds what the actuator does, and nothing else."""
    plant = TransferFunction((1.0, 2.0, 100.0), (1.0, 2.0, 60.0))
    recorded = record(effect("dead-zone", half_width=0.3), plant=plant, noise=0.002, count=250)
    denominator = np.polymul(plant.denominator, [1.0 / 250.0, 1.0]).tolist()
    fast = {"numerator": list(plant.numerator), "denominator": denominator}
    found = camid.diagnose(recorded, simulation(plant={"transfer_function": fast}))
    assert (found.verdict, [f.identifier for f in found.findings]) == ("explained", ["dead-zone"])
    half_width = found.findings[0].parameters["half_width"]
    assert abs(half_width.value - 0.3) < 4.0 * half_width.standard_deviation < 0.05
