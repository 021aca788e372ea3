"""What people see in a terminal: summaries, completion, tables of coefficients, and what is not overwritten."""

import os
import re
import shutil
import subprocess
import sys
from types import SimpleNamespace

import click
import pytest

from camid.cli import cli, main
from camid.diagnosis.diagnosis import Coefficient
from camid.diagnosis.report import summary
from camid.diagnosis.results_folder import RESULTS, write_diagnosis
from camid.errors import InputError
from tests.docs.pages import blocks
from tests.support import ROOT, written_diagnoses
from tests.support import linear_rig as rig

DIAGNOSE = ["diagnose", "recording.csv", "--simulation", "S.yaml", "--output", "out", "--time-limit", "0.5"]
PAGE = ROOT / "docs" / "terminal.md"


@pytest.mark.parametrize("width", ["60", "80", "200"])
def test_no_summary_is_cut(capsys, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    assert main(["--help"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "..." not in printed.replace("[ARGS]...", "")
    for name, command in cli.commands.items():
        assert f"{name} {command.short_help}" in printed


def shown(shell):
    """The line that the page shows for a shell."""
    (line,) = [block.text.strip() for block in blocks(PAGE, "text") if f"{shell}_source" in block.text]
    return line


def test_completion_is_what_the_page_says(tmp_path):
    """The line for bash is run as the page shows it, and completes a command, an option and a file."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("there is no bash")
    line = shown("bash")
    program = tmp_path / "camid"
    program.write_text(f"#!/bin/sh\nexec '{sys.executable}' -m camid \"$@\"\n")
    program.chmod(0o755)
    asked = """
    complete_of() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _camid_completion camid; }
    complete_of camid id; echo "command: ${COMPREPLY[*]}"
    complete_of camid diagnose --tim; echo "option: ${COMPREPLY[*]}"
    complete_of camid order x.csv --hold z; echo "value: ${COMPREPLY[*]}"
    """
    environment = {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    found = subprocess.run(
        [bash, "-c", f"{line}\n{asked}"], env=environment, capture_output=True, text=True, check=True
    )
    assert "command: identify" in found.stdout
    assert "option: --time-limit" in found.stdout
    assert "value: zoh" in found.stdout


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_completion_of_other_shells(shell):
    (variable,) = re.findall(r"_CAMID_COMPLETE=(\w+)", shown(shell))
    environment = {**os.environ, "_CAMID_COMPLETE": variable}
    found = subprocess.run([sys.executable, "-m", "camid"], env=environment, capture_output=True, text=True, check=True)
    assert "_CAMID_COMPLETE" in found.stdout
    assert "camid" in found.stdout


def test_the_largest_order_is_bounded(bench, capsys):
    assert main(["order", "recording.csv", "--largest", "99"]) == 2
    printed, said = capsys.readouterr()
    assert printed == ""
    assert said == "camid: error: the largest order is 99; coefficients of more than 20 mean nothing\n"


@pytest.mark.parametrize("name", [*RESULTS])
@pytest.mark.parametrize("options", [[], ["--no-report"]])
def test_what_camid_did_not_write_is_not_overwritten(bench, capsys, name, options):
    (bench / "out").mkdir()
    (bench / "out" / name).write_text("my own")
    assert main([*DIAGNOSE, *options]) == 2
    printed, said = capsys.readouterr()
    assert printed == ""
    assert said == (
        f"camid: error: out/{name}: camid did not write this file and would overwrite it; move or remove it, or name "
        "another folder\n"
    )
    assert (bench / "out" / name).read_text() == "my own"
    assert os.listdir(bench / "out") == [name]


def test_what_camid_wrote_is_replaced(tmp_path):
    """Whatever an earlier diagnosis said, and files that hold nothing."""
    for verdict in ("explained", "adequate", "unexplained"):
        write_diagnosis(written_diagnoses.diagnosis(verdict), tmp_path / "out")
        assert f'"verdict": "{verdict}"' in (tmp_path / "out" / "diagnosis.json").read_text()
    (tmp_path / "out" / "learned_effect.py").write_text("")
    write_diagnosis(written_diagnoses.diagnosis("explained"), tmp_path / "out")
    (tmp_path / "out" / "improved.yaml").write_text("schema: 1\n")
    with pytest.raises(InputError, match=r"improved\.yaml: camid did not write this file"):
        write_diagnosis(written_diagnoses.diagnosis("explained"), tmp_path / "out")


def test_a_design_overwrites_no_input_of_somebody_else(tmp_path):
    from camid.experiment_design.results_folder import FILES
    from camid.writing import check_folder

    (tmp_path / "input.csv").write_text("t,u\n0,1\n")
    with pytest.raises(InputError, match=r"input\.csv: camid did not write this file"):
        check_folder(tmp_path, FILES)
    (tmp_path / "design.json").write_text('{"experiment": {"frame_rate": 50.0}}')
    check_folder(tmp_path, FILES)
    (tmp_path / "design.json").write_text("{}")
    with pytest.raises(InputError, match=r"design\.json: camid did not write this file"):
        check_folder(tmp_path, FILES)


@pytest.mark.parametrize("verdict", ["adequate", "explained", "partly-explained", "unexplained"])
def test_old_and_new_coefficients_after_every_diagnosis(capsys, monkeypatch, verdict):
    monkeypatch.setenv("COLUMNS", "100")
    fixed = Coefficient("a2", 0.25, 0.25, 0.0, 0.25, 0.0, "s")
    open_one = Coefficient("mass", 1.2, 1.3, float("inf"), 1.25, float("inf"), "kg", declared_by_plant=True)
    loose = Coefficient("a3", 1.0, 0.7418453, 0.29, 0.7418453, 0.29)
    diagnosis = written_diagnoses.diagnosis(verdict)
    diagnosis = SimpleNamespace(coefficients=[*diagnosis.coefficients, fixed, open_one, loose], found=diagnosis)
    changed = written_diagnoses.diagnosis(verdict, coefficients=diagnosis.coefficients)
    summary.print_summary(changed, [])
    rows = {cells[0]: cells[1:] for cells in _rows(capsys.readouterr().out)}
    bent = bool(changed.findings)
    assert rows["b0"][:2] == ["100", "93.2 ± 1.1"]
    assert rows["b0"][2:] == (["100.07 ± 0.42", ""] if bent else [""])
    assert rows["a2"] == ["0.25", "0.25 (fixed)", *(["0.25 (fixed)"] if bent else []), "s"]
    assert rows["mass"][1] == "1.3 (undetermined)"
    assert rows["mass"][-1] == "kg"
    assert rows["a3"][1] == "0.74 ± 0.29"


def _rows(printed):
    return [[cell.strip() for cell in line.strip("│").split("│")] for line in printed.splitlines() if line[:1] == "│"]


@pytest.mark.parametrize("method", ["srivc", "plain-srivc"])
def test_what_is_fixed_is_not_undetermined(bench, capsys, method):
    """Whether the others are determined or not."""
    plant = rig.plant([300.0], [2.0, 6.0, 200.0], free={"numerator": [True], "denominator": [False, False, True]})
    rig.write_yaml(rig.simulation(plant=plant), bench / "S.yaml")
    assert main(["identify", "recording.csv", "--simulation", "S.yaml", "--method", method]) == 0
    rows = {cells[0]: cells[1] for cells in _rows(capsys.readouterr().out)}
    assert rows["a2 · s^2"] == "2 (fixed)"
    assert rows["a1 · s"] == "6 (fixed)"
    assert "±" in rows["a0"]


def test_every_command_is_one_of_click(capsys):
    assert all(isinstance(command, click.Command) and command.short_help for command in cli.commands.values())


@pytest.mark.parametrize("options", [pytest.param([], marks=pytest.mark.slow), ["--json"]])
def test_what_is_compiled_at_first_use_is_said(bench, options):
    """With an empty folder for machine code, and for people and programs alike on the error stream."""
    command = [
        sys.executable,
        "-m",
        "camid",
        "simulate",
        "recording.csv",
        "--simulation",
        "S.yaml",
        "--output",
        "o.csv",
    ]
    environment = {**os.environ, "CAMID_CACHE": str(bench / "machine_code")}
    found = subprocess.run([*command, *options], env=environment, capture_output=True, text=True, check=True)
    assert "camid: compiling the exact simulation, once per installation\n" in found.stderr
    again = subprocess.run([*command, *options], env=environment, capture_output=True, text=True, check=True)
    assert "compiling" not in again.stderr
