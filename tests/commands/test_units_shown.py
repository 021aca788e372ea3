"""A recording in millimetres and the same one in metres: the same physics; what people read has its declared unit."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from jsonschema import Draft202012Validator

import camid
from camid.cli import main
from camid.diagnosis.in_declared_units import in_declared_units
from camid.diagnosis.learned_part import Formula, LearnedPart, Quantity
from camid.diagnosis.results_folder import write_diagnosis
from tests.diagnosis.test_contract import SCHEMA
from tests.support.linear_rig import write_yaml
from tests.support.mass_on_spring import effect, record, simulation

UNITS = {"m": 1.0, "mm": 1e3}


def declared(unit):
    return simulation(
        sensor={"column": "y", "kind": "camera", "unit": unit}, input={"column": "u", "hold": "zoh", "unit": "N"}
    )


@pytest.fixture(scope="module")
def recordings():
    """The same recording in both units."""
    in_metres = record(effect("cubic-stiffness", coefficient=0.2), effect("coulomb-friction", force=0.2))
    return {unit: in_metres.assign(y=factor * in_metres["y"]) for unit, factor in UNITS.items()}


@pytest.fixture(scope="module")
def diagnoses(recordings):
    return {unit: camid.diagnose(recordings[unit], declared(unit), time_limit=None) for unit in UNITS}


@pytest.fixture
def bench(recordings, tmp_path, monkeypatch):
    """A folder with both recordings and their simulations, and the current one."""
    monkeypatch.chdir(tmp_path)
    for unit in UNITS:
        recordings[unit].to_csv(f"{unit}.csv", index=False)
        write_yaml(declared(unit), tmp_path / f"{unit}.yaml")
    return tmp_path


def test_the_physics_is_the_same_and_the_numbers_have_their_unit(diagnoses):
    metres, millimetres = diagnoses["m"], diagnoses["mm"]
    assert {f.identifier for f in metres.findings} >= {"cubic-stiffness", "coulomb-friction"}
    assert [f.identifier for f in metres.findings] == [f.identifier for f in millimetres.findings]
    powers = {"u": 0, "u/y^3": -3, "y": 1}
    shown = in_declared_units(millimetres)
    for one, other, read in zip(metres.findings, millimetres.findings, shown.findings, strict=True):
        for name, parameter in one.parameters.items():
            assert other.parameters[name].value == pytest.approx(parameter.value, rel=1e-4)  # files stay in SI units
            factor = 1e3 ** powers[parameter.unit]
            assert read.parameters[name].value == pytest.approx(factor * parameter.value, rel=1e-4)
            assert read.parameters[name].standard_deviation == pytest.approx(
                factor * parameter.standard_deviation, rel=1e-2
            )
            assert read.parameters[name].unit == {"u": "N", "u/y^3": "N/mm³", "y": "mm"}[parameter.unit]
    (gain,) = [c for c in shown.coefficients if c.name == "b0"]
    assert gain.unit == "mm/(N s²)"
    assert gain.nominal == pytest.approx(95e3)
    assert gain.improved == pytest.approx(1e5, rel=0.01)
    for name, factor in {"recorded": 1e3, "velocity": 1e3, "position": 1e3, "equivalent_input": 1.0}.items():
        np.testing.assert_allclose(getattr(shown.signals, name), factor * getattr(millimetres.signals, name))


def test_json_has_both(diagnoses, tmp_path):
    write_diagnosis(diagnoses["mm"], tmp_path / "out", report=False)
    content = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    Draft202012Validator(SCHEMA).validate(content)
    assert content["units"]["y"] == {"column": "y", "unit": "m", "declared_unit": "mm", "declared_in_si": 1e-3}
    (cubic,) = [e for e in content["effects"] if e["id"] == "cubic-stiffness"]
    stated = cubic["parameters"]["coefficient"]
    assert stated["unit"] == "u/y^3"
    assert stated["declared"]["unit"] == "N/mm³"
    assert stated["declared"]["value"] == pytest.approx(1e-9 * stated["value"])
    assert stated["declared"]["std"] == pytest.approx(1e-9 * stated["std"])
    limits = [u["smallest_detectable"] for u in content["undetectable"] if u["smallest_detectable"]]
    clipping = next(limit for limit in limits if limit["unit"] == "y")
    assert clipping["declared"] == {"value": pytest.approx(1e3 * clipping["value"]), "unit": "mm"}
    assert all(c["declared"]["unit"] for c in content["coefficients"])


def test_each_learned_law_has_numbers_of_its_own(diagnoses):
    """The one that removes most comes first in the file, in whatever order they were found."""
    shape = {
        "identifier": "learned-force",
        "place": "plant",
        "title": "Learned force",
        "standard_deviations": [0.1, 0.1],
    }
    formula = Formula("even power", "f(y) = a·y²", {"a": Quantity(2.0, 0.1, "u/y^2")})
    laws = [
        LearnedPart(
            variables=variables,
            knots=[0.0, last],
            values=[0.0, last],
            knot_unit=unit,
            unit="u",
            log_evidence=20.0,
            share=share,
            formula=known,
            **shape,
        )
        for variables, last, unit, share, known in (
            ("velocity", 3.0, "y/s", 0.1, None),
            ("position", 0.5, "y", 0.4, formula),
        )
    ]
    content = replace(diagnoses["mm"], learned=laws).to_mapping()
    found = [each for each in content["effects"] if each["id"] == "learned-force"]
    assert [each["variables"] for each in found] == ["position", "velocity"]
    for each in found:
        knots = each["parameters"]["knots"]
        np.testing.assert_allclose(knots["declared"]["value"], 1e3 * np.array(knots["value"]))
        assert knots["declared"]["unit"] == {"position": "mm", "velocity": "mm/s"}[each["variables"]]
    assert found[0]["formula_parameters"]["a"]["declared"]["value"] == pytest.approx(2e-6)


def test_the_page_and_the_terminal_write_the_unit(diagnoses, tmp_path, capsys):
    from camid.diagnosis.report.page import render
    from camid.diagnosis.report.summary import print_summary

    for unit in UNITS:
        print_summary(diagnoses[unit], [])
        printed = capsys.readouterr().out.replace("\u00a0", " ")
        assert f"{unit}/(N s²)" in printed
        page = render(diagnoses[unit])
        assert f"y in {unit}." in page
        assert f"velocity, {unit}/s" in page
        assert f"N/{unit}³" in page
        assert "stands for the unit" not in page
    assert "N" in diagnoses["mm"].explanation


def test_identify_simulate_and_compare_say_the_same_in_both_units(bench, capsys):
    found = {}
    for unit in UNITS:
        assert main(["identify", f"{unit}.csv", "--simulation", f"{unit}.yaml", "--output", f"{unit}_model.yaml"]) == 0
        printed = capsys.readouterr().out
        assert f"{unit}/(N s²)" in printed
        gain = re.search(r"static gain\s*│\s*([\d.]+) ±.*│ (\S+)", printed)
        found[unit] = float(gain[1]), gain[2]
        assert main(["simulate", f"{unit}.csv", "--simulation", f"{unit}_model.yaml", "--output", "out.csv"]) == 0
        said = capsys.readouterr().out.replace("\u00a0", " ")
        assert ("in m (recorded in mm)" in said) == (unit == "mm")
        assert re.search(rf"difference: [\d.]+ {unit} RMS", said)
        assert np.max(np.abs(pd.read_csv("out.csv")["simulated"])) < 10.0  # the file is in SI units
        assert main(["compare", f"{unit}.csv", f"{unit}_model.yaml", "--output", f"{unit}_drawn.svg"]) == 0
        capsys.readouterr()
        drawn = (bench / f"{unit}_drawn.svg").read_text()
        assert f"<!-- y, {unit} -->" in drawn
        assert f"<!-- error, {unit} -->" in drawn
    assert found["mm"] == (pytest.approx(1e3 * found["m"][0], rel=1e-3), "mm/N")
    assert found["m"][1] == "m/N"


def test_json_of_identify(bench, capsys):
    assert main(["identify", "mm.csv", "--simulation", "mm.yaml", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    (gain,) = [row for row in content["characteristics"] if row["name"] == "static gain"]
    assert gain["unit"] == "y/u"
    assert gain["declared"]["unit"] == "mm/N"
    assert gain["declared"]["value"] == pytest.approx(1e3 * gain["value"])
    first = content["coefficients"][0]
    assert (first["name"], first["unit"], first["declared"]["unit"]) == ("b0", "y/(u s^2)", "mm/(N s²)")
    assert first["value"] == content["numerator"][0]


def test_the_unit_of_a_header_is_that_of_the_column_until_another_is_declared(bench, recordings, capsys):
    recordings["mm"].rename(columns={"y": "y [mm]"}).to_csv("header.csv", index=False)
    write_yaml(simulation(), bench / "S.yaml")
    assert main(["identify", "header.csv", "--simulation", "S.yaml", "--output", "model.yaml"]) == 0
    assert "│ mm/u" in capsys.readouterr().out
    assert camid.load_simulation("model.yaml").reading.output.unit == "mm"
    assert main(["simulate", "header.csv", "--simulation", "S.yaml", "--output", "out.csv"]) == 0
    assert " mm RMS" in capsys.readouterr().out.replace("\u00a0", " ")
    assert main(["identify", "header.csv", "--simulation", "m.yaml"]) == 0
    assert "'y [mm]' is read in m, as the simulation declares, and not as its header says" in capsys.readouterr().err


def test_headers_that_differ_between_files_are_told(bench, recordings, capsys):
    recordings["mm"].rename(columns={"y": "y [mm]"}).to_csv("one.csv", index=False)
    recordings["m"].to_csv("two.csv", index=False)
    write_yaml(simulation(), bench / "S.yaml")
    assert main(["identify", "one.csv", "two.csv", "--simulation", "S.yaml", "--output", "model.yaml"]) == 0
    printed, said = capsys.readouterr()
    assert "the headers of column 'y' differ: mm in one.csv, no unit in two.csv" in said
    assert "│ y/u" in printed
    assert camid.load_simulation("model.yaml").reading.output.unit is None


def test_a_free_decay(bench, capsys):
    time = 0.02 * np.arange(400)
    decay = np.exp(-0.5 * time) * np.cos(9.0 * time) + 1e-3 * np.random.default_rng(3).standard_normal(400)
    gains = {}
    for unit, factor in UNITS.items():
        pd.DataFrame({"t": time, "y": factor * decay}).to_csv("decay.csv", index=False)
        content = declared(unit) | {"input": None, "initial_state": "estimate"}
        write_yaml(content, bench / "decay.yaml")
        assert main(["identify", "decay.csv", "--simulation", "decay.yaml"]) == 0
        printed = capsys.readouterr().out
        assert "u = the input of the plant, which nothing drives" in printed
        assert "(fixed)" in printed
        gains[unit] = float(re.search(rf"static gain\s*│\s*([\d.]+) ±.*│ {unit}/u", printed)[1])
    assert gains["mm"] == pytest.approx(1e3 * gains["m"], rel=1e-3)
