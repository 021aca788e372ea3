"""``camid design``: its folder, its formats, and one line for what is wrong."""

import json
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pandas as pd
import pytest
from jsonschema import Draft202012Validator
from ruamel.yaml import YAML

import camid
from camid.cli import main
from camid.diagnosis.results_folder import write_diagnosis
from camid.experiment_design.prediction import NoiseModel, responses
from camid.experiment_design.quick import with_designed_experiments
from camid.experiment_design.results_folder import input_text, write_design
from camid.experiment_design.run import determined_by
from camid.experiment_design.words import NOTHING_TELLS, described, deviations_shown, sentence
from camid.number_text import SPACE
from tests.experiment_design.test_design import believed, hypothesis, steps
from tests.support.mass_on_spring import effect

SCHEMA = json.loads(files("camid").joinpath("schemas/design.schema.json").read_text(encoding="utf-8"))
QUICK = ["--amplitude", "-1", "1", "--duration", "4", "--frame-rate", "50", "--noise", "0.02"]


@pytest.fixture
def bench(tmp_path, monkeypatch, diagnosis, first):
    """A folder with a recording, its diagnosis and two simulations, and the current one."""
    monkeypatch.chdir(tmp_path)
    first.to_csv("first.csv", index=False)
    write_diagnosis(diagnosis, "diagnosis", report=False)
    for name, content in (
        ("friction", believed(effect("coulomb-friction", force=0.1))),
        ("drag", believed(effect("quadratic-drag", coefficient=0.005))),
    ):
        with open(f"{name}.yaml", "w", encoding="utf-8") as file:
            YAML().dump(content, file)
    return tmp_path


