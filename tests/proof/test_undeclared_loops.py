"""Recordings of machines under controllers that nobody declared: the generator against itself and the tool."""

import json
import subprocess
import sys
from collections import Counter

import numpy as np
import pandas
import pytest

from camid.proof.undeclared_loops.concealment import CATALOGUE, Law, conceal, installed
from camid.proof.undeclared_loops.observation import observe
from camid.proof.undeclared_loops.recordings import SHARES, kinds, make, staged
from camid.proof.undeclared_loops.scenes import Scene

COUNT = 200


def _scene(name: str, number: int = 5) -> tuple[Scene, list[Law], list[float]]:
    return conceal(np.random.default_rng([number, sum(map(ord, name))]), (name,))


@pytest.fixture(scope="module")
def recordings():
    return [make(21, index, COUNT) for index in range(12)]


def test_the_same_numbers_give_the_same_bytes(recordings):
    for index in (0, 3, 7):
        once, again = recordings[index], make(21, index, COUNT)
        assert once.recording.to_csv() == again.recording.to_csv()
        assert json.dumps([once.simulation, once.truth]) == json.dumps([again.simulation, again.truth])
        assert (once.again is None) == (again.again is None)
        if once.again is not None:
            assert once.again.to_csv() == again.again.to_csv()


def test_shares_of_kinds():
    counts = Counter(kinds(3, COUNT))
    assert {kind: counts[kind] / COUNT for kind in SHARES} == pytest.approx(SHARES)
    assert kinds(3, COUNT) == kinds(3, COUNT) != kinds(4, COUNT)


@pytest.mark.parametrize("name", ["stribeck-friction", "cogging", "end-stop", "rate-limit", "soft rate", "creep",
                                  "hysteresis", "output-backlash", "compliant play"])  # fmt: skip
def test_half_the_step_changes_far_less_than_the_noise(name):
    scene, laws, _ = _scene(name)
    setup = installed(scene, laws)
    seen = [observe(scene.moved(setup, parts), setup, -scene.lead, scene.rows) for parts in (8, 16)]
    assert np.abs(seen[0] - seen[1]).max() < 0.03 * scene.noise


@pytest.mark.parametrize("name", ["coulomb-friction", "stribeck-friction", "load-dependent-friction", "cogging",
                                  "end-stop", "parameter-drift", "backlash", "rate-limit", "perspective",
                                  "impulse-disturbance"])  # fmt: skip
@pytest.mark.slow
def test_laws_are_those_of_the_catalogue(name, tmp_path):
    """The tool, given the true coefficients and laws, makes the same output.

    The plant integrates, and the tool runs it without its loop, so that differences of both integrators add up: the
    first third is compared, to a hundredth of a thousandth of the spread. A recording that begins amid the motion is
    left aside, as its first exposures reach back to before its first row.
    """
    scene, laws, _ = next(made for made in (_scene(name, number) for number in range(50)) if made[0].lead == 0)
    setup = installed(scene, laws)
    motion = scene.moved(setup, 8)
    rows = scene.rows // 3
    clean = observe(motion, setup, 0, rows)
    time = np.round(scene.rig.period * np.arange(rows), 9)
    pandas.DataFrame({"t": time, "u": motion.command[:rows], "y": clean}).to_csv(tmp_path / "r.csv", index=False)
    camera = scene.camera
    seen = {"kind": "camera", "exposure": camera.exposure} if camera.exposure else {"kind": "instant"}
    plant = {"numerator": [scene.rig.gain], "denominator": [1.0, *scene.rig.damping, 0.0]}
    simulation = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": plant},
        "sensor": {"column": "y", **seen, "latency": camera.latency},
        "initial_state": "zero",
        "effects": [{"id": law.identifier, "parameters": law.parameters} for law in laws],
    }
    (tmp_path / "s.yaml").write_text(json.dumps(simulation))
    command = [sys.executable, "-m", "camid", "simulate", "r.csv", "--simulation", "s.yaml", "--output", "o.csv"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    made = pandas.read_csv(tmp_path / "o.csv")["simulated"].to_numpy()
    assert np.abs(made - clean).max() < 1e-5 * clean.std()


def test_multiples_and_ranges(recordings):
    for index, made in enumerate(recordings):
        assert np.all(np.isfinite(made.recording.to_numpy()))
        assert list(made.recording) == ["t", "u", "y"]
        assert 1500 <= len(made.recording) <= 3500
        effects = made.truth["effects"]
        assert all(np.isfinite(effect["multiple"]) and effect["multiple"] > 0.0 for effect in effects)
        assert (made.truth["kind"] == "none") == (not effects)
        assert made.truth["kind"] in {"none", "single", "several", "outside"}
        limit = staged(21, index, COUNT)[0].rig.limit
        saturated = any(effect["id"] == "saturation" for effect in effects)
        assert saturated or np.mean(np.abs(made.recording["u"]) > 0.999 * limit) < 0.3
        if made.again is not None:
            assert list(made.again) == ["t", "u", "y", "clean"]
            assert np.all(np.isfinite(made.again.to_numpy()))


def test_a_catalogue_law_is_marked_as_such(recordings):
    for made, kind in zip(recordings, kinds(21, COUNT), strict=False):
        exact = [effect["law"] == "catalogue" for effect in made.truth["effects"]]
        assert all(exact) if kind in {"single", "several"} else not any(exact)
        if kind != "outside":
            assert {effect["id"] for effect in made.truth["effects"]} <= set(CATALOGUE)
