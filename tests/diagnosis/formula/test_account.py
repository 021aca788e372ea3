"""Formulas of whole diagnoses: right ones where there are, none where a curve says more, and none in noise."""

import json
from importlib.resources import files

import jsonschema
import numpy as np
import pytest

import camid
from camid.diagnosis.laws.formula.account import with_formulas
from camid.diagnosis.laws.formula.candidates import LONG_FITS
from camid.diagnosis.report import learned_pictures, summary
from camid.diagnosis.report.panel import look_of_the_project
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.watch import Watch
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.learned_law import learn
from camid.fitting.possible_laws import blank_laws
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation, write_simulation
from tests.diagnosis.test_learned_laws import believed, rig


def diagnosed(force, seed, **changes):
    return camid.diagnose(rig(force, seed, **changes).drop(columns="clean"), believed())


def peak(y, v):
    """A force that is largest at a distance of 0.4."""
    return 0.9 * y / (1.0 + (y / 0.4) ** 2)


@pytest.fixture(scope="module")
def peaked():
    return diagnosed(peak, 11)


@pytest.mark.slow
def test_a_formula_stands_for_a_name_that_only_resembles_the_law(peaked):
    diagnosis = peaked
    (part,) = [part for part in diagnosis.learned if part.formula is not None]
    formula = part.formula
    assert formula.form == "peak at a point"
    assert set(formula.replaces) == {f.identifier for f in diagnosis.findings if f.place == "plant"}
    for name, value in {"a": 0.9, "c": 0.4}.items():
        found = formula.parameters[name]
        assert abs(found.value - value) < 4.0 * found.standard_deviation < 0.2 * value
    assert "which only resembled it" in part.description
    assert "odd" in part.description
    lines = summary.learned_lines(part)
    assert lines[0] == f"formula: {formula.text}"
    mapping = json.loads(json.dumps(diagnosis.to_mapping()))
    jsonschema.validate(mapping, json.loads((files("camid") / "schemas/diagnosis.schema.json").read_text()))
    with look_of_the_project():
        (panel,) = [p for p in learned_pictures.learned_pictures(diagnosis) if part.description in p.caption]
    assert "formula</text>" in panel.svg


def test_the_formula_is_what_the_improved_simulation_holds(peaked, tmp_path):
    recording, diagnosis = rig(peak, 11), peaked
    (part,) = diagnosis.learned
    entries = diagnosis.to_mapping()["effects"]
    assert part.formula.replaces
    assert [e["simulated"] for e in entries] == [e["id"] not in part.formula.replaces for e in entries]
    (held,) = diagnosis.improved.effects
    assert (held.identifier, held.parameters["formula"]) == ("learned-force", part.formula.text)
    assert (held.parameters["values"], entries[-1]["values_from"]) == (part.values, "formula")
    # Knots carry the formula, but for the straight line that the spring holds.
    numbers = part.formula.parameters
    knots = np.array(part.knots)
    law = numbers["a"].value * knots / (1.0 + (knots / numbers["c"].value) ** 2)
    bend = law - part.formula.held["slope"] * knots - part.formula.held["constant"]
    assert np.max(np.abs(bend - part.values)) < 2e-3 * np.ptp(law)
    assert "in the place of" in diagnosis.explanation
    path = tmp_path / "improved.yaml"
    write_simulation(diagnosis.improved, path)
    simulated = camid.simulate(recording.drop(columns="clean"), path)["simulated"]
    again = camid.identify(recording.drop(columns="clean"), path, method="output-error")
    assert np.std(simulated - recording["clean"]) < 0.01 * np.std(recording["clean"])
    assert len(again.simulation.effects) == 1


@pytest.mark.slow
def test_a_formula_that_takes_more_than_is_left_is_left_out_with_a_word(monkeypatch):
    monkeypatch.setattr(Watch, "allowance", lambda watch, count: 0.0)
    diagnosis = diagnosed(peak, 11)
    assert diagnosis.learned
    assert all(part.formula is None for part in diagnosis.learned)
    assert any("no form of the dictionary can be simulated as fast" in part.description for part in diagnosis.learned)
    (warning,) = [sentence for sentence in diagnosis.warnings if "not tried" in sentence]
    assert LONG_FITS in warning


@pytest.mark.slow
def test_a_law_outside_of_the_dictionary_has_no_formula():
    diagnosis = diagnosed(lambda y, v: 0.25 * np.sin(2.4 * y * abs(y)), 12)
    assert diagnosis.learned
    for part in diagnosis.learned:
        assert part.formula is None
        assert part.rivals == []
        assert part.to_mapping()["formula"] is None
    assert any("no short formula" in p.description and "nearest form" in p.description for p in diagnosis.learned)


@pytest.mark.parametrize("name", ["position", "velocity", "input"])
def test_a_curve_of_noise_has_no_formula(name):
    simulation = load_simulation(believed())
    recordings, experiments, _ = experiments_of([rig(lambda y, v: 0.0, 13).drop(columns="clean")], simulation, None)
    problem = problem_of(simulation, structure_of(simulation), recordings, experiments)
    base = problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))
    law = learn(problem, base, blank_laws(problem, base)[name])
    decision = Decision(base, base, laws=(law,))
    judging = [np.ones(len(e.output), bool) for e in problem.experiments]
    _, (part,) = with_formulas(problem, decision, judging, 0, Watch())
    assert part.formula is None
    assert part.rivals == []
    assert "no short formula" in part.description


def test_without_time_the_curve_stands_alone():
    simulation = load_simulation(believed())
    recordings, experiments, _ = experiments_of(
        [rig(lambda y, v: 0.2 * abs(y), 14).drop(columns="clean")], simulation, None
    )
    problem = problem_of(simulation, structure_of(simulation), recordings, experiments)
    base = problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))
    law = learn(problem, base, blank_laws(problem, base)["position"])
    decision = Decision(base, base, laws=(law,))
    judging = [np.ones(len(e.output), bool) for e in problem.experiments]
    watch = Watch(limit=0.0)
    _, (part,) = with_formulas(problem, decision, judging, 0, watch)
    assert (part.formula, part.description) == (None, "")
    assert watch.left_out == ["a formula for a law without a name"]
    _, (part,) = with_formulas(problem, decision, judging, 0, Watch())
    assert part.formula.form == "absolute value"
    assert "even" in part.description
    assert "grows as the power" in part.description