@pytest.mark.slow
def test_the_folder_of_a_design(bench, capsys):
    assert main(["design", "diagnosis", "--output", "next", "--duration", "4", "--time-limit", "0"]) == 0
    printed = capsys.readouterr().out
    assert "What to expect" in printed
    assert "written to next/input.csv" in printed
    assert sorted(p.name for p in (bench / "next").iterdir()) == ["design.json", "design.png", "input.csv"]
    content = json.loads((bench / "next/design.json").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(SCHEMA)
    Draft202012Validator(SCHEMA).validate(content)
    table = pd.read_csv(bench / "next/input.csv")
    assert list(table.columns) == ["t", "u"]
    assert len(table) == content["experiment"]["rows"] == 200
    np.testing.assert_allclose(np.diff(table["t"]), 0.02, rtol=1e-9)
    low, high = content["limits"]["amplitude"].values()
    assert low <= table["u"].min() < table["u"].max() <= high
    evidence = content["evidence"]
    assert evidence["delta_bic_per_second"] == pytest.approx(evidence["delta_bic"] / 4.0)
    assert {"gain-asymmetry", "input-bias"} <= {name["if_right"] for name in evidence["names"]}
    assert all(d["std_after"] < d["std_before"] for d in content["parameters"] if d["name"] == "gain-asymmetry ratio")


@pytest.mark.slow
def test_the_input_alone(bench, capsys):
    options = ["--duration", "2", "--time-limit", "0"]
    # An input is written over, a recording is not.
    (bench / "next.csv").write_text("t,u\n0,0\n", encoding="utf-8")
    assert main(["design", "diagnosis", "--output", "next.csv", *options]) == 0
    assert "written to next.csv" in capsys.readouterr().out
    assert main(["design", "diagnosis", "--output", "next", "--no-picture", *options]) == 0
    assert (bench / "next.csv").read_bytes() == (bench / "next/input.csv").read_bytes()
    for source in (["next.csv", "drag.yaml"], ["friction.yaml", "drag.yaml", "--recording", "next.csv"]):
        assert main(["design", *source, "--output", "next.csv"]) == 2
        assert "--output would overwrite what it is made from" in capsys.readouterr().err


def test_two_simulations_as_hypotheses_and_json(bench, capsys):
    command = ["design", "friction.yaml", "drag.yaml", "--output", "next", *QUICK, "--no-picture", "--json"]
    assert main(command) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((bench / "next/design.json").read_text(encoding="utf-8"))
    assert {h["id"] for h in printed["hypotheses"]} == {"friction.yaml", "drag.yaml"}
    assert printed["evidence"]["delta_bic"] > 50.0
    assert not (bench / "next/design.png").exists()


@pytest.mark.slow
def test_two_simulations_after_a_recording(bench):
    """Fitted to it first: friction and drag of a rig that has neither are small, and hard to tell apart."""
    found = camid.design(["friction.yaml", "drag.yaml"], recording="first.csv", duration=4.0, time_limit=None)
    free = camid.design(
        ["friction.yaml", "drag.yaml"], amplitude=(-1, 1), duration=4.0, frame_rate=50.0, noise=0.02, time_limit=None
    )
    assert 0.0 <= found.evidence < 0.2 * free.evidence


def test_an_input_is_written_in_the_units_of_its_column(diagnosis, bench):
    """Cells in millivolts for a simulation in volts: limits and file are in millivolts."""
    content = believed(effect("coulomb-friction", force=0.1), input={"column": "u", "hold": "zoh", "unit": "mV"})
    other = believed(effect("quadratic-drag", coefficient=0.005), input={"column": "u", "hold": "zoh", "unit": "mV"})
    # Any input will do: the search ends after a second.
    options = {"duration": 4.0, "frame_rate": 50.0, "noise": 0.02, "time_limit": 1.0}
    found = camid.design([content, other], amplitude=(-1000.0, 1000.0), rate=50_000.0, **options)
    signal = found.played.signal
    assert 0.05 < np.max(np.abs(signal)) <= 1.0
    assert np.max(np.abs(np.diff(signal, prepend=0.0))) <= 50.0 * 0.02 + 1e-6
    cells = np.array([float(line.split(",")[1]) for line in input_text(found).splitlines()[1:]])
    np.testing.assert_allclose(cells, 1000.0 * signal, rtol=1e-5, atol=1e-6)


def test_deviations_are_shown_in_the_units_of_the_files():
    """As the diagnosis shows them beside a travel in millimetres; files hold SI units."""
    spring = hypothesis(
        "cubic-stiffness",
        effect("cubic-stiffness", coefficient=1e6),
        plant={"numerator": [0.6], "denominator": [1.0, 2.0, 100.0]},
        input={"column": "u", "hold": "zoh", "unit": "V"},
        sensor={"column": "y", "kind": "camera", "unit": "mm"},
    )
    small = NoiseModel(1e-5, np.ones(1))
    determined = determined_by(responses([spring], steps(), small)[0])
    found = {d.name: deviations_shown(d, spring.simulation) for d in determined}
    assert found["b0"][1].startswith("600.")
    assert {name: unit.replace(SPACE, " ") for name, (*_, unit) in found.items()} == {
        "b0": "mm/(V s²)",
        "a1": "s⁻¹",
        "a0": "s⁻²",
        "cubic-stiffness coefficient": "V/mm³",
        "offset": "mm",
    }


def test_a_sentence_for_a_report(design):
    soon = [replace(e, seconds=1.0) for e in design.expectations]
    said = sentence(replace(design, expectations=soon))
    assert said.startswith("Play ")
    assert "Expected if it is " in said
    assert "95 % after about" in said
    assert "longer than" not in said
    assert "\n" not in said


def test_a_sentence_says_what_stays_open(design):
    """Each likely name has its own number; a time beyond the experiment is called one."""
    late = [replace(e, seconds=2.0 * design.duration) for e in design.expectations]
    assert "longer than this experiment" in sentence(replace(design, expectations=late))
    one, *others = [replace(e, seconds=1.0) for e in design.expectations]
    some = sentence(replace(design, expectations=[replace(one, seconds=None, weight=0.4), *others]))
    assert some.startswith("Play ")
    assert "its weight 40 % afterwards, and never 95 %" in some.replace(SPACE, " ")
    never = [replace(e, seconds=None, evidence=3.0) for e in design.expectations]
    said = sentence(replace(design, expectations=never))
    assert said.startswith("No experiment that was looked at decides within the limits of the recording")
    nothing = [replace(e, evidence=1e-3) for e in never]
    assert sentence(replace(design, expectations=nothing)).startswith(NOTHING_TELLS)


def test_the_report_of_a_diagnosis_promises_what_is_there(diagnosis):
    """Of a recording with one input, that a design needs to be told more; of names that are one, that they are."""
    plain = replace(diagnosis, findings=[replace(diagnosis.findings[0], separating_experiment="Record more.")])
    (designed,) = with_designed_experiments(plain).findings
    assert designed.separating_experiment.startswith("Play ")
    assert "which may be another input" in designed.separating_experiment
    conditions = replace(diagnosis.conditions, signal=(1.0, 1.0))
    (still,) = with_designed_experiments(replace(plain, conditions=conditions)).findings
    assert still.separating_experiment.startswith(
        "Record more. camid design on this folder computes one once it is told"
    )
    assert "the input can only be 1 u; give two limits with --amplitude" in still.separating_experiment


def test_nothing_is_written_where_a_limit_is_refused(bench, capsys):
    assert main(["design", "diagnosis", "--output", "next", "--travel", "0.5", "0.6"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("camid: error: diagnosis: the rig rests at")
    assert not (bench / "next").exists()


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["design", "nowhere", "--output", "next"], "nowhere"),
        (["design", ".", "--output", "next"], "no diagnosis.json"),
        (["design", "first.csv", "--output", "next", *QUICK], "first.csv"),
        (["design", "diagnosis", "--output", "first.csv"], "first.csv: this is a file with other columns"),
        (["design", "friction.yaml", "drag.yaml", "--output", "drag.yaml"], "this is a file"),
        (["design", "diagnosis", "--output", "no/where.csv"], "no such folder"),
        (["design", "diagnosis", "--output", "no/where"], "no such folder"),
        (["design", "friction.yaml", "drag.yaml", "--output", "next"], "--frame-rate"),
        (["design", "friction.yaml", "friction.yaml", "--output", "next", *QUICK], "named twice"),
    ],
)
def test_what_is_wrong_is_one_line(bench, capsys, command, said):
    assert main(command) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error
    assert not (bench / "next").exists()


