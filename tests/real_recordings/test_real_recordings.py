"""Names on excerpts of real recordings, and what must not change them."""

import copy
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

import camid
from camid.identification.from_recordings import load_recordings
from camid.real_recordings.download import BENCHMARK_RECORDINGS, FOLDER_VARIABLE, SILVERBOX_PERIOD, SILVERBOX_TRAINING
from camid.real_recordings.drawing import SIGNALS, draw
from camid.real_recordings.laws import Law
from camid.real_recordings.page import _parameter, page
from camid.real_recordings.results import SPECIFIC, Results
from camid.simulation.file import load_simulation
from camid.workflow.tolerances import compare, without_targets
from tests.support import ROOT

SHIFT = 1234.5  # seconds
# A millimetre a metre, and a force in another unit; both signs turned.
OUTPUT_FACTOR, INPUT_FACTOR = -1e3, -0.4


def recording(name: str) -> Path:
    """Path of a real recording; skips where it is not at hand."""
    folder = os.environ.get(FOLDER_VARIABLE)
    if not folder:
        pytest.skip(f"{FOLDER_VARIABLE} is not set")
    path = Path(folder) / BENCHMARK_RECORDINGS[name].file
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    return path


def simulation(name: str) -> dict[str, Any]:
    """Nominal simulation of the workflow, for a table that is cut already."""
    content = YAML(typ="safe").load(ROOT / f"config/simulations/{name}.yaml")
    content.pop("recording", None)
    content.pop("validation", None)
    return content


@dataclass
class Case:
    """An excerpt and its simulation, as they are and in other words."""

    table: pd.DataFrame
    believed: dict[str, Any]
    other_table: pd.DataFrame
    other_believed: dict[str, Any]


def silverbox() -> Case:
    first = SILVERBOX_TRAINING[0]
    table = pd.read_csv(recording("silverbox"), index_col=False)[["V1", "V2"]].iloc[first : first + 5000]
    table = table.reset_index(drop=True)
    table.insert(0, "t", np.arange(len(table)) * SILVERBOX_PERIOD)
    believed = simulation("silverbox")
    believed["time"] = {"column": "t"}
    other = copy.deepcopy(believed)
    other["time"]["column"], other["input"]["column"], other["sensor"]["column"] = "clock", "drive", "deflection"
    gain = other["plant"]["transfer_function"]["numerator"]
    other["plant"]["transfer_function"]["numerator"] = [b * OUTPUT_FACTOR / INPUT_FACTOR for b in gain]
    return Case(table, believed, _other(table, ["clock", "drive", "deflection"]), other)


