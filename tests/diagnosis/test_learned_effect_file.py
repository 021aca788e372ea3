"""A learned law as an effect of the user's own: it does what the law does, and is named in another recording."""

from dataclasses import dataclass

import numpy as np
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.cli import main
from camid.diagnosis.laws.learned_effect_file import FORMS, NAME, effect_file
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.report import page
from camid.diagnosis.report.page import render
from camid.effects.learned import LearnedCurve, LearnedForce
from camid.effects.own_effects import own_effects
from camid.effects.plant_force import static_force
from tests.diagnosis.test_learned_laws import believed, bump, rig
from tests.support import written_diagnoses
from tests.support.linear_rig import write_yaml
from tests.support.mass_on_spring import effect, record

KNOTS = np.linspace(-4.0, 4.0, 33)
FAST = np.linspace(-30.0, 30.0, 33)
LAWS = {
    "position": LearnedForce(variables="position", knots=KNOTS.tolist(), values=(0.3 * np.sin(KNOTS)).tolist()),
    "velocity": LearnedForce(variables="velocity", knots=FAST.tolist(), values=(0.2 * np.tanh(FAST / 9.0)).tolist()),
    "damping over position": LearnedForce(
        variables="damping over position", knots=KNOTS.tolist(), values=(0.01 * KNOTS**2).tolist()
    ),
    "gain over position": LearnedForce(
        variables="gain over position", knots=KNOTS.tolist(), values=(0.03 * KNOTS**2).tolist()
    ),
    "gain over velocity": LearnedForce(
        variables="gain over velocity", knots=FAST.tolist(), values=(0.3 * np.tanh(FAST / 9.0) ** 2).tolist()
    ),
    "input": LearnedCurve(variables="input", knots=KNOTS.tolist(), values=np.tanh(KNOTS).tolist()),
    "reading": LearnedCurve(variables="reading", knots=KNOTS.tolist(), values=(KNOTS + 0.01 * KNOTS**3).tolist()),
}


def part_of(law, **changes):
    stated = {
        "identifier": law.identifier,
        "place": law.place,
        "title": law.title,
        "variables": law.values["variables"],
        "knots": law.knots.tolist(),
        "values": law.heights.tolist(),
        "standard_deviations": [0.01] * len(law.knots),
        "knot_unit": law.knot_unit,
        "unit": law.unit,
        "log_evidence": 50.0,
        "share": 0.5,
    }
    return LearnedPart(**{**stated, **changes})


def written(tmp_path, *parts, **changes):
    path = tmp_path / NAME
    path.write_text(effect_file(written_diagnoses.diagnosis("partly-explained", learned=list(parts), **changes)))
    return path


def test_every_law_that_can_be_learned_here_has_a_form():
    assert set(LAWS) == set(FORMS)


@pytest.mark.parametrize("variables", LAWS)
def test_the_class_does_what_the_law_does(tmp_path, variables):
    law = LAWS[variables]
    with own_effects(written(tmp_path, part_of(law))) as (kind,):
        assert kind.place == law.place
        with_law, with_class, without, half = (
            record(*each, noise=0.0)["y"] for each in ((law,), (kind(scale=1.0),), (), (kind(scale=0.5),))
        )
        change = np.std(with_law - without)
        assert change > 0.01 * np.std(without)
        assert np.std(with_class - with_law) < 1e-3 * change
        assert 0.2 < np.std(half - without) / change < 0.8


@pytest.mark.parametrize("variables", ["position", "velocity", "damping over position"])
def test_the_force_opposes_the_motion_whatever_the_sign_of_the_gain(tmp_path, variables):
    law = LAWS[variables]
    plant = TransferFunction((-100.0,), (1.0, 2.0, 100.0))
    with own_effects(written(tmp_path, part_of(law))) as (kind,):
        found, expected, without = (
            record(*each, noise=0.0, plant=plant)["y"] for each in ((kind(scale=1.0),), (law,), ())
        )
        assert np.std(found - expected) < 1e-3 * np.std(expected - without)


