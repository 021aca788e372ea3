"""The second generator of concealed recordings: what it promises, without a look at what it judges."""

import ast
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from camid.proof import second_author
from camid.proof.second_author.chain import run
from camid.proof.second_author.detectability import remainder
from camid.proof.second_author.excitations import EXCITATIONS
from camid.proof.second_author.laws import CATALOGUE, OUTSIDE, Law
from camid.proof.second_author.recordings import Made, kinds, make
from camid.proof.second_author.rigs import Rig
from camid.proof.second_author.unusual import INEXACT

COUNT = 10
SEED = 7
SPRING = Rig("spring", (100.0,), (1.0, 2.0, 100.0), 0.1, 0.02, 800, 1.0)


@pytest.fixture(scope="module")
def made() -> list[Made]:
    return [make(SEED, index, COUNT) for index in range(COUNT)]


def law(identifier: str, **parameters: float | str) -> Law:
    return Law(identifier, CATALOGUE[identifier], "catalogue", dict(parameters))


def test_it_imports_nothing_of_camid():
    folder = Path(second_author.__file__).parent
    sources = sorted(folder.glob("*.py"))
    siblings = {source.stem for source in sources}
    allowed = {
        "numpy",
        "scipy",
        "pandas",
        "numba",
        "math",
        "dataclasses",
        "collections",
        "typing",
        "enum",
        "hashlib",
        "pathlib",
    }
    for source in sources:
        for node in ast.walk(ast.parse(source.read_text())):
            if isinstance(node, ast.Import):
                assert {name.name.split(".")[0] for name in node.names} <= allowed, source
            if isinstance(node, ast.ImportFrom):
                assert node.level <= 1, source
                # The project's folder of compiled code is all that this generator shares with it.
                if node.module != "camid.compiled":
                    assert str(node.module).split(".")[0] in (siblings if node.level else allowed), source


def test_the_same_numbers_give_the_same_bytes(made: list[Made]):
    for index in (0, 3, 8):
        again = make(SEED, index, COUNT)
        assert again.recording.to_csv() == made[index].recording.to_csv()
        assert again.simulation == made[index].simulation
        assert again.truth == made[index].truth
        if again.again is not None:
            assert again.again.equals(made[index].again)


def test_another_seed_gives_another_recording(made: list[Made]):
    assert not make(SEED + 1, 0, COUNT).recording.equals(made[0].recording)


@pytest.mark.parametrize(("count", "numbers"), [(20, (8, 5, 3, 2, 2)), (400, (160, 100, 60, 40, 40))])
def test_shares_of_the_kinds(count: int, numbers: tuple[int, ...]):
    listed = kinds(3, count)
    assert tuple(listed.count(kind) for kind in ("none", "single", "several", "outside", "inexact")) == numbers


def test_truths_have_the_form_that_was_agreed(made: list[Made]):
    truths = [one.truth for one in made]
    assert [truth["kind"] for truth in truths].count("none") == 4
    for truth in truths:
        effects = truth["effects"]
        number = {"none": (0,), "single": (1,), "outside": (1,), "several": (2, 3)}[truth["kind"]]
        assert len(effects) in number
        for effect in effects:
            assert set(effect) == {"id", "place", "law", "parameters", "multiple"}
            if truth["kind"] == "outside":
                assert effect["id"] in OUTSIDE
            else:
                assert effect["place"] == CATALOGUE[effect["id"]]
                assert effect["law"] in {"catalogue", INEXACT.get(effect["id"])}
            if effect["multiple"] is not None:
                assert effect["multiple"] >= (1.5 if truth["kind"] == "several" else 0.4)


def test_every_id_comes_before_one_comes_twice():
    assert not set(OUTSIDE) & set(CATALOGUE)
    assert set(INEXACT) <= set(CATALOGUE)
    assert len(CATALOGUE) == 46
    assert len(EXCITATIONS) >= 20