def _other(table: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    """Time, input and output (and a reference like the output) shifted, scaled, turned and renamed."""
    factors = [1.0, INPUT_FACTOR, OUTPUT_FACTOR, OUTPUT_FACTOR][: len(names)]
    changed = pd.DataFrame({n: f * table[c] for n, f, c in zip(names, factors, table.columns, strict=True)})
    changed[names[0]] += SHIFT
    return changed


def emps() -> Case:
    from pymatreader import read_mat

    content = read_mat(str(recording("emps")))
    believed = simulation("emps")
    table = pd.DataFrame({c: content[c][:9000] for c in ("t", "vir", "qm", "qg")})
    # What the file's time steps say beyond the microsecond is rounding, and a shift would round it anew.
    table["t"] = np.arange(len(table)) * 1e-3
    table["vir"] *= believed["input"].pop("scale")
    other = copy.deepcopy(believed)
    other["time"]["column"], other["input"]["column"], other["sensor"]["column"] = "clock", "drive", "deflection"
    gain = other["plant"]["transfer_function"]["numerator"]
    other["plant"]["transfer_function"]["numerator"] = [b * OUTPUT_FACTOR / INPUT_FACTOR for b in gain]
    loop = other["controller"]
    loop["reference"] = "wanted"
    loop["velocity_gain"] *= INPUT_FACTOR / OUTPUT_FACTOR
    loop["limit"] *= abs(INPUT_FACTOR)
    return Case(table, believed, _other(table, ["clock", "drive", "deflection", "wanted"]), other)


def pendulum() -> Case:
    table = pd.read_csv(recording("pendulum_decay"), header=None, names=["t", "angle", "rate"])
    # Half of the rows show as much: 75 Hz of a motion of 0.9 Hz.
    table = table[(table["t"] >= 30.0) & (table["t"] <= 40.0)].iloc[::2].reset_index(drop=True)
    other = simulation("pendulum_decay")
    other["time"]["column"], other["sensor"]["column"] = "clock", "deflection"
    other["sensor"]["unit"] = "deg"
    other["plant"]["pendulum"]["rest"] *= -1.0
    turned = pd.DataFrame({"clock": table["t"] + SHIFT, "deflection": -np.rad2deg(table["angle"])})
    return Case(table, simulation("pendulum_decay"), turned, other)


CASES = {
    "silverbox": (silverbox, {"input-hold", "cubic-stiffness"}),
    "emps": (emps, {"coulomb-friction"}),
    "pendulum": (pendulum, {"coulomb-friction"}),
}


# `make check` holds the diagnoses of the whole recordings against their tolerances.
@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=pytest.mark.slow) for name in ("pendulum", "silverbox", "emps")],
)
def diagnosed(request):
    """A case, what has to be named, and its diagnosis."""
    make, expected = CASES[request.param]
    case = make()
    return case, expected, camid.diagnose(case.table, case.believed)


def names(diagnosis: Any) -> list[str]:
    """Identifiers of what a diagnosis found."""
    return sorted(f.identifier for f in diagnosis.findings)


def test_excerpt_is_named_rightly(diagnosed):
    _, expected, diagnosis = diagnosed
    assert expected <= set(names(diagnosis))


def test_names_do_not_depend_on_units_signs_columns_and_the_clock(diagnosed):
    case, _, diagnosis = diagnosed
    assert names(camid.diagnose(case.other_table, case.other_believed)) == names(diagnosis)


def test_improved_simulation_is_adequate(diagnosed):
    case, _, diagnosis = diagnosed
    again = camid.diagnose(case.table, diagnosis.improved)
    assert (again.verdict, again.findings) == ("adequate", [])


def test_sensor_without_sign_is_named_on_an_excerpt():
    """Six of ten seconds; the lag beside it is that of the actuator or a delay, which six seconds cannot tell apart."""
    from pymatreader import read_mat

    content = read_mat(str(recording("coupled_drives")))
    table = pd.DataFrame({c: content[c][:300] for c in ("u1", "z1")})
    diagnosis = camid.diagnose(table, simulation("coupled_drives"))
    assert names(diagnosis)[0] == "absolute-value"
    assert diagnosis.fit.improved < 0.33


@pytest.mark.parametrize(
    ("name", "counts"),
    [("pendulum2_decay", [5554]), ("coupled_drives", [500]), ("cascaded_tanks", [1024, 1024])],
)
def test_files_are_read_as_the_simulations_of_the_workflow_say(name, counts):
    believed = load_simulation(ROOT / f"config/simulations/{name}.yaml")
    found = load_recordings(recording(name), believed, output_needed=True)
    assert [len(one) for one in found] == counts


def two_records() -> Results:
    """Two recordings of six rows, the second of which is fitted in its first two rows; nothing is named."""
    table = pd.DataFrame({"recording": np.repeat([1, 2], 6), "t": np.tile(4.0 * np.arange(6), 2)})
    table["recorded"] = np.tile(np.arange(6.0), 2)
    for model, error in (("nominal", 3.0), ("refitted", 1.0), ("improved", 1.0)):
        residual = np.where(table["recording"] == 1, 10.0, error * np.where(table["t"] < 8.0, 7.0, 1.0))
        table[model] = table["recorded"] - residual
        table[f"residual_{model}"] = residual
    table["fitted"] = ((table["recording"] == 1) | (table["t"] < 8.0)).astype(int)
    anything: Any = None
    return Results("cascaded_tanks", Path(), anything, anything, {"effects": []}, {}, table)