def test_two_laws_become_two_classes_with_names_of_their_own(tmp_path):
    path = written(tmp_path, part_of(LAWS["position"]), part_of(LAWS["position"]), part_of(LAWS["input"]))
    with own_effects(path) as kinds:
        assert [kind.identifier for kind in kinds] == [
            "learned-force-over-position",
            "learned-force-over-position-2",
            "learned-curve-over-input",
        ]
    taken = {"learned-force-over-position": "that of an earlier diagnosis"}
    with own_effects(written(tmp_path, part_of(LAWS["position"]), own_titles=taken)) as (kind,):
        assert kind.identifier == "learned-force-over-position-2"


@dataclass(frozen=True)
class PartWithFormula(LearnedPart):
    """A law with a formula, as diagnosis.json says it."""

    said: str = ""
    numbers: tuple = ()
    replaces: tuple = ()

    def to_mapping(self):
        numbers = {name: {"value": value, "std": 0.01, "unit": unit} for name, value, unit in self.numbers}
        formula = {"formula": self.said, "formula_parameters": numbers, "formula_replaces": list(self.replaces)}
        return super().to_mapping() | formula


FORMULAS = {
    "position": ("f(y) = a·sin(2π·y/L) + b·cos(2π·y/L)", {"a": 0.3, "b": 0.1, "L": 6.3}),
    "velocity": ("f(v) = a·sign(v)·|v/10|^p", {"a": 0.2, "p": 0.6}),
    "damping over position": ("f = d(y)·v, d(y) = a·y²", {"a": 0.01}),
    "gain over position": (
        "f = g(y)·u, g(y) = a·max(y − c, 0) + b·min(y − d, 0)",
        {"a": 0.1, "b": -0.1, "c": 1, "d": 0},
    ),
    "gain over velocity": ("f = g(v)·u, g(v) = a/(1 + ((v − v0)/c)²)", {"a": 0.3, "v0": 4.0, "c": 5.0}),
    "input": ("u' = u + a·dead_zone(u, c)", {"a": -0.6, "c": 0.5}),
    "reading": ("w = y + a·y³", {"a": 0.01}),
}
BY_HAND = {
    "position": lambda y: 0.3 * np.sin(2 * np.pi * y / 6.3) + 0.1 * np.cos(2 * np.pi * y / 6.3),
    "velocity": lambda v: 0.2 * np.sign(v) * np.abs(v / 10) ** 0.6,
    "damping over position": lambda y: 0.01 * y**2,
    "gain over position": lambda y: 0.1 * np.maximum(y - 1.0, 0.0) - 0.1 * np.minimum(y, 0.0),
    "gain over velocity": lambda v: 0.3 / (1.0 + ((v - 4.0) / 5.0) ** 2),
    "input": lambda u: u - 0.6 * (u - np.clip(u, -0.5, 0.5)),
    "reading": lambda y: y + 0.01 * y**3,
}


def with_formula(variables, **changes):
    """A law on many knots, its formula, and the part that holds both."""
    text, numbers = FORMULAS[variables]
    kind = LearnedForce if variables not in ("input", "reading") else LearnedCurve
    knots = np.linspace(-40.0, 40.0, 8001) if "velocity" in variables else np.linspace(-8.0, 8.0, 8001)
    law = kind(variables=variables, knots=knots.tolist(), values=BY_HAND[variables](knots).tolist())
    stated = f"{text}, {', '.join(f'{n} = {v} ± 0.01 u' for n, v in numbers.items())}"
    rows = tuple((name, value, "u") for name, value in numbers.items())
    part = PartWithFormula(**{**vars(part_of(law)), "said": stated, "numbers": rows, **changes})
    return law, numbers, part


