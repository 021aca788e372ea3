"""What diagnosis.json, improved.yaml and residuals.csv promise to people and to other tools."""

import json
from importlib.resources import files as package_files

import numpy as np
import pandas as pd
import pytest
from jsonschema import Draft202012Validator

import camid
from camid.cli import main
from camid.diagnosis.report.summary import VERDICT_WORDS
from camid.diagnosis.residual.validation_rows import UNKNOWN_FUTURE
from camid.diagnosis.results_folder import FILES, write_diagnosis
from camid.effects import known_effects
from camid.simulation.file import load_simulation
from tests.support import linear_rig as rig
from tests.support import written_diagnoses
from tests.support.mass_on_spring import COUNT, PERIOD, effect, record, simulation

SCHEMA = json.loads(package_files("camid").joinpath("schemas/diagnosis.schema.json").read_text(encoding="utf-8"))
# One or several effects a place, by the name of the effect that has to be found first.
CASES = {
    "nothing": [],
    "dead-zone": [effect("dead-zone", half_width=0.3)],
    "coulomb-friction": [effect("coulomb-friction", force=0.2)],
    "periodic-disturbance": [effect("periodic-disturbance", amplitude=0.2, frequency=7.0, phase=1.0)],
    "clipping": [effect("clipping", low=-1.2, high=1.2)],
    "cubic-stiffness": [effect("cubic-stiffness", coefficient=0.2), effect("sensor-offset", offset=0.1)],
}
# What a simulation declares is corrected there: keywords of the recording, and what improved.yaml has to say.
DECLARED = {
    "input-hold": ({"hold": "foh"}, ("hold", "foh", 0.0)),
    "exposure": ({"exposure": 0.006}, ("exposure", 0.006, 0.0003)),
    "delay": ({"latency": 0.011}, ("latency", 0.011, 0.0003)),
}


def spoilt(name):
    """Recordings whose noise is not white, or with rows that say nothing of the motion."""
    table = record()
    random = np.random.default_rng(np.random.SeedSequence(9))
    output = table["y"].to_numpy().copy()
    if name == "quantisation":
        output = 0.05 * np.round(output / 0.05)
    elif name == "dropped-frames":
        for row in np.flatnonzero(random.random(COUNT) < 0.04)[1:]:
            output[row] = output[row - 1]
    elif name == "outliers":
        rows = random.random(COUNT) < 0.03
        output[rows] += random.choice([-1.0, 1.0], COUNT)[rows]
    elif name == "coloured-noise":
        noise = np.zeros(COUNT)
        for k in range(1, COUNT):
            noise[k] = 0.9 * noise[k - 1] + 0.02 * random.standard_normal()
        output += noise
    return table.assign(y=output)


# Parameters of what spoils the noise.
NOISE = {
    "quantisation": {"step": 0.05},
    "dropped-frames": {"fraction": 0.04},
    "outliers": {"fraction": 0.03},
    "coloured-noise": {"spectrum": [0.9]},
}
# What is concealed in each recording: effect → parameter → value.
CONCEALED = {
    **{name: {e.identifier: e.values for e in effects} for name, effects in CASES.items() if effects},
    "input-hold": {"input-hold": {"hold": "foh"}},
    "exposure": {"exposure": {"exposure": 0.006}},
    "delay": {"delay": {"delay": 0.011}},
    **{name: {name: parameters} for name, parameters in NOISE.items()},
}


class Case:
    """A recording, its diagnosis and the folder with the files."""

    def __init__(self, recording, believed, folder):
        self.recording, self.believed, self.folder = recording, believed, folder
        self.diagnosis = camid.diagnose(recording, believed)
        write_diagnosis(self.diagnosis, folder, report=False)
        self.content = read_json((folder / "diagnosis.json").read_text(encoding="utf-8"))
        self.improved = load_simulation(folder / "improved.yaml")


def read_json(text):
    def refuse(name):
        raise AssertionError(f"{name} in JSON")

    return json.loads(text, parse_constant=refuse)


def recorded(name):
    """The recording of a case."""
    if name in CASES:
        return record(*CASES[name])
    return record(**DECLARED[name][0]) if name in DECLARED else spoilt(name)


def believed(name):
    """The simulation of a case: an offset is found only where another one is declared."""
    known = {"offset": 0.0} if "sensor-offset" in CONCEALED.get(name, {}) else {}
    content = simulation()
    return {**content, "sensor": content["sensor"] | known}


class Cases(dict):
    """Cases by name, each diagnosed when it is first asked for."""

    def __init__(self, new_folder):
        super().__init__()
        self.new_folder = new_folder

    def __missing__(self, name):
        self[name] = Case(recorded(name), believed(name), self.new_folder(name))
        return self[name]


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    return Cases(tmp_path_factory.mktemp)


# A second effect of a kind that another case has already: the contract is the same, and the effect another.
MORE = {"dead-zone", "periodic-disturbance", "exposure", "delay", "quantisation", "outliers"}


