"""What the commands refuse: exit code 2, one line, and files that are left alone."""

import os

import pandas as pd
import pytest

import camid
from camid.errors import InputError
from tests.support import linear_rig as rig
from tests.support.command_lines import IDENTIFY, SIMULATE, refusal, replaced


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (replaced(IDENTIFY, "recording.csv", "none.csv"), "none.csv: no such file"),
        (replaced(SIMULATE, "recording.csv", "none.csv"), "none.csv: no such file"),
        (replaced(IDENTIFY, "S.yaml", "none.yaml"), "none.yaml: no such file"),
        (replaced(SIMULATE, "recording.csv", "."), ".: this is a folder"),
        ([*SIMULATE, "--effects", "none.py"], "none.py: no such file"),
        ([*IDENTIFY, "--effects", "."], ".: this is a folder"),
        ([*SIMULATE, "--effects", "S.yaml"], "S.yaml: this is no Python file"),
        ([*SIMULATE[:-1], "S.csv", "--effects", "S.csv"], "S.csv: no such file"),
        (replaced(SIMULATE, "S.yaml", "."), ".: this is a folder"),
        (replaced(SIMULATE, "recording.csv", "n" * 300), "File name too long"),
        (replaced(SIMULATE, "S.yaml", "n" * 300), "File name too long"),
        (replaced(SIMULATE, "simulated.csv", "n" * 300), "File name too long"),
        (replaced(SIMULATE, "recording.csv", "two\nlines"), "two?lines: no such file"),
        (replaced(SIMULATE, "simulated.csv", "recording.csv"), "recording.csv: --output would overwrite"),
        (replaced(SIMULATE, "simulated.csv", "./S.yaml"), "S.yaml: --output would overwrite"),
        (replaced(IDENTIFY, "model.yaml", "S.yaml"), "S.yaml: --output would overwrite"),
        (replaced(IDENTIFY, "model.yaml", "recording.csv"), "recording.csv: --output would overwrite"),
        (replaced(IDENTIFY, "model.yaml", "none/model.yaml"), "none: no such folder"),
        (replaced(SIMULATE, "simulated.csv", "none/simulated.csv"), "none: no such folder"),
        (replaced(IDENTIFY, "model.yaml", "."), ".: this is a folder"),
        (replaced(SIMULATE, "simulated.csv", ""), "this is a folder"),
        (["diagnose", "recording.csv", "--simulation", "S.yaml", "--output", "o", "--effort", "nan"], "nan is no"),
        (["design", "S.yaml", "--output", "o", "--time-limit", "nan"], "nan is no"),
        (["identify", "recording.csv"], "neither --simulation nor --order is given"),
        ([*IDENTIFY, "--order", "2", "0"], "--order and --simulation contradict each other"),
        ([*IDENTIFY, "--hold", "foh"], "--hold and --simulation contradict each other"),
        ([*IDENTIFY, "--initial-state", "zero"], "--initial-state and --simulation contradict each other"),
        (["identify", "recording.csv", "--order", "-1", "0"], "order -1 0 is improper"),
        (["identify", "recording.csv", "--order", "0", "0"], "order 0 0 is improper"),
        (["identify", "recording.csv", "--order", "2", "-1"], "order 2 -1 is improper"),
        (["identify", "recording.csv", "--order", "1", "2"], "order 1 2 is improper"),
        (["identify", "recording.csv", "--order", "2"], "--order"),
        (["identify", "recording.csv", "--order", "2", "x"], "'x' is not a valid integer"),
        (["identify", "recording.csv", "--order", "300", "200"], "fewer than needed for 501 parameters"),
        (["identify", "recording.csv", "--order", "2", "0", "--output-column", "x"], "no column 'x'"),
        (["identify", "recording.csv", "--order", "2", "0", "--output-column", "u"], "input and output are the same"),
        (["identify", "recording.csv", "--order", "2", "0", "--output-column", "t"], "time and output are the same"),
        (["identify", "recording.csv", "--order", "2", "0", "--exposure", "0"], "--exposure 0; it takes a positive"),
        (["identify", "recording.csv", "--order", "2", "0", "--exposure", "nan"], "--exposure nan"),
        (["identify", "recording.csv", "--order", "2", "0", "--exposure", "0.06"], "is longer than the period"),
        (["identify", "recording.csv", "--order", "2", "0", "--latency", "-1"], "--latency -1; it takes a zero or"),
        (["identify", "recording.csv", "--order", "2", "0", "--latency", "1e300"], "is longer than recording.csv"),
        (
            ["identify", "recording.csv", "--order", "2", "0", "--sensor", "instant", "--exposure", "0.01"],
            "no exposure",
        ),
        (["identify", "recording.csv", "--order", "2", "0", "--method", "magic"], "'magic' is not one of"),
        ([*IDENTIFY, "--colour", "red"], "--colour"),
        ([*IDENTIFY, "--residuals", "model.yaml"], "--output and --residuals are the same file"),
        ([*IDENTIFY, "--residuals", "./model.yaml"], "--output and --residuals are the same file"),
        ([*IDENTIFY, "--residuals", "recording.csv"], "recording.csv: --residuals would overwrite"),
        ([*IDENTIFY, "--residuals", "none/residuals.csv"], "none: no such folder"),
        (["identify", "recording.csv", "recording.csv", "--order", "2", "0"], "the same recording is named twice"),
        (["order", "recording.csv", "--largest", "0"], "the largest order is 0"),
        (["order", "recording.csv", "--largest", "x"], "'x' is not a valid integer"),
        (["order", "none.csv"], "none.csv: no such file"),
        (["order", "recording.csv", "--input-column", "v"], "say --time-column, --input-column, --output-column"),
        (["order", "recording.csv", "--simulation", "S.yaml", "--hold", "foh"], "--hold and --simulation contradict"),
        (["order", "recording.csv", "--output", "recording.csv"], "recording.csv: --output would overwrite"),
        (["order", "recording.csv", "--output", "none/table.csv"], "none: no such folder"),
        (["order", "recording.csv", "--output", "t.xyz"], "t.xyz: '.xyz' is no kind of table; end it with .csv"),
        (replaced(SIMULATE, "simulated.csv", "simulated"), "simulated: this name has no ending"),
        (["simulate", "recording.csv", "--simulation", "S.yaml"], "Missing option '--output'"),
        (["simulate"], "Missing argument"),
        (["divine", "recording.csv"], "divine"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(bench, capsys, arguments, said):
    (bench / "model.yaml").write_text("older result")
    (bench / "simulated.csv").write_text("older result")
    assert said in refusal(capsys, arguments)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"initial_stat": "zero"}, "S.yaml, line"),
        (
            {"sensor": {"column": "y", "kind": "camera", "exposure": 0.051}},
            "S.yaml, sensor: exposure = 0.051 s is longer",
        ),
        (
            {"sensor": {"column": "y", "kind": "camera", "latency": 30.0}},
            "S.yaml, sensor: latency = 30 s is longer than",
        ),
        ({"input": {"column": "", "hold": "zoh"}}, "recording.csv: no column ''"),
        ({"time": {"column": "two\nlines"}}, "no column 'two?lines'"),
        ({"sensor": {"column": "t", "kind": "camera"}}, "S.yaml: time and output are the same column 't'"),
        ({"input": {"column": "y", "hold": "zoh"}}, "S.yaml: input and output are the same column 'y'"),
        (
            {"controller": {"reference": "r", "position_gain": 1.0, "velocity_gain": 1.0}},
            "recording.csv: no column 'r'",
        ),
        ({"plant": rig.plant([1.0], [1.0, -3.0, 100.0])}, "unstable: poles at 1.5"),
        ({"input": {"column": ["u", "v"], "hold": "zoh"}}, "input: camid identifies one input and one output"),
        ({"sensor": {"column": ["y", "z"], "kind": "camera"}}, "sensor: camid identifies one input and one output"),
    ],
)
@pytest.mark.parametrize("command", [IDENTIFY, SIMULATE])
def test_wrong_simulations_are_refused_in_one_line(bench, capsys, command, changes, said):
    (bench / command[-1]).write_text("older result")
    rig.write_yaml(rig.simulation(**changes), bench / "S.yaml")
    assert said in refusal(capsys, command)