@pytest.mark.parametrize("variables", FORMULAS)
def test_a_formula_stands_in_the_class_with_its_numbers_free(tmp_path, variables):
    law, numbers, part = with_formula(variables)
    path = written(tmp_path, part)
    assert "Curve(" not in path.read_text()
    with own_effects(path) as (kind,):
        assert [p.name for p in kind.parameters] == list(numbers)
        assert page.equation(kind.equation) is not None
        with_law, with_class, without = (record(*each, noise=0.0)["y"] for each in ((law,), (kind(**numbers),), ()))
        change = np.std(with_law - without)
        assert change > 0.01 * np.std(without)
        assert np.std(with_class - with_law) < 5e-3 * change
        (guess,) = kind.candidates(None)
        assert guess.values == pytest.approx(numbers)
        # It does nothing at the size zero, whatever its numbers are called.
        none = record(guess.scaled(0.0), noise=0.0)["y"]
        assert np.std(none - without) < 1e-6 * change


def test_a_formula_of_a_law_stands_for_all_laws_over_its_variable(tmp_path):
    _, _, part = with_formula("position")
    with own_effects(written(tmp_path, part_of(LAWS["position"]), part, part_of(LAWS["velocity"]))) as kinds:
        assert [kind.identifier for kind in kinds] == ["learned-force-over-position", "learned-force-over-velocity"]


@pytest.mark.parametrize(
    "changes",
    [
        {"said": "f(y) = __import__('os').abort(), a = 1"},
        {"said": "f(y) = a·moon(y), a = 0.3 u", "numbers": (("a", 0.3, "u"),)},
        {"said": "f(y) = a·y·z, a = 0.3 u", "numbers": (("a", 0.3, "u"),)},
        {"said": "f(y) = 3 + a·y, a = 0.3 u", "numbers": (("a", 0.3, "u"),)},
        {"said": "f(y) = a·(y, a = 0.3 u", "numbers": (("a", 0.3, "u"),)},
        {"said": "f(y) = a·y⁴, a = 0.3 u", "numbers": (("a", 0.3, "u"),)},
    ],
    ids=["program", "function", "variable", "no size", "bracket", "another curve"],
)
def test_a_formula_that_is_not_understood_or_is_another_curve_leaves_the_curve(tmp_path, changes):
    _, _, part = with_formula("position", **changes)
    path = written(tmp_path, part)
    assert "Curve(" in path.read_text()
    with own_effects(path) as (kind,):
        assert [p.name for p in kind.parameters] == ["scale"]


def test_a_formula_that_stands_for_named_effects_too_need_not_be_the_curve(tmp_path):
    four = {"said": "f(y) = a·y⁴, a = 0.3 u", "numbers": (("a", 0.3, "u"),)}
    _, _, part = with_formula("position", **four, replaces=("cubic-stiffness",))
    with own_effects(written(tmp_path, part)) as (kind,):
        assert [p.name for p in kind.parameters] == ["a"]


HOSTILE = ['"""\nimport os\nos.abort()\n"""\\', "{curve}" + "x" * 300 + ".csv", "b\x07ell'\".csv"]


@pytest.mark.parametrize("name", HOSTILE)
def test_no_name_of_a_recording_becomes_program(tmp_path, name):
    _, _, part = with_formula("gain over position", said='y**2\nimport os\nos.abort() """')
    path = written(tmp_path, part, recordings=[name, "other.csv"])
    with own_effects(path) as (kind,):
        assert kind.identifier == "learned-gain-over-position"
    assert max(map(len, path.read_text().splitlines())) <= 120