def test_recordings_are_finite_and_of_the_agreed_columns(made: list[Made]):
    for one in made:
        wanted = ["t", *(["r"] if "controller" in one.simulation else [])]
        wanted += [*(["u"] if one.simulation["input"] is not None else []), "y"]
        assert list(one.recording.columns) == wanted
        assert 1200 <= len(one.recording) <= 2500
        assert np.all(np.isfinite(one.recording))
        steps = np.diff(one.recording["t"])
        assert np.allclose(steps, steps[0], rtol=1e-6)
        if one.again is not None:
            assert list(one.again.columns) == [*wanted, "clean"]
            compared = one.again["u" if "controller" in one.simulation else "y"]
            noise = compared - one.again["clean"]
            assert noise.std() < 0.6 * one.again["clean"].std()


def test_beliefs_are_wrong_by_a_fifth_at_most_and_conceal_the_effect(made: list[Made]):
    for one in made:
        hidden = {effect["id"] for effect in one.truth["effects"]}
        assert hidden.isdisjoint(known["id"] for known in one.simulation["effects"])
        if "transfer_function" in one.simulation["plant"]:
            poles = np.roots(one.simulation["plant"]["transfer_function"]["denominator"])
            assert np.all(poles.real <= 1e-12)


def test_a_held_input_is_integrated_exactly():
    drive = np.ones(SPRING.samples)
    made = run(SPRING, [], drive)
    fast = np.sqrt(99.0)
    exact = 1.0 - np.exp(-made.time) * (np.cos(fast * made.time) + np.sin(fast * made.time) / fast)
    assert np.abs(made.output - exact).max() < 1e-6


def test_friction_holds_what_it_can_and_stops_a_swing_in_equal_steps():
    level = 0.3 * np.ones(SPRING.samples)
    assert np.all(run(SPRING, [law("coulomb-friction", force=0.31)], level).output == 0.0)
    assert run(SPRING, [law("coulomb-friction", force=0.29)], level).output[-1] > 0.0
    free = Rig("free", (100.0,), (1.0, 0.0, 100.0), 0.1, 0.002, 4000, 1.0, initial=(1.0, 0.0), driven=False, lead=0)
    swing = np.abs(run(free, [law("coulomb-friction", force=0.05)], np.zeros(4000)).output)
    peaks = swing[1:-1][(swing[1:-1] >= swing[:-2]) & (swing[1:-1] > swing[2:])]
    assert np.allclose(peaks[:5], 1.0 - 0.1 * np.arange(1, 6), atol=1e-3)


def test_drag_takes_energy_and_a_spring_does_not():
    free = Rig("free", (100.0,), (1.0, 0.0, 100.0), 0.1, 0.02, 1000, 1.0, initial=(1.0, 0.0), driven=False)
    still = np.zeros(1000)
    assert np.abs(run(free, [law("cubic-stiffness", coefficient=0.5)], still).output[-100:]).max() > 0.999
    assert np.abs(run(free, [law("quadratic-drag", coefficient=0.01)], still).output[-100:]).max() < 0.5


def test_an_exposure_averages_and_a_delay_shifts():
    drive = EXCITATIONS["multisine, dense"](np.random.default_rng(1), 800, 5.0)
    instant = run(SPRING, [], drive)
    camera = run(Rig(**{**SPRING.__dict__, "kind": "camera", "exposure": 0.02}), [], drive)
    fine = instant.time[100:, None] - 0.02 * (np.arange(200) + 0.5) / 200
    assert np.allclose(camera.output[100:], instant.trajectory.position(fine).mean(axis=1), atol=1e-6)
    late = run(SPRING, [law("delay", delay=0.02)], drive)
    assert np.allclose(late.output[1:], instant.output[:-1], atol=1e-9)


def test_what_coefficients_imitate_does_not_count():
    columns = np.random.default_rng(1).standard_normal((50, 3))
    assert remainder(columns @ np.array([1.0, -2.0, 3.0]), columns) < 1e-10


def test_a_recording_is_a_table(made: list[Made]):
    assert all(isinstance(one.recording, pd.DataFrame) for one in made)