@pytest.mark.parametrize(
    "changes", [{"time": {"column": "simulated"}}, {"sensor": {"column": "simulated", "kind": "camera"}}]
)
def test_no_recorded_column_is_lost_to_the_result(bench, capsys, changes):
    table = pd.read_csv("recording.csv")
    table.assign(simulated=table["t"]).to_csv("recording.csv", index=False)
    rig.write_yaml(rig.simulation(**changes), bench / "S.yaml")
    assert "S.yaml: a recorded column is called 'simulated' like the result" in refusal(capsys, SIMULATE)


def test_a_unit_that_a_header_gave_the_times_is_named(bench, capsys):
    pd.read_csv("recording.csv").rename(columns={"t": "t [ms]"}).to_csv("recording.csv", index=False)
    rig.write_yaml(rig.simulation(sensor={"column": "y", "kind": "camera", "exposure": 0.04}), bench / "S.yaml")
    said = refusal(capsys, ["identify", "recording.csv", "--simulation", "S.yaml"])
    assert "exposure = 0.04 s is longer than the period of 5e-05 s" in said
    assert "the times are read in ms, as their header says: declare another unit under time" in said


@pytest.mark.parametrize("command", [IDENTIFY, SIMULATE])
def test_a_bad_cell_is_refused_in_one_line(bench, capsys, command):
    lines = (bench / "recording.csv").read_text().splitlines()
    lines[100] = lines[100].rpartition(",")[0] + ",broken"
    (bench / "recording.csv").write_text("\n".join(lines))
    (bench / command[-1]).write_text("older result")
    assert "recording.csv, line 101, column 'y': 'broken' where a number should be" in refusal(capsys, command)


def test_the_output_may_not_be_an_input_by_another_name(bench, capsys):
    (bench / "link.csv").symlink_to("recording.csv")
    assert "would overwrite" in refusal(capsys, replaced(SIMULATE, "simulated.csv", "link.csv"))
    os.mkfifo("pipe")
    assert "a device or a pipe" in refusal(capsys, replaced(SIMULATE, "simulated.csv", "pipe"))


def test_nothing_is_written_if_there_is_no_residual(bench, capsys):
    """The folder of one of two outputs is missing: neither is written."""
    arguments = [*IDENTIFY, "--residuals", "none/residuals.csv"]
    assert "none: no such folder" in refusal(capsys, arguments)
    assert not (bench / "model.yaml").exists()


def test_an_order_is_not_chosen_beside_effects(bench, capsys):
    effects = [{"id": "dead-zone", "parameters": {"half_width": 0.1}}]
    rig.write_yaml(rig.simulation(effects=effects), bench / "S.yaml")
    message = refusal(capsys, ["order", "recording.csv", "--simulation", "S.yaml"])
    assert "remove the effects" in message
    assert "S.yaml, line" in message
    with pytest.raises(InputError, match="an order is chosen, and this simulation has effects"):
        camid.identify("recording.csv", "S.yaml", structure=(2, 0))
