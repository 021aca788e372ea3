"""Pairs of tables on two clocks: their motion against mathematics, what the tool states against the truth."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from camid.proof.two_clocks import motion, pairs
from camid.proof.two_clocks.campaign import campaign, scored, summary, to_markdown
from camid.proof.two_clocks.motion import Motion
from camid.proof.two_clocks.pairs import draw, tables

SEED = 1
# Of a truth from its estimate, in stated standard deviations: exceeded by one in 150 000.
FARTHEST = 4.5


@pytest.mark.parametrize("module", [motion, pairs])
def test_what_makes_tables_imports_nothing_of_camid(module):
    for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert all(name.name.split(".")[0] != "camid" for name in node.names)
        if isinstance(node, ast.ImportFrom):
            assert node.level <= 1
            assert node.module == "motion" if node.level else node.module.split(".")[0] != "camid"


def test_a_rig_answers_a_step_as_its_equation_is_solved_by_hand():
    frequency, damping, gain, start = 3.3, 0.12, 80.0, -2.0
    rig = Motion(frequency, damping, gain, np.r_[np.zeros(10), np.ones(190)], 0.01, start)
    speed = 2.0 * np.pi * frequency
    begins = start + 0.1
    pole = complex(-damping, np.sqrt(1.0 - damping**2)) * speed
    # y = gain / w^2 (1 + Re(residue exp(pole t))), with y = y' = 0 at first
    residue = complex(-1.0, -pole.real / pole.imag)

    def position(time):
        late = np.maximum(time - begins, 0.0)
        return gain / speed**2 * (1.0 + np.real(residue * np.exp(pole * late)))

    def integral(time):
        late = np.maximum(time - begins, 0.0)
        return gain / speed**2 * (late + np.real(residue / pole * (np.exp(pole * late) - 1.0)))

    times = np.linspace(start + 0.05, start + 1.9, 377)
    largest = float(np.max(position(times)))
    assert np.allclose(rig.position_at(times), position(times), rtol=0.0, atol=1e-6 * largest)
    mean = (integral(times) - integral(times - 0.013)) / 0.013
    assert np.allclose(rig.mean(times, 0.013), mean, rtol=0.0, atol=1e-6 * largest)


def test_pairs_are_what_they_are_said_to_be():
    for number in range(60):
        pair = draw(SEED, number)
        assert pair == draw(SEED, number)
        assert pair.method == ("match", "simulation")[number % 2]
        assert 0.02 - 1e-9 <= pair.hold / pair.rate <= 0.06 + 1e-9
        assert 0.2 <= pair.exposure * pair.frames <= 1.0
        assert abs(pair.offset) <= 20.0
        assert abs(pair.skew) <= 2e-3


def test_a_clip_shows_the_motion_of_the_drive_at_its_own_times():
    pair = replace(draw(SEED, 4), camera_noise=0.0, encoder_noise=0.0, lost=0.0, exposure=1e-4)
    clip, drive = tables(pair)
    ends = pair.to_drive(clip["t"].to_numpy())
    inside = (ends > drive["t"].iloc[1]) & (ends < drive["t"].iloc[-2])
    assert np.count_nonzero(inside) > 100
    # The encoder between its samples, from which a spline is off by little.
    from scipy.interpolate import CubicSpline

    seen = CubicSpline(drive["t"], drive["encoder"])(ends[inside] - 0.5 * pair.exposure)
    left = clip["x"][inside] - pair.scale * seen - pair.shift
    assert float(np.std(left)) < 1e-3 * float(np.std(clip["x"][inside]))
    held = drive["u"].to_numpy()[: len(drive) // pair.hold * pair.hold].reshape(-1, pair.hold)
    assert np.all(held == held[:, :1])


@pytest.mark.parametrize("number", [0, 1, 2, 4])
def test_clocks_are_what_they_are_said_to_be(number, tmp_path):
    pair = draw(SEED, number)
    found = scored(replace(pair, duration=20.0), tmp_path)
    assert found["failure"] == ""
    assert abs(found["offset_error"]) < FARTHEST * found["offset_deviation"]
    assert abs(found["skew_error"]) < FARTHEST * found["skew_deviation"]
    # A statement that is worth something.
    assert found["offset_deviation"] < 0.2 * found["frame"]


def test_a_shard_joins_its_share(tmp_path):
    assert campaign(SEED, 5, 2, 3, tmp_path)["number"].tolist() == [2]


def test_a_summary_counts_intervals_that_hold_the_truth():
    row = {"method": "match", "failure": "", "frame": 0.02, "offset_deviation": 1e-4, "skew_deviation": 1e-6}
    table = pd.DataFrame(
        [
            {**row, "offset_error": 1e-4, "skew_error": 1e-6, "offset_inside": True, "skew_inside": True},
            {**row, "offset_error": -3e-4, "skew_error": 0.0, "offset_inside": False, "skew_inside": True},
            {**row, "failure": "refused", "offset_inside": False, "skew_inside": False},
        ]
    )
    found = summary(table).set_index("method")
    assert found.loc["match", ["pairs", "failures"]].tolist() == [3, 1]
    assert found.loc["match", "offset_share"] == 0.5
    assert found.loc["all", "skew_share"] == 1.0
    assert found.loc["match", "offset_spread"] == pytest.approx(np.sqrt(5.0))
    assert found.loc["match", "worst"] == pytest.approx(0.015)
    text = " ".join(to_markdown(summary(table), "Made by a test.").split())
    assert "| the encoder | 3 | 1 | 50.0 %" in text
    assert "| 1.00 | 0.50 | 1.50 |" in text