def each(*names):
    """Parameter over cases; a further one of a kind is slow."""
    cases = [pytest.param(n, marks=pytest.mark.slow) if n in MORE else n for n in names]
    return pytest.mark.parametrize("name", cases)


EVERY = each(*CASES, *DECLARED, *NOISE)
FOUND = each(*CONCEALED)


def squares(case, kind):
    """Sum of squared residuals on fitted rows."""
    table = pd.read_csv(case.folder / "residuals.csv")
    return float((table[f"residual_{kind}"][table["fitted"] == 1] ** 2).sum())


def error(recorded, simulated):
    """Normalised error of a simulated output."""
    return float(np.sqrt(np.mean((recorded - simulated) ** 2)) / np.std(recorded))


def on_validation(case, table):
    """Rows of a table that validate."""
    span = case.content["fit"]["validation"]
    return table[(table["t"] >= span["start"]) & (table["t"] <= span["end"])]


@EVERY
def test_the_file_fits_its_schema(cases, name):
    Draft202012Validator.check_schema(SCHEMA)
    assert list(Draft202012Validator(SCHEMA).iter_errors(cases[name].content)) == []


@pytest.mark.parametrize("verdict", VERDICT_WORDS)
def test_every_verdict_fits_the_schema(verdict):
    content = read_json(json.dumps(written_diagnoses.diagnosis(verdict).to_mapping()))
    Draft202012Validator(SCHEMA).validate(content)
    assert not Draft202012Validator(SCHEMA).is_valid({**content, "verdict": "perfect"})
    assert not Draft202012Validator(SCHEMA).is_valid({**content, "more": 1})


@EVERY
def test_the_concealed_effect_is_named(cases, name):
    content = cases[name].content
    assert content["verdict"] == ("adequate" if name == "nothing" else "explained")
    assert [e["id"] for e in content["effects"]] == list(CONCEALED.get(name, []))


@FOUND
def test_parameters_lie_within_their_standard_deviations(cases, name):
    for identifier, true in CONCEALED[name].items():
        found = next(e for e in cases[name].content["effects"] if e["id"] == identifier)["parameters"]
        assert set(found) == set(true)
        for parameter, value in true.items():
            estimate, spread = found[parameter]["value"], found[parameter]["std"]
            if isinstance(value, str):
                assert (estimate, spread) == (value, None)
                continue
            # Shares of rows are known no better than some twenty rows tell.
            assert np.all(np.array(spread) > 0.0)
            assert np.all(np.array(spread) < (0.25 if parameter == "fraction" else 0.1) * np.abs(value))
            assert np.all(np.abs(np.array(estimate) - value) < 4.5 * np.array(spread))


@FOUND
def test_weights_sum_to_one(cases, name):
    assert cases[name].content["effects"]
    for found in cases[name].content["effects"]:
        weights = [found["weight"], *(a["weight"] for a in found["alternatives"])]
        assert sum(weights) == pytest.approx(1.0, abs=1e-9)
        assert all(0.0 < w <= 1.0 for w in weights)
        assert found["weight"] >= max(weights[1:], default=0.0) or found["alternatives"][0]["id"] == "unlisted"
        names = [found["id"], *(a["id"] for a in found["alternatives"])]
        assert len(set(names)) == len(names)


@EVERY
def test_effects_are_sorted_and_places_are_theirs(cases, name):
    content = cases[name].content
    shares = [e["evidence"]["share"] for e in content["effects"]]
    assert shares == sorted(shares, reverse=True)
    together = [e["evidence"].get("share_together") for e in content["effects"]]
    if len(shares) < 2:
        assert not any(together)
    elif name in CASES:
        left = 1.0 - squares(cases[name], "improved") / squares(cases[name], "refitted")
        assert together == pytest.approx([left] * len(shares), rel=0.01)
    for found in content["effects"]:
        assert found["place"] == known_effects()[found["id"]].place
    assert content["location"]["place"] == (content["effects"][0]["place"] if content["effects"] else None)
    portions = [p["share"] for p in content["location"]["places"]]
    assert portions == sorted(portions, reverse=True)


@EVERY
def test_found_and_undetectable_are_the_whole_catalogue(cases, name):
    content = cases[name].content
    found = {e["id"] for e in content["effects"]}
    unseen = [u["id"] for u in content["undetectable"]]
    assert len(unseen) == len(set(unseen))
    assert found | set(unseen) == set(known_effects())
    assert not found & set(unseen)


@EVERY
def test_errors_are_those_of_simulate(cases, name):
    case = cases[name]
    for key, model in (("nrmse_nominal", case.believed), ("nrmse_improved", case.folder / "improved.yaml")):
        rows = on_validation(case, camid.simulate(case.recording, model))
        if name == "dropped-frames":  # what says nothing of the motion judges nothing
            rows = rows[rows["y"].diff() != 0.0]
        if name == "outliers":
            assert case.content["fit"][key] < error(rows["y"], rows["simulated"])
            continue
        assert error(rows["y"], rows["simulated"]) == pytest.approx(case.content["fit"][key], rel=1e-6)


