"""The commands with a picture: what they print and write, and what they refuse."""

import json

import numpy as np
import pandas as pd
import pytest

from camid.cli import main
from tests.support import linear_rig as rig
from tests.support.command_lines import IDENTIFY, refusal

SIGNATURES = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.fixture
def models(bench):
    """The folder with two models more: an identified one, and one with friction."""
    assert main([*IDENTIFY, "--residuals", "correlations.csv"]) == 0
    friction = {"id": "coulomb-friction", "parameters": {"force": 0.1}}
    rig.write_yaml(rig.simulation(effects=[friction]), bench / "rubbing.yaml")
    return bench


COMMANDS = {
    "compare": ["compare", "recording.csv", "S.yaml", "model.yaml", "rubbing.yaml"],
    "bode": ["bode", "S.yaml", "model.yaml", "rubbing.yaml", "--recording", "recording.csv"],
    "poles": ["poles", "S.yaml", "model.yaml", "rubbing.yaml"],
    "step": ["step", "S.yaml", "model.yaml", "rubbing.yaml", "--amplitude", "0.5"],
    "residuals": ["residuals", "recording.csv", "model.yaml"],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_picture_is_written_with_its_numbers(models, capsys, name):
    capsys.readouterr()
    for suffix, signature in SIGNATURES.items():
        assert main([*COMMANDS[name], "--output", f"picture.{suffix}"]) == 0
        out, err = capsys.readouterr()
        assert err == ""
        assert f"written to picture.{suffix}\nwritten to picture.csv" in out
        assert (models / f"picture.{suffix}").read_bytes().startswith(signature)
    table = pd.read_csv("picture.csv")
    assert len(table) > 5
    assert main([*COMMANDS[name], "--output", "numbers.csv"]) == 0
    pd.testing.assert_frame_equal(pd.read_csv("numbers.csv"), table)
    assert not (models / "numbers.png").exists()
    assert main([*COMMANDS[name], "--output", "numbers.parquet"]) == 0


@pytest.mark.parametrize("name", COMMANDS)
def test_json_is_all_there_is_on_the_output(models, capsys, name):
    capsys.readouterr()
    assert main([*COMMANDS[name], "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    content = json.loads(out, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))
    assert content["schema"] == 1
    assert isinstance(content["remarks"], list)


def test_the_table_has_the_fits(models, capsys):
    capsys.readouterr()
    assert main([*COMMANDS["compare"], "--held-out", "15", "20", "--zoom", "14", "16"]) == 0
    out = capsys.readouterr().out
    assert "held-out rows" in out
    assert main([*COMMANDS["compare"], "--held-out", "15", "20", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["held_out"]["start"] == 15.0
    fits = {row["model"]: row for row in content["fits"]}
    assert set(fits) == {"S.yaml", "model.yaml", "rubbing.yaml"}
    assert f"{fits['model.yaml']['fit']:.2f}" in out
    assert fits["model.yaml"]["fit"] == pytest.approx(90.0, abs=1.0)


def test_residuals_are_those_that_identify_writes(models):
    assert main([*COMMANDS["residuals"], "--output", "again.csv"]) == 0
    found, expected = pd.read_csv("again.csv"), pd.read_csv("correlations.csv")
    pd.testing.assert_frame_equal(found, expected, rtol=1e-6, atol=1e-9)


def test_models_of_one_name_are_told_apart(models, capsys):
    (models / "other").mkdir()
    (models / "other" / "model.yaml").write_bytes((models / "model.yaml").read_bytes())
    assert main(["poles", "model.yaml", "other/model.yaml", "--output", "poles.csv"]) == 0
    assert set(pd.read_csv("poles.csv")["model"]) == {"model.yaml", "other/model.yaml"}


def test_names_with_markup_are_printed_as_they_are(models, capsys):
    (models / "[red]m.yaml").write_bytes((models / "model.yaml").read_bytes())
    capsys.readouterr()
    assert main(["step", "[red]m.yaml", "--output", "$x^{.png"]) == 0
    assert "[red]m.yaml" in capsys.readouterr().out
    assert (models / "$x^{.csv").is_file()


def test_an_earlier_picture_is_replaced_and_a_recording_is_not(models, capsys):
    for _ in range(2):
        assert main(["step", "model.yaml", "--output", "step.png"]) == 0
    pd.DataFrame({"t": np.arange(3.0), "u": 1.0, "y": 0.0}).to_csv("slide.csv", index=False)
    capsys.readouterr()
    said = refusal(capsys, ["step", "model.yaml", "--output", "slide.png"])
    assert "slide.csv: this file holds something else than the numbers of such a picture; remove it" in said
    # The numbers of one picture are not those of another.
    assert "step.csv: this file holds" in refusal(capsys, ["bode", "model.yaml", "--output", "step.svg"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["compare", "recording.csv"], "Missing argument"),
        (["compare", "none.csv", "S.yaml"], "none.csv: no such file"),
        (["compare", "recording.csv", "none.yaml"], "none.yaml: no such file"),
        (["compare", "recording.csv", "S.yaml", "./S.yaml"], "the same model is named twice"),
        (["compare", "recording.csv", "S.yaml", "--held-out", "3", "x"], "'x' is not a valid float"),
        (["compare", "recording.csv", "S.yaml", "--held-out", "nan", "3"], "starts at nan s and ends at 3 s"),
        (["compare", "recording.csv", "S.yaml", "--held-out", "-1e9", "1e9", "--output", "p.png"], "p.png"),
        (["compare", "recording.csv", "S.yaml", "--zoom", "5", "4"], "no two rows lie in the zoomed part"),
        (["compare", "recording.csv", "S.yaml", "--output", "recording.csv"], "--output would overwrite"),
        (["compare", "recording.csv", "S.yaml", "--output", "recording.png"], "--output would overwrite"),
        (["compare", "recording.csv", "S.yaml", "--output", "picture.gif"], "'.gif' is no kind of picture; end it"),
        (["compare", "recording.csv", "S.yaml", "--output", "picture"], "this name has no ending"),
        (["compare", "recording.csv", "S.yaml", "--output", "none/p.png"], "none: no such folder"),
        (["compare", "recording.csv", "recording.csv"], "recording.csv"),
        (["bode"], "Missing argument"),
        (["bode", "S.yaml", "--frequencies", "1", "0"], "frequencies from 1 to 0 rad/s; give two positive"),
        (["bode", "S.yaml", "--segment", "3"], "a segment is one of a recording; name the recording"),
        (["bode", "S.yaml", "--camera"], "S.yaml, sensor: the exposure is the period, which no model states"),
        (["bode", "S.yaml", "--recording", "none.csv"], "none.csv: no such file"),
        (["bode", "S.yaml", "--recording", "recording.csv", "--output", "recording.svg"], "would overwrite"),
        (["poles", "none.yaml"], "none.yaml: no such file"),
        (["poles", "recording.csv"], "recording.csv"),
        (["step", "S.yaml", "--amplitude", "0"], "a step of 0; give a number other than zero"),
        (["step", "S.yaml", "--duration", "-1"], "a duration of -1 s; give a positive number"),
        (["residuals", "recording.csv"], "Missing argument"),
        (["residuals", "recording.csv", "recording.csv", "S.yaml"], "the same recording is named twice"),
        (["residuals", "none.csv", "S.yaml"], "none.csv: no such file"),
        (["residuals", "recording.csv", "S.yaml", "--output", "."], "this name has no ending"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(bench, capsys, arguments, said):
    if "p.png" in arguments:  # what is there is a folder
        (bench / "p.png").mkdir()
    assert said in refusal(capsys, arguments)


@pytest.mark.parametrize(
    "changes",
    [
        {"plant": rig.plant([1.0], [1.0, -3.0, 100.0])},
        {"plant": {"transfer_function": {"numerator": "lots", "denominator": [1.0]}}},
        {"effects": [{"id": "coulomb-friction", "parameters": {"force": "much"}}]},
        {"sensor": {"column": "y", "kind": "camera", "latency": -1.0}},
    ],
)
@pytest.mark.parametrize("name", COMMANDS)
def test_wrong_simulations_are_refused_in_one_line(bench, capsys, name, changes):
    rig.write_yaml(rig.simulation(**changes), bench / "S.yaml")
    arguments = [a for a in COMMANDS[name] if a not in {"rubbing.yaml", "model.yaml"}]
    arguments += ["S.yaml"] if name == "residuals" else []
    assert "S.yaml" in refusal(capsys, [*arguments, "--output", "picture.png"])