def test_a_diagnosis_of_an_earlier_version_says_what_to_do(bench, capsys):
    path = bench / "diagnosis/diagnosis.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({k: v for k, v in content.items() if k != "hypotheses"}), encoding="utf-8")
    assert main(["design", "diagnosis", "--output", "next"]) == 2
    assert "diagnose again" in capsys.readouterr().err
    path.write_text("{", encoding="utf-8")
    assert main(["design", "diagnosis", "--output", "next"]) == 2
    assert "no JSON" in capsys.readouterr().err


def test_the_same_bytes_again(diagnosis, design, tmp_path):
    for name in ("one", "two"):
        write_design(design, tmp_path / name)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()


def test_simulations_of_one_structure_are_refused(bench, capsys):
    with open("stiffer.yaml", "w", encoding="utf-8") as file:
        YAML().dump(believed(effect("coulomb-friction", force=0.3)), file)
    assert main(["design", "friction.yaml", "stiffer.yaml", "--output", "next", *QUICK]) == 2
    said = capsys.readouterr().err
    assert "friction.yaml and stiffer.yaml are the same law with other values" in said
    assert not (bench / "next").exists()


def test_the_folder_of_a_diagnosis_is_no_folder_for_a_design(bench, capsys):
    assert main(["design", "diagnosis", "--output", "diagnosis"]) == 2
    assert "this folder holds a diagnosis; name another one for the design" in capsys.readouterr().err
    assert not (bench / "diagnosis/input.csv").exists()


def test_what_is_one_is_counted_as_one():
    assert described("multisine", {"lines": 1, "lowest_frequency": 0.5}) == "multisine (1 line, from 0.5 Hz)".replace(
        " Hz", f"{SPACE}Hz"
    )
