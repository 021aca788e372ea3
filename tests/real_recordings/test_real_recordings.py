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
from camid.real_recordings.download import BENCHMARK_RECORDINGS, FOLDER_VARIABLE, SILVERBOX_PERIOD, SILVERBOX_TRAINING
from camid.real_recordings.page import page
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
    params=[
        "pendulum",
        pytest.param("silverbox", marks=pytest.mark.slow),
        pytest.param("emps", marks=pytest.mark.slow),
    ],
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
