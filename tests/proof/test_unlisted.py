"""Rigs under laws outside the catalogue: their motion against another integrator, and the judgement of answers."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML
from scipy.integrate import solve_ivp

from camid.proof.figures import unlisted as figure
from camid.proof.unlisted import laws, rigs
from camid.proof.unlisted.campaign import COLUMNS, carrier, curve_error, evaluated, scored
from camid.proof.unlisted.laws import LAWS
from camid.proof.unlisted.rigs import Rig
from camid.proof.unlisted.table import form_is_right, judged, quantities, to_markdown
from camid.workflow.tolerances import compare
from tests.support import ROOT

SEED = 411


def named(name):
    return next(law for law in LAWS if law.name == name)


def rig(law=None, **changes):
    plain = Rig(
        frequency=10.0, damping=0.1, gain=2.0, period=0.02, exposure=0.01, frames=120, amplitude=1.0, noise=0.005
    )
    shape = None if law is None else law.draw(np.random.default_rng(SEED))
    return replace(plain, law=law, shape=shape, units=(2.0, 15.0, 1.0), strength=0.3, **changes)


@pytest.mark.parametrize("module", [laws, rigs])
def test_what_makes_recordings_imports_nothing_of_camid(module):
    for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert all(name.name.split(".")[0] != "camid" for name in node.names)
        if isinstance(node, ast.ImportFrom):
            assert (node.level == 1 and node.module == "laws") or (node.level == 0 and node.module[:5] != "camid")


@pytest.mark.parametrize(
    "name", ["detent", "cubic drag", "damping with a bump", "motor constant that falls off-centre"]
)
def test_frames_are_those_of_another_integrator(name):
    ours = rig(named(name))
    levels = rigs.random_levels(ours, np.random.default_rng(SEED))
    force = ours.pulls()

    def rates(_time, state, level):
        y, v, _area = state
        return v, 200.0 * force(y, v, level) - 2.0 * v - 100.0 * y, y

    state, expected = [0.0, 0.0, 0.0], [0.0]
    for level in levels[:-1]:
        middle, end = solve_ivp(
            rates, (0.0, 0.02), state, args=(level,), rtol=1e-10, atol=1e-12, t_eval=[0.01, 0.02]
        ).y.T
        expected.append((end[2] - middle[2]) / 0.01)
        state = list(end)
    assert np.max(np.abs(ours.film(levels)[0] - expected)) < 1e-4 * np.std(expected)


def test_every_law_is_drawn_within_its_limits_and_leaves_its_rig_at_rest():
    for number, law in enumerate(LAWS):
        found = replace(rig(law), strength=0.1)
        assert law.variables == "damping over position" or found.departure(0.0) == pytest.approx(0.0, abs=1e-12)
        assert rigs.law_of(number) is law
    case = rigs.draw(rigs.generator(SEED, 0, True), LAWS[0])
    assert rigs.LEAST * 0.97 <= case.share <= rigs.MOST * 1.03
    assert case.left >= rigs.VISIBLE * case.rig.noise
    assert np.std(case.second["y"] - case.clean) == pytest.approx(np.std(case.first["y"]) * case.rig.noise, rel=0.1)


@pytest.mark.parametrize(
    ("written", "law"),
    [
        ("f(y) = a·(y − y0)/c·exp(−((y − y0)/c)²), a = 22.20 ± 0.15 u, y0 = −0.081 ± 0.11 y, c = 59.12 y", "detent"),
        ("f = d(y)·v, d(y) = a·max(y − c, 0), a = 0.0069 ± 0.0001 u s/y^2, c = −0.1 ± 0.2 y", "damping on one side"),
        ("u' = u + a·dead_zone(u, c), a = −0.1896 ± 0.0021, c = 0.1455 ± 0.0017 u", "valve curve with two slopes"),
        ("f(v) = a·v³, a = (8.909 ± 0.030)·10⁻⁷ u s^3/y^3", "cubic drag"),
        ("f(v) = a·|v/180|^p, a = 0.08383 ± 0.00013 u, p = 0.9873 ± 0.0042", "damping in one direction"),
        ("w = y + a·exp(−y/c), a = −1.653 ± 0.052 y, c = 18.91 ± 0.20 y", "exponential sensor"),
        ("f(v) = a·|v|, a = 0.0004184 ± 0.0000027 u s/y", "damping in one direction"),
        ("f(y) = a·sin(2π·y/L) + b·cos(2π·y/L) + c·sin(4π·y/L) + d·cos(4π·y/L), a = 1 u", "cam with two harmonics"),
    ],
)
def test_a_formula_has_the_form_of_its_law_and_of_no_other(written, law):
    assert form_is_right(written, named(law).form)
    assert not form_is_right(written, "rational bump")
    constants = dict.fromkeys(("a", "b", "d", "c", "L", "p", "y0"), 2.0)
    assert np.isfinite(evaluated(written, np.linspace(0.1, 1.0, 5), constants)).all()


def test_a_formula_is_held_against_the_law_but_for_a_straight_line():
    ours = rig(named("cubic drag"), gain=-2.0)
    recording = pd.DataFrame({"y": np.sin(np.arange(200) / 10.0)})
    size = 0.3 * 2.0 / 2.0 / 15.0**3
    stated = {"variables": "velocity", "formula": "f(v) = a·v³ + b·v, a = 1 u, b = 1 u"}
    for wrong in (1.0, 1.1):
        constants = {"a": {"value": size * wrong}, "b": {"value": 7.0}}
        error = curve_error(ours, stated | {"formula_parameters": constants}, recording)
        assert error == pytest.approx(wrong - 1.0, abs=1e-6)
    assert np.isnan(curve_error(ours, {"variables": "position"}, recording))
    assert np.isnan(evaluated("f(v) = a·wobble(v), a = 1 u", np.ones(3), {"a": 1.0})).all()


def test_the_largest_share_carries_the_law_or_the_formula_in_its_place():
    cogging = {"id": "cogging", "evidence": {"share": 0.8}}
    learned = {"id": "learned-force", "evidence": {"share": 0.1}, "formula": "f(y) = a·y², a = 1 u"}
    assert carrier([cogging, learned]) is cogging
    stands = {**learned, "formula_replaces": ["cogging"]}
    assert carrier([cogging, stands]) is stands
    assert carrier([]) is None


@pytest.fixture(scope="module")
def answers():
    return pd.DataFrame([scored(SEED, 6, missing) for missing in (True, False)], columns=COLUMNS)


@pytest.mark.slow
def test_a_detent_is_recovered_and_nothing_is_learned_where_nothing_is_missing(answers):
    under, without = answers.iloc[0], answers.iloc[1]
    assert under["failure"] == without["failure"] == ""
    assert under["carrier_variables"] == "position"
    assert under["recovered"] > 0.7
    assert without["learned"] == 0


def test_the_committed_answers_meet_what_is_asked():
    rows = pd.read_csv(ROOT / "paper_figs/unlisted.csv").fillna({"formula": ""})
    tolerances = YAML(typ="safe").load(ROOT / "config/tolerances.yaml")
    comparison = compare(quantities(rows), [entry for entry in tolerances if entry["target"] == "unlisted"])
    assert len(comparison) == 5
    assert comparison["passed"].all(), comparison


@pytest.mark.slow
def test_table_and_figure_hold_every_law(answers):
    rows = judged(answers)
    text = to_markdown(rows, "a stamp", {"variables_right": "≥ 85"})
    assert "| detent" in text
    assert "| ≥ 85 %" in text
    assert "| recordings under a law" in text
    assert text.endswith("a stamp\n")
    drawn = figure.draw(rows)
    assert [label.get_text() for label in drawn.axes[0].get_yticklabels()] == ["detent"]