@each(*CASES, *DECLARED)
def test_refitted_error_is_that_of_identify(cases, name):
    case = cases[name]
    span = case.content["fit"]["validation"]
    compared = case.recording.iloc[: len(case.recording) - len(case.recording) // UNKNOWN_FUTURE]
    fitted = camid.identify(compared, case.believed | {"validation": span})
    assert fitted.nrmse_validation == pytest.approx(case.content["fit"]["nrmse_refitted"], rel=2e-3)


@EVERY
def test_rows_that_validate_are_a_part_of_the_recording(cases, name):
    case = cases[name]
    rows = on_validation(case, case.recording)
    assert 0.1 * COUNT < len(rows) < 0.4 * COUNT
    assert case.diagnosis.rows_fitted + len(rows) <= COUNT


@EVERY
def test_the_improved_simulation_is_adequate(cases, name):
    """Diagnosed again with what was found, nothing is left out."""
    case = cases[name]
    again = camid.diagnose(case.recording, case.folder / "improved.yaml")
    assert (again.verdict, [f.identifier for f in again.findings]) == ("adequate", [])
    assert again.fit.nominal == pytest.approx(case.content["fit"]["nrmse_improved"], rel=1e-6)
    assert again.fit.improved == pytest.approx(case.content["fit"]["nrmse_improved"], rel=0.02)


@each(*CASES)
def test_improved_holds_the_effects_with_their_deviations(cases, name):
    written = {e.identifier: e for e in cases[name].improved.effects}
    assert set(written) == {e["id"] for e in cases[name].content["effects"]}
    for found in cases[name].content["effects"]:
        for parameter, estimate in found["parameters"].items():
            assert written[found["id"]].parameters[parameter] == estimate["value"]
            assert written[found["id"]].standard_deviations[parameter] == estimate["std"]
    # What was declared rightly stays as it was written.
    believed = load_simulation(simulation())
    for key in ("hold", "sensor", "exposure", "latency", "initial_state", "validation"):
        assert getattr(cases[name].improved, key) == getattr(believed, key)


@each(*DECLARED)
def test_declarations_are_corrected_and_no_effects(cases, name):
    improved = cases[name].improved
    assert improved.effects == ()
    key, value, allowed = DECLARED[name][1]
    found = getattr(improved, key)
    assert found == value if isinstance(value, str) else abs(found - value) < allowed


@EVERY
def test_residuals_have_a_row_for_every_recorded_row(cases, name):
    case = cases[name]
    table = pd.read_csv(case.folder / "residuals.csv")
    assert len(table) == COUNT
    np.testing.assert_allclose(table["t"], case.recording["t"], rtol=1e-12)
    np.testing.assert_allclose(table["recorded"], case.recording["y"], rtol=1e-12)
    assert np.all(np.isfinite(table.to_numpy()))
    simulated = camid.simulate(case.recording, case.folder / "improved.yaml")["simulated"]
    np.testing.assert_allclose(table["improved"], simulated, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(table["residual_improved"], table["recorded"] - table["improved"], atol=1e-12)
    span = case.content["fit"]["validation"]
    np.testing.assert_array_equal(table["fitted"] == 0, table["t"].between(span["start"], span["end"]))


def test_two_runs_write_the_same_bytes(cases, tmp_path):
    """Nothing in the files depends on the clock, the threads or the process."""
    case = cases["clipping"]
    write_diagnosis(case.diagnosis, tmp_path / "first")
    write_diagnosis(camid.diagnose(case.recording, case.believed), tmp_path / "second")
    for name in FILES:
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes(), name


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with a recording and a simulation."""
    monkeypatch.chdir(tmp_path)
    record(*CASES["dead-zone"], count=300).to_csv("recording.csv", index=False)
    rig.write_yaml(simulation(), tmp_path / "S.yaml")
    return tmp_path


COMMAND = ["diagnose", "recording.csv", "--simulation", "S.yaml", "--output", "found"]


@pytest.mark.slow
def test_the_command_writes_and_prints(folder, capsys):
    assert main(COMMAND) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "EXPLAINED" in out
    assert "Dead zone" in out
    assert sorted(p.name for p in (folder / "found").iterdir()) == sorted(FILES)
    for name in FILES:
        assert f"written to found/{name}" in out


def test_json_prints_the_file_and_no_report_draws_none(folder, capsys):
    assert main([*COMMAND, "--json", "--no-report"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert read_json(out) == read_json((folder / "found" / "diagnosis.json").read_text(encoding="utf-8"))
    assert not (folder / "found" / "report.html").exists()
    table = pd.read_csv(folder / "found" / "residuals.csv")
    assert table["t"].iloc[1] == PERIOD