def test_validation_record_is_scored_on_rows_that_were_not_fitted():
    scores = {name: value for name, value, _, _ in SPECIFIC["cascaded_tanks"](two_records())}
    unseen = {name: value for name, value in scores.items() if name.startswith("validation")}
    assert unseen == pytest.approx({"validation_nominal": 3.0, "validation_refitted": 1.0, "validation_improved": 1.0})
    # Two of its six rows, with errors of seven, were fitted.
    assert scores["whole_validation_improved"] == pytest.approx(np.sqrt((2 * 49.0 + 4 * 1.0) / 6))


def test_last_recording_is_drawn_and_equal_curves_once(monkeypatch):
    import matplotlib.pyplot as plt

    monkeypatch.setitem(SIGNALS, "cascaded_tanks", ("level (V)", 1.0, (8.0, 20.0)))
    none = np.zeros(0)
    figure = draw(two_records(), Law(none, none, none, none, {}, "level (V)", "residual (V)", "where the rest sits"))
    above, _, below = figure.axes
    assert [line.get_label() for line in above.lines] == ["recorded", "refitted"]
    assert above.get_title() == "12 s of 20 s (not fitted), between the dashed lines below"
    first, last, residual = below.lines
    assert (first.get_xdata()[0], last.get_xdata()[0]) == (8.0, 20.0)
    assert residual.get_label() == f"refitted: rms {np.sqrt(17.0):.3g} V"
    np.testing.assert_array_equal(residual.get_ydata(), [7.0, 7.0, 1.0, 1.0, 1.0, 1.0])
    plt.close(figure)


def test_what_cannot_be_checked_is_left_out_and_said():
    guarded = [{"target": t, "quantity": "error", "at_most": 1.0, "source": "theory"} for t in ("fig7", "a", "b", "c")]
    kept, sentence = without_targets(guarded, {"a": "no folder", "b": "no folder", "elsewhere": "no folder"})
    assert [entry["target"] for entry in kept] == ["fig7", "c"]
    assert sentence == "not checked: a, b (no folder)"
    assert without_targets(guarded, {}) == (guarded, "")


def committed() -> dict[str, pd.DataFrame]:
    """Results that lie beside the figures."""
    return {name: pd.read_csv(ROOT / f"paper_figs/recording_{name}.csv") for name in BENCHMARK_RECORDINGS}


def test_committed_page_says_what_the_committed_results_say():
    written = (ROOT / "docs/real_recordings.md").read_text(encoding="utf-8")
    assert page(ROOT / "workflow/report/real_recordings.md.jinja", committed()) == written


def test_a_parameter_is_written_with_its_unit_and_a_choice_alone():
    rows = {
        "overflow_height": (22.3118, 0.6266, "V"),
        "overflow_share": (0.6075, 0.0488, np.nan),
        "overflow_slow": (1.0, np.nan, np.nan),
    }
    known = pd.DataFrame.from_dict(rows, orient="index", columns=["value", "standard_deviation", "unit"])
    written = [_parameter(known, key, key.removeprefix("overflow_")) for key in rows]
    assert written == ["height 22.31 ± 0.63 V", "share 0.608 ± 0.049", "slow"]


def test_committed_results_keep_their_tolerances_and_hold_no_samples():
    tables = committed()
    tolerances = YAML(typ="safe").load(ROOT / "config/tolerances.yaml")
    guarded = [t for t in tolerances if t["target"].startswith("recording_")]
    assert {t["target"] for t in guarded} == {f"recording_{name}" for name in BENCHMARK_RECORDINGS}
    comparison = compare(pd.concat(tables.values()), guarded)
    assert comparison["passed"].all(), comparison[~comparison["passed"]].to_string()
    for table in tables.values():
        assert list(table) == ["target", "quantity", "value", "standard_deviation", "unit"]
        assert table["quantity"].is_unique
