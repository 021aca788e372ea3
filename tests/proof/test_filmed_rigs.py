"""Filmed rigs: motion and pictures against mathematics, and a clip from pictures to a diagnosis."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from camid.proof.filmed_rigs import renderer, rigs
from camid.proof.filmed_rigs.campaign import COLUMNS, commands, judged, scored, to_markdown
from camid.proof.filmed_rigs.rigs import CONCEALED, CUBIC, FRICTION, NOTHING, PERSPECTIVE, ROLLING_SHUTTER, draw, run

SEED = 1


@pytest.mark.parametrize("module", [rigs, renderer])
def test_what_makes_clips_imports_nothing_of_camid(module):
    for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert all(name.name.split(".")[0] != "camid" for name in node.names)
        if isinstance(node, ast.ImportFrom):
            assert node.level <= 1
            assert node.module == "rigs" if node.level else node.module.split(".")[0] != "camid"


def rig_with(concealed, **changes):
    return replace(draw(SEED, CONCEALED.index(concealed)), rate=100, hold=10, frames=60, lead=0.5, **changes)


def test_a_hard_spring_moves_as_another_integrator_says():
    rig = rig_with(CUBIC, size=0.3)
    found = run(rig, SEED, 0)
    assert np.ptp(found.position) == pytest.approx(rig.motion)
    stiffness, drag = (2.0 * np.pi * rig.frequency) ** 2, 4.0 * np.pi * rig.frequency * rig.damping
    cubic = 0.3 / np.max(np.abs(found.position)) ** 2
    state, exact = [0.0, 0.0], [0.0]
    for level in found.levels:

        def rates(_, x, level=level):
            return [x[1], found.gain * level - drag * x[1] - stiffness * x[0] * (1.0 + cubic * x[0] ** 2)]

        state = solve_ivp(rates, (0.0, 0.01), state, "DOP853", rtol=1e-10, atol=1e-9).y[:, -1]
        exact.append(state[0])
    # The share that was drawn is reached to a few thousandths, and what is left is that.
    assert np.allclose(found.position[::80], exact, rtol=0.0, atol=2e-3 * rig.motion)


def test_dry_friction_stops_a_free_motion_where_it_is_worked_out_by_hand():
    rig = rig_with(FRICTION, frequency=1.0, damping=0.0)
    stiffness, friction = (2.0 * np.pi) ** 2, 0.07
    # Pulled to 0.5 / stiffness against friction from rest: each half swing loses 2 friction / stiffness.
    pulled = rigs.integrated(rig, np.full(1000, 0.5), 40, friction, 0.0)
    turns = pulled[::2000][:4] * stiffness  # every half second
    assert turns == pytest.approx([0.0, 0.86, 0.28, 0.58], abs=1e-4)
    assert np.ptp(pulled[-4000:]) == 0.0
    assert abs(0.5 - stiffness * pulled[-1]) <= friction


def middle_of(rig, motion, stamp):
    """Centroid of a picture along the motion, px from where the rig rests."""
    shares, begin = renderer.coverage(rig, motion, stamp)
    weights = shares.sum(axis=1)
    return float(weights @ (begin + np.arange(len(shares))) / weights.sum() - renderer.rest(rig, motion))


def means(rig, motion, stamp, measured):
    ends = rig.to_drive(stamp - rig.exposure * (np.arange(400) + 0.5) / 400)
    return float(np.mean(measured(ends)))


def test_pictures_show_the_mean_over_the_exposure():
    rig = rig_with(NOTHING)
    motion = run(rig, SEED, 0)
    for stamp in rig.stamps[::12]:
        assert middle_of(rig, motion, stamp) == pytest.approx(means(rig, motion, stamp, motion.at), abs=0.01)


def test_a_rolling_shutter_shows_each_row_later():
    rig = rig_with(ROLLING_SHUTTER)
    motion, late = run(rig, SEED, 0), renderer.line_time(rig)

    def shown(ends):
        seen = motion.at(ends)
        for _ in range(20):
            seen = motion.at(ends + late * seen)
        return seen

    assert 0.2 <= late * rig.motion * rig.frame_rate <= 0.6
    for stamp in rig.stamps[::12]:
        assert middle_of(rig, motion, stamp) == pytest.approx(means(rig, motion, stamp, shown), abs=0.05)


def test_an_oblique_view_changes_the_scale_over_the_motion():
    rig = rig_with(PERSPECTIVE, size=0.25)
    motion = run(rig, SEED, 0)
    slant = renderer.obliqueness(rig, motion)
    ends = np.array([motion.position.min(), motion.position.max()])
    scales = 1.0 / (1.0 + slant * ends) ** 2
    assert scales[0] / scales[1] == pytest.approx(1.25)
    for stamp in rig.stamps[::12]:
        wanted = means(rig, motion, stamp, lambda ends: motion.at(ends) / (1.0 + slant * motion.at(ends)))
        # The picture of a disc that is seen obliquely has its middle a little beside that of the disc.
        assert middle_of(rig, motion, stamp) == pytest.approx(wanted, abs=0.15)


@pytest.mark.slow
def test_a_clip_goes_from_pictures_to_a_diagnosis(tmp_path):
    found = scored(draw(SEED, 0), SEED, 0, tmp_path)
    assert found["concealed"] == NOTHING
    assert found["failure"] == ""
    assert abs(found["offset_error"]) < 0.05
    assert abs(found["skew_error"]) < 2e-4
    assert [arguments[0] for arguments in commands(draw(SEED, 0), tmp_path)] == ["track", "join", "diagnose"]


def entry(identifier, *others):
    return {"id": identifier, "alternatives": [{"id": other, "weight": 0.2} for other in others]}


def test_what_is_right():
    coulomb = {"verdict": "explained", "effects": [entry("stribeck-friction", FRICTION)]}
    assert judged(FRICTION, coulomb)["right"]
    assert judged(FRICTION, coulomb)["weight"] == pytest.approx(0.8)
    assert not judged(CUBIC, coulomb)["right"]
    assert not judged(NOTHING, coulomb)["right"]
    assert judged(NOTHING, {"verdict": "adequate", "effects": []})["right"]
    assert judged(NOTHING, {"verdict": "explained", "effects": [entry("coloured-noise")]})["right"]
    assert not judged(NOTHING, {"verdict": "unexplained", "effects": []})["right"]
    assert not judged(NOTHING, None)["right"]
    second = {"verdict": "explained", "effects": [entry("delay"), entry(CUBIC)]}
    assert not judged(CUBIC, second)["right"]


def test_a_table_has_a_line_for_each_clip():
    row = dict.fromkeys(COLUMNS, 0.1) | {"clip": 3, "concealed": CUBIC, "verdict": "explained", "named": CUBIC}
    row |= {"right": True, "alternatives": "", "failure": ""}
    text = " ".join(to_markdown(pd.DataFrame([row]), "Made by a test.").split())
    assert "| 3 | cubic-stiffness | 10 % | explained | cubic-stiffness | 10 % | | yes | +0.100 |" in text
    assert "Right: 1 of 1 (cubic-stiffness: 1 of 1)." in text