def test_no_file_where_nothing_was_learned_or_a_law_has_no_form():
    assert effect_file(written_diagnoses.diagnosis("explained")) is None
    odd = part_of(LAWS["position"], variables="moon")
    assert effect_file(written_diagnoses.diagnosis("partly-explained", learned=[odd])) is None


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A folder with two recordings of a rig with a magnet beside its way, and what the first one taught."""
    folder = tmp_path_factory.mktemp("learned")
    for name, seed in (("first.csv", 1), ("second.csv", 2)):
        rig(bump, seed).drop(columns="clean").to_csv(folder / name, index=False)
    write_yaml(believed(), folder / "S.yaml")
    assert main(["diagnose", *arguments(folder, "first.csv", "one")]) == 0
    return folder


def arguments(folder, recording, output):
    return [str(folder / recording), "--simulation", str(folder / "S.yaml"), "--output", str(folder / output)]


@pytest.mark.slow
def test_what_one_recording_taught_is_named_in_another(bench, capsys):
    learned = bench / "one" / NAME
    capsys.readouterr()
    assert main(["diagnose", *arguments(bench, "second.csv", "two"), "--effects", str(learned)]) == 0
    assert "as learned from first.csv" in " ".join(capsys.readouterr().out.split())
    diagnosis = camid.diagnose(bench / "second.csv", bench / "S.yaml", effects=learned)
    found = diagnosis.findings[0]
    assert (found.identifier, found.place) == ("learned-force-over-position", "plant")
    assert found.weight > 0.5
    # Its scale, or the amplitude where a formula stands for it.
    size, expected = next((p, v) for n, v in (("scale", 1.0), ("a", 0.35)) if (p := found.parameters.get(n)))
    assert abs(size.value) == pytest.approx(expected, rel=0.1)
    assert 0.0 < size.standard_deviation < 0.05 * expected
    assert diagnosis.fit.improved < 0.25 * diagnosis.fit.refitted
    simulated = camid.simulate(bench / "second.csv", diagnosis.improved, effects=learned)
    assert np.std(simulated["y"] - simulated["simulated"]) < 0.006


def test_report_and_terminal_show_it(bench, capsys):
    assert "class LearnedForceOverPosition(Effect):" in (bench / "one" / "report.html").read_text()
    capsys.readouterr()
    assert main(["diagnose", *arguments(bench, "first.csv", "again"), "--no-report"]) == 0
    out = capsys.readouterr().out
    assert f"written to {bench / 'again' / NAME}" in out
    assert f"--effects {bench / 'again' / NAME}" in out
    assert (bench / "again" / NAME).read_text() == (bench / "one" / NAME).read_text()


def test_the_page_escapes_the_program():
    part = part_of(LAWS["position"])
    text = render(written_diagnoses.diagnosis("partly-explained", learned=[part], recordings=["<b>.csv"]))
    assert "as learned from &lt;b&gt;.csv" in text
    assert "learned from <b>" not in text


@pytest.mark.slow
def test_a_named_effect_that_only_resembles_a_part_of_the_law_is_part_of_it(tmp_path):
    """Cogging is taken for a part of the magnet's force: what was learned beside it alone is in no other recording."""
    first, second = (rig(bump, seed).drop(columns="clean") for seed in (21, 22))
    diagnosis = camid.diagnose(first, believed())
    assert [f.weight < 0.5 for f in diagnosis.findings] == [True]
    path = tmp_path / NAME
    path.write_text(effect_file(diagnosis))
    found = camid.diagnose(second, believed(), effects=path).findings[0]
    assert found.identifier == "learned-force-over-position"
    assert found.weight > 0.5


def test_the_force_of_an_effect_over_one_variable():
    at, plant = np.linspace(-2.0, 2.0, 9), TransferFunction((100.0,), (1.0, 2.0, 100.0))
    cubic, drag, friction = (
        effect("cubic-stiffness", coefficient=0.3),
        effect("quadratic-drag", coefficient=0.2),
        effect("coulomb-friction", force=0.1),
    )
    assert static_force(cubic, "position", at, plant) == pytest.approx(0.3 * at**3)
    assert static_force(drag, "velocity", at, plant) == pytest.approx(0.2 * at * np.abs(at))
    for each, over in ((cubic, "velocity"), (drag, "position"), (friction, "velocity")):
        assert not static_force(each, over, at, plant).any()
