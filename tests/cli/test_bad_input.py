"""Recordings that people really have: answered with a result and a warning, or with a line that says what to do."""

import numpy as np
import pandas as pd
import pytest

from camid.cli import main
from tests.support import linear_rig as rig
from tests.support.command_lines import IDENTIFY, SIMULATE, load, refusal, replaced


def answer(capsys, arguments):
    """Run a command that has to succeed; what it printed and what it warned of."""
    assert main(arguments) == 0, capsys.readouterr().err
    return capsys.readouterr()


def change(**columns):
    """Rewrite the recording with other columns."""
    recording = pd.DataFrame(np.loadtxt("recording.csv", delimiter=",", skiprows=1), columns=["t", "u", "y"])
    recording.assign(**columns).to_csv("recording.csv", index=False)


def test_noise_is_said_to_be_noise(bench, capsys):
    change(y=np.random.default_rng(1).standard_normal(len(rig.recording())))
    err = answer(capsys, IDENTIFY).err
    assert "the model explains 0." in err
    assert "% of the output's variance, next to nothing" in err


def test_a_good_model_is_not_said_to_explain_nothing(bench, capsys):
    assert answer(capsys, IDENTIFY).err == ""


def test_five_rows_for_four_unknowns_are_few(bench, capsys):
    pd.read_csv("recording.csv")[:5].to_csv("recording.csv", index=False)
    assert "5 samples for 4 unknowns are few" in answer(capsys, IDENTIFY).err


@pytest.mark.parametrize("command", [IDENTIFY, SIMULATE])
@pytest.mark.parametrize(
    ("scale", "said"),
    [
        (1e200, "e+200 is too large to be squared"),
        (1e-200, "recording.csv, column 'y': all numbers are below 1e-70, too small to be squared"),
        (1e-310, "recording.csv, column 'y': all numbers are below 1e-70, too small to be squared"),
    ],
)
def test_numbers_that_cannot_be_squared_are_named(bench, capsys, command, scale, said):
    change(y=scale * pd.read_csv("recording.csv")["y"])
    message = refusal(capsys, command)
    assert said in message
    assert "choose another unit, or say scale: for column 'y' in the simulation" in message


def test_a_spike_is_named_with_its_row(bench, capsys):
    y = pd.read_csv("recording.csv")["y"]
    change(y=y.where(y.index != 100, 1e300).map(str).str.replace("1e+300", "1E0300"))  # as it is written
    assert "recording.csv, line 102, column 'y': 1E0300 is too large to be squared" in refusal(capsys, IDENTIFY)


def test_what_the_refusal_proposes_works(bench, capsys):
    """The output in a unit of 1e200: with its scale declared it is what it was."""
    change(y=1e200 * pd.read_csv("recording.csv")["y"])
    sensor = rig.simulation()["sensor"]
    rig.write_yaml(rig.simulation(sensor={**sensor, "scale": 1e-200}), bench / "S.yaml")
    answer(capsys, IDENTIFY)
    found = load(bench / "model.yaml")["plant"]["transfer_function"]
    assert found["numerator"] == pytest.approx([300.0], rel=0.05)


@pytest.mark.parametrize("scale", [1e69, 1e-69])
def test_every_scale_that_is_accepted_gives_the_same_plant(bench, capsys, scale):
    answer(capsys, IDENTIFY)
    usual = load(bench / "model.yaml")["plant"]["transfer_function"]
    table = pd.read_csv("recording.csv")
    change(u=scale * table["u"], y=scale * table["y"])
    answer(capsys, IDENTIFY)
    scaled = load(bench / "model.yaml")["plant"]["transfer_function"]
    for part in ("numerator", "denominator"):
        assert scaled[part] == pytest.approx(usual[part], rel=1e-6)


def test_a_high_order_is_refused_without_a_word_of_the_linear_algebra(bench, capfd):
    assert main(["identify", "recording.csv", "--order", "60", "0"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err == "camid: error: options: 60 poles; coefficients of more than 20 mean nothing\n"
    assert main(["order", "recording.csv", "--largest", "99"]) == 2
    assert capfd.readouterr().err.endswith("the largest order is 99; coefficients of more than 20 mean nothing\n")


def test_the_highest_order_is_answered(bench, capfd):
    """Nothing but our own lines, whatever the linear algebra meets on the way."""
    code = main(["identify", "recording.csv", "--order", "20", "0"])
    out, err = capfd.readouterr()
    assert code in {0, 2}
    assert "On entry to" not in out + err


@pytest.mark.parametrize("form", ["isoformat", "__str__"])
def test_dates_of_iso_8601_are_times(bench, capsys, form):
    seconds = pd.read_csv("recording.csv")["t"].round(9)  # 0.15000000000000002 has no date
    change(t=list(seconds))
    answer(capsys, IDENTIFY)
    usual = load(bench / "model.yaml")["plant"]
    dates = pd.Timestamp("2026-05-31T13:45:00") + pd.to_timedelta(seconds, unit="s")
    change(t=[getattr(date, form)() for date in dates])
    assert "its times are seconds after 2026-05-31" in answer(capsys, IDENTIFY).err
    assert load(bench / "model.yaml")["plant"] == usual


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_other_encodings_are_read(bench, capsys, encoding):
    answer(capsys, IDENTIFY)
    usual = load(bench / "model.yaml")
    text = (bench / "recording.csv").read_text(encoding="utf-8")
    (bench / "recording.csv").write_text(text, encoding=encoding)
    answer(capsys, IDENTIFY)
    assert load(bench / "model.yaml") == usual


def test_utf_16_without_its_mark_is_refused_with_what_to_do(bench, capsys):
    text = (bench / "recording.csv").read_text(encoding="utf-8")
    (bench / "recording.csv").write_bytes(text.encode("utf-16-le"))
    assert "so save it as UTF-8" in refusal(capsys, IDENTIFY)


def test_what_a_coefficient_has_to_be_is_said(bench, capsys):
    plant = {"transfer_function": {"numerator": "lots", "denominator": [1.0, 2.0]}}
    rig.write_yaml(rig.simulation(plant=plant), bench / "S.yaml")
    assert "'lots' is not a list; expected: a list in brackets, such as [1.0, 2.0]" in refusal(capsys, IDENTIFY)


@pytest.mark.parametrize("state", ["zero", "estimate"])
def test_an_input_of_zeros_is_a_free_decay(bench, capsys, state):
    """Of a plant of 10 rad/s and 0.15, let go."""
    time = rig.recording()["t"].to_numpy()
    motion = np.exp(-1.5 * time) * np.cos(np.sqrt(100.0 - 1.5**2) * time)
    change(u=0.0, y=motion + 0.001 * np.random.default_rng(3).standard_normal(len(time)))
    rig.write_yaml(rig.simulation(initial_state=state), bench / "S.yaml")
    assert "column 'u' is zero throughout: read as a free decay" in answer(capsys, IDENTIFY).err
    found = load(bench / "model.yaml")
    assert found["input"] is None
    denominator = found["plant"]["transfer_function"]["denominator"]
    assert denominator == pytest.approx([2.0, 6.0, 200.0], rel=0.02)


def test_an_order_alone_of_an_input_of_zeros_is_refused(bench, capsys):
    change(u=0.0)
    arguments = [*replaced(IDENTIFY, "--simulation", "--order", "S.yaml", "2")[:4], "0", "--output", "model.yaml"]
    assert "a free decay does not determine the numerator" in refusal(capsys, arguments)
