"""Rigs of named constants: their recordings against mathematics, and what the tool states of them against the truth."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from camid.proof.physical_rigs import motions, plants, rigs, simulator
from camid.proof.physical_rigs.campaign import (
    cases,
    estimates,
    meaning,
    say_the_same,
    summary,
    summary_of_undetermined,
    to_markdown,
    undetermined,
)
from camid.proof.physical_rigs.rigs import AMBIGUOUS, RIGS, Rig

SEED = 1
# Of a truth from its estimate, in stated standard deviations: exceeded by one in 150 000.
FARTHEST = 4.5


def named(name: str) -> Rig:
    return next(rig for rig in (*RIGS, *AMBIGUOUS) if rig.name == name)


def name_of(rig: Rig) -> str:
    return rig.name


@pytest.mark.parametrize("module", [rigs, motions, plants, simulator])
def test_what_makes_recordings_imports_nothing_of_camid(module):
    allowed = {"motions", "plants", "rigs", None}
    for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert all(name.name.split(".")[0] != "camid" for name in node.names)
        if isinstance(node, ast.ImportFrom):
            assert node.level <= 1
            assert node.module in allowed if node.level else node.module.split(".")[0] != "camid"


def test_a_cart_moves_as_its_equation_is_solved_by_hand():
    cart = named("cart")
    mass, damping, force = cart.truth["mass"], cart.truth["damping"], 3.0
    end = cart.period * np.arange(60)

    def integral(time):
        """Of the position since the force began, m s."""
        late, lag = np.maximum(time, 0.0), mass / damping
        return force / damping * (late**2 / 2.0 - lag * late + lag**2 * (1.0 - np.exp(-late / lag)))

    exact = (integral(end) - integral(end - cart.exposure)) / cart.exposure
    assert np.allclose(simulator.frames(cart, [0.0, *[force] * 59]), exact, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["pendulum", "float", "two tanks"])
def test_nonlinear_rigs_agree_with_another_integrator(name):
    rig = replace(named(name), frames=80)
    levels = [rig.middle, *simulator.excitation(rig, np.random.default_rng(SEED))[:-1]]
    state, exact = np.array([*rig.start, 0.0]), []
    for level in levels:

        def rates(_, x, level=level):
            return [*rig.rates(x, level, rig.truth), rig.output(x)]

        found = solve_ivp(
            rates, (0.0, rig.period), state, "Radau", [rig.period - rig.exposure, rig.period], rtol=1e-11, atol=1e-13
        ).y
        exact.append((found[-1, 1] - found[-1, 0]) / rig.exposure)
        state = np.array([*found[:-1, 1], 0.0])
    assert np.allclose(simulator.frames(rig, levels), exact, rtol=0.0, atol=1e-6 * np.std(exact))


@pytest.mark.parametrize("rig", [*RIGS, *AMBIGUOUS], ids=name_of)
def test_recordings_are_the_same_every_time_and_of_another_seed_others(rig):
    short = replace(rig, frames=60)
    first, again, other = (simulator.record(short, simulator.generator(short, seed)) for seed in (1, 1, 2))
    assert first.equals(again)
    assert not first.equals(other)
    assert list(first.columns) == (["t", "y"] if rig.decays_freely else ["t", "u", "y"])
    assert 600 <= rig.frames <= 1500
    assert 0.005 <= rig.noise <= 0.03
    assert set(rig.fixed) <= set(rig.truth)


@pytest.mark.parametrize("rig", RIGS, ids=name_of)
def test_constants_are_where_they_are_said_to_be(rig):
    found = estimates(rig, SEED)
    assert found["converged"].all()
    assert tuple(found["constant"]) == rig.free
    errors = (found["estimate"] - found["truth"]) / found["standard_deviation"]
    assert (errors.abs() < FARTHEST).all()
    # A statement that is worth something: the first values were off by tens of percent.
    assert (found["standard_deviation"] < 0.02 * found["truth"]).all()


@pytest.mark.parametrize("rig", AMBIGUOUS, ids=name_of)
def test_what_no_recording_tells_apart_is_named(rig):
    found = undetermined(rig, SEED)
    assert found[["open", "named", "converged"]].all(axis=None)
    assert len(found) == len(rig.combinations) + len(set(rig.free) - rig.open)
    errors = (found["estimate"] - found["truth"]) / found["standard_deviation"]
    assert (errors.abs() < FARTHEST).all()


def test_combinations_are_compared_by_what_they_say():
    tanks = named("two unequal tanks")
    assert say_the_same(tanks, ["pump/upper_out^2", "lower_in*upper_out"])
    assert say_the_same(tanks, ["lower_in^2*pump", "upper_out/sqrt(pump)"])
    assert not say_the_same(tanks, ["pump/upper_out^2"])
    assert not say_the_same(tanks, ["pump/upper_out^2", "lower_out"])
    assert not say_the_same(tanks, ["pump/upper_out^2", "sqrt(pump)/upper_out"])
    assert meaning("2*pump^2")({"pump": 3.0}) == 18.0


def test_shards_share_the_recordings_out():
    shared = [cases(RIGS, 7, 3, shard, 4) for shard in range(4)]
    assert sorted((rig.name, seed) for part in shared for rig, seed in part) == sorted(
        (rig.name, seed) for rig in RIGS for seed in (7, 8, 9)
    )


def test_a_summary_counts_intervals_that_hold_the_truth():
    row = {"rig": "cart", "constant": "mass", "truth": 2.0, "believed": 1.0, "standard_deviation": 0.1}
    table = pd.DataFrame(
        [
            {**row, "seed": 1, "estimate": 2.1, "inside": True, "converged": True},
            {**row, "seed": 2, "estimate": 2.3, "inside": False, "converged": True},
            {**row, "seed": 3, "estimate": 9.9, "inside": False, "converged": False},
        ]
    )
    found = summary(table).set_index("rig")
    assert found.loc["cart", ["recordings", "converged", "intervals"]].tolist() == [3, 2, 2]
    assert found.loc["all", "share"] == 0.5
    assert found.loc["cart", "spread"] == pytest.approx(np.sqrt(5.0))
    words = table.assign(rig="two dampers in parallel", open=[True, False, True], named=True)
    second = summary_of_undetermined(words)
    assert second["open"].tolist() == [2, 2]
    text = to_markdown(summary(table), second, "Made by a test.")
    assert "| cart | mass, damping | 3" in " ".join(text.split())
    assert "2 of 3" in text
