"""The generator of concealed recordings, against its contract, and its truths against plain equations of motion."""

from __future__ import annotations

import ast
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.effects import known_effects
from camid.proof.concealed.cases import CATALOGUE, OUTSIDE
from camid.proof.concealed.detectability import Belief
from camid.proof.concealed.drawn_recording import draw_recording
from camid.proof.concealed.generator import Case, make, plan
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

SOURCE = Path(camid.__file__).parent
FORBIDDEN = ("camid.engine", "camid.effects", "camid.fitting", "camid.diagnosis")

# The effect ids of the design.
IDENTITIES = [
    "dead-zone",
    "saturation",
    "backlash",
    "rate-limit",
    "actuator-lag",
    "gain-asymmetry",
    "input-hold",
    "input-bias",
    "coulomb-friction",
    "stribeck-friction",
    "quadratic-drag",
    "cubic-stiffness",
    "quadratic-stiffness",
    "pendulum-gravity",
    "end-stop",
    "hysteresis",
    "extra-mode",
    "parameter-drift",
    "periodic-disturbance",
    "step-disturbance",
    "impulse-disturbance",
    "exposure",
    "delay",
    "rolling-shutter",
    "clock-skew",
    "timestamp-jitter",
    "lens-distortion",
    "clipping",
    "quantisation",
    "sensor-offset",
    "sensor-drift",
    "dropped-frames",
    "outliers",
    "absolute-value",
    "speed-weighted-centroid",
    "coloured-noise",
    # What real rigs showed missing.
    "asymmetric-friction",
    "position-dependent-friction",
    "load-dependent-friction",
    "amplitude-dependent-damping",
    "cogging",
    "parallel-mode",
    "square-root-outflow",
    "overflow",
    "encoder-eccentricity",
    "output-backlash",
    "input-quantisation",
]


def file_of(module: str) -> Path | None:
    """Source of a module of the package; None of others."""
    path = SOURCE.joinpath(*module.split(".")[1:])
    for candidate in (path.with_suffix(".py"), path / "__init__.py"):
        if module.startswith("camid.") and candidate.is_file():
            return candidate
    return None


def imported(path: Path) -> set[str]:
    """Names of all modules that a file imports, wherever in the file."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def reached(module: str) -> set[str]:
    """All modules of the package that a module imports, directly or through others."""
    found, waiting = set(), [module]
    while waiting:
        name = waiting.pop()
        path = file_of(name)
        if name in found or (path is None and not name.startswith(FORBIDDEN)):
            continue
        found.add(name)
        waiting += imported(path) if path is not None else []
    return found


def test_generator_shares_no_code_with_the_tool():
    modules = reached("camid.proof.concealed.generator")
    assert {
        "camid.proof.concealed.machine_integrator",
        "camid.proof.concealed.machine_forces",
        "camid.identification.estimate",
    } <= modules
    assert not [name for name in modules if name.startswith(FORBIDDEN)]


def test_the_walk_finds_an_import(tmp_path):
    hidden = tmp_path / "hidden.py"
    hidden.write_text("def run():\n    from camid.engine import run\n    return run\n", encoding="utf-8")
    assert "camid.engine.run" in imported(hidden)
    # Through another module, too.
    assert "camid.chain.exact" not in imported(SOURCE / "proof" / "concealed" / "image_readings.py")
    assert "camid.chain.exact" in reached("camid.proof.concealed.generator")


# Where the search for such a recording ends, so that those which do not fit need not be made.
FIRST = {"periodic-disturbance": 318}


def one_that(identity: str, fits, smallest: float = 3.0):
    """A recording of a catalogue's law that stands well above the noise and fits as it is drawn."""
    for index in range(FIRST.get(identity, 301), 500):
        case = Case(3, index, "several", (identity,))
        if not fits(draw_recording(*started(case))):
            continue
        made = make(case)
        effect = made.truth["effects"][0]
        if effect["law"] == "catalogue" and effect["multiple"] > smallest:
            return made
    raise AssertionError(f"no {identity} that fits")


def started(case: Case) -> tuple[Case, np.random.Generator]:
    """A case and the source of its first draws, as making it would take them."""
    return case, np.random.default_rng(np.random.SeedSequence([case.seed, case.index]).spawn(3)[0])


def force_of(identity: str, p: dict, y: float, v: float) -> float:
    """Force of a catalogue effect in units of u, written from the design's conventions."""
    match identity:
        case "cubic-stiffness":
            return p["coefficient"] * y**3
        case "quadratic-stiffness":
            return p["coefficient"] * y**2
        case "quadratic-drag":
            return p["coefficient"] * abs(v) * v
        case "end-stop":
            side = np.sign(p["position"])
            return side * p["stiffness"] * max(side * (y - p["position"]), 0.0)
        case "pendulum-gravity":
            return p["linear"] * (p["amplitude"] * np.sin(y / p["amplitude"]) - y)
    raise AssertionError(identity)


def reference(truth: dict, u: np.ndarray, frames: int, steps: int = 60) -> np.ndarray:
    """Y = G (u + d - f) with numbers of the truth alone, by a fixed-step Runge–Kutta method in the units of u, y, s."""
    (gain,), (_, a1, a2) = truth["plant"]["numerator"], truth["plant"]["denominator"]
    effect = truth["effects"][0]
    identity, p, h = effect["id"], dict(effect["parameters"], linear=a2 / gain), truth["period"] / steps
    periodic = identity == "periodic-disturbance"
    loop = identity == "hysteresis"

    def rates(t, state, command):
        y, v, z = state
        force = command
        if periodic:
            force += p["amplitude"] * np.sin(p["frequency"] * t + p["phase"])
        elif identity == "input-bias":
            force += p["bias"]
        elif loop:
            force -= p["strength"] * z
        else:
            force -= force_of(identity, p, y, v)
        slope = p["shape"] * (v - 0.5 * abs(v) * z - 0.5 * v * abs(z)) if loop else 0.0
        return np.array([v, gain * force - a1 * v - a2 * y, slope])

    state, path = np.zeros(3), [0.0]
    for k in range(frames):
        for i in range(steps):
            t = k * truth["period"] + i * h
            k1 = rates(t, state, u[k])
            k2 = rates(t + 0.5 * h, state + 0.5 * h * k1, u[k])
            k3 = rates(t + 0.5 * h, state + 0.5 * h * k2, u[k])
            k4 = rates(t + h, state + h * k3, u[k])
            state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            path.append(state[0])
    nodes = h * np.arange(len(path))
    integral = np.concatenate([[0.0], np.cumsum(0.5 * h * (np.array(path)[1:] + np.array(path)[:-1]))])
    end = np.arange(frames) * truth["period"] - truth["latency"]
    if truth["exposure"] == 0.0:
        return np.interp(end, nodes, path)
    begin = end - truth["exposure"]
    return (np.interp(end, nodes, integral) - np.interp(begin, nodes, integral)) / truth["exposure"]


@pytest.mark.parametrize(
    "identity",
    [
        "cubic-stiffness",
        "quadratic-stiffness",
        "quadratic-drag",
        "end-stop",
        "pendulum-gravity",
        "hysteresis",
        "periodic-disturbance",
        "input-bias",
    ],
)
def test_truth_describes_the_motion_in_units_of_the_recording(identity):
    made = one_that(identity, lambda drawn: drawn.setup.rig.order == 2 and not drawn.setup.moving)
    truth = made.truth
    frames = 60
    expected = reference(truth, made.same_kind["u"].to_numpy(), frames)
    got = made.same_kind["clean"].to_numpy()[:frames]
    assert np.max(np.abs(got - expected)) < 2e-3 * np.std(got)
    # The effect shows in these frames, so that the agreement says something of it.
    plain = sample(
        TransferFunction(tuple(truth["plant"]["numerator"]), tuple(truth["plant"]["denominator"])),
        made.same_kind["u"].to_numpy(),
        Acquisition(
            truth["period"], "zoh", made.simulation["sensor"]["kind"], truth["exposure"] or None, truth["latency"]
        ),
    )[:frames]
    assert np.max(np.abs(plain - got)) > 5.0 * np.max(np.abs(expected - got))


def exact(truth: dict, u: np.ndarray, kind: str) -> np.ndarray:
    """Output of a linear effect with numbers of the truth alone, by the exact chain."""
    plant = TransferFunction(tuple(truth["plant"]["numerator"]), tuple(truth["plant"]["denominator"]))
    effect, latency, exposure = truth["effects"][0], truth["latency"], truth["exposure"]
    p = effect["parameters"]
    if effect["id"] == "delay":
        latency += p["delay"]
    elif effect["id"] == "exposure":
        assert p["exposure"] == exposure
    elif effect["id"] == "actuator-lag":
        plant = plant * TransferFunction((1.0,), (p["time_constant"], 1.0))
    elif effect["id"] == "extra-mode":
        plant = plant * second_order(1.0, p["natural_frequency"], p["damping"])
    elif effect["id"] == "gain-asymmetry":
        u = np.where(u < 0.0, p["ratio"] * u, u)
    elif effect["id"] == "dead-zone":
        u = np.sign(u) * np.maximum(np.abs(u) - p["half_width"], 0.0)
    elif effect["id"] == "saturation":
        u = np.clip(u, -p["limit"], p["limit"])
    else:
        assert p == {"hold": "foh"} == {"hold": truth["hold"]}
    return sample(plant, u, Acquisition(truth["period"], truth["hold"], kind, exposure or None, latency))


@pytest.mark.parametrize(
    "identity",
    ["delay", "exposure", "actuator-lag", "extra-mode", "gain-asymmetry", "dead-zone", "saturation", "input-hold"],
)
def test_truth_of_linear_and_static_effects_is_exact(identity):
    made = one_that(identity, lambda drawn: not drawn.setup.moving, smallest=1.0)
    declared = made.simulation["sensor"]
    frames = slice(0, len(made.same_kind) - 2)  # the straight line from the last sample has no known end
    for table in (made.same_kind, made.double_amplitude):
        output = table["clean"].to_numpy()[frames]
        expected = exact(made.truth, table["u"].to_numpy(), declared["kind"])[frames]
        assert np.max(np.abs(output - expected)) < 5e-6 * np.std(expected)
    if identity != "exposure":
        assert declared.get("exposure", 0.0) == made.truth["exposure"]


def test_every_effect_of_the_design_is_made():
    # camid knows more than the design asks, and all that it knows is concealed.
    assert set(IDENTITIES) < set(CATALOGUE) == set(known_effects())
    cases = plan(1, 500)
    kinds = Counter(case.kind for case in cases)
    assert kinds["none"] == 200
    assert kinds["several"] == 75
    assert Counter(case.snr_db for case in cases if case.kind == "outside") == {20.0: 40, 40.0: 40}
    singles = Counter(case.effects[0] for case in cases if case.kind == "single")
    assert set(singles) == set(CATALOGUE)
    assert max(singles.values()) - min(singles.values()) <= 1
    assert {case.effects[0] for case in cases if case.kind == "outside"} == set(OUTSIDE)
    for case in cases:
        if case.kind == "several":
            places = [CATALOGUE[name].place for name in case.effects]
            assert len(set(places)) == len(places) >= 2


def test_small_plan_has_every_kind():
    kinds = Counter(case.kind for case in plan(5, 24))
    assert kinds == {"none": 6, "several": 3, "outside": 4, "invisible": 1, "single": 10}
    assert plan(5, 24) == plan(5, 24) != plan(6, 24)
    assert [case.index for case in plan(5, 24)] == list(range(24))


@pytest.mark.parametrize(
    "case",
    [Case(2, 1, "single", ("outliers",)), Case(2, 2, "several", ("backlash", "coloured-noise"))],
)
def test_a_case_is_made_the_same_again(case):
    first, second = make(case), make(case)
    for name in ("recording", "same_kind", "double_amplitude"):
        assert getattr(first, name).equals(getattr(second, name))
    assert first.truth == second.truth
    assert first.simulation == second.simulation
    assert not first.recording["y"].equals(make(Case(3, case.index, case.kind, case.effects)).recording["y"])


def test_contract(tmp_path):
    from ruamel.yaml import YAML

    one_of_each_kind = {case.kind: case for case in plan(4, 24)}
    assert set(one_of_each_kind) == {"none", "single", "several", "outside", "invisible"}
    for case in one_of_each_kind.values():
        made = make(case)
        assert list(made.recording.columns) == ["t", "u", "y"]
        assert list(made.same_kind.columns) == list(made.double_amplitude.columns) == ["t", "u", "y", "clean"]
        truth = json.loads(json.dumps(made.truth))
        assert truth["kind"] == case.kind
        assert [effect["id"] for effect in truth["effects"]] == list(case.effects)
        assert len(made.recording) == truth["frames"]
        for table in (made.recording, made.same_kind, made.double_amplitude):
            assert np.all(np.isfinite(table.to_numpy()))
        path = tmp_path / "simulation.yaml"
        with path.open("w", encoding="utf-8") as stream:
            YAML().dump(made.simulation, stream)
        believed = load_simulation(path)
        assert isinstance(believed, Simulation)
        wrong = np.array(believed.plant.denominator[1:]) / np.array(truth["plant"]["denominator"][1:]) - 1.0
        assert np.all(np.abs(wrong) > 1e-3)
        assert np.all(np.abs(wrong) < 0.45)


def test_noise_is_as_strong_as_the_truth_says():
    made = make(Case(9, 0, "none"))
    noise = made.same_kind["y"] - made.same_kind["clean"]
    assert np.std(noise) == pytest.approx(made.truth["noise_std"], rel=0.08)
    ratio = 20.0 * np.log10(np.std(made.same_kind["clean"]) / made.truth["noise_std"])
    assert ratio == pytest.approx(made.truth["snr_db"], abs=3.0)
    assert made.truth["effects"] == []


def test_nothing_concealed_leaves_nothing_over():
    made = make(Case(9, 1, "none"))
    sensor, plant = made.simulation["sensor"], made.truth["plant"]
    belief = Belief(
        TransferFunction(tuple(plant["numerator"]), tuple(plant["denominator"])),
        Acquisition(made.truth["period"], "zoh", sensor["kind"], sensor.get("exposure"), sensor["latency"]),
        made.truth["initial_state"] == "estimate",
    )
    clean_output = made.same_kind["clean"].to_numpy()
    left = belief.left_over_after_estimate(made.same_kind["u"].to_numpy(), clean_output)
    assert left < 1e-6 * np.sum(clean_output**2)


def test_images_measure_the_motion():
    index = next(i for i in range(200) if draw_recording(*started(Case(41, i, "none"))).images)
    made = make(Case(41, index, "none"))
    assert made.truth["images"]
    assert made.truth["frames"] <= 500
    error = made.same_kind["y"] - made.same_kind["clean"]
    ratio = 20.0 * np.log10(np.std(made.same_kind["clean"]) / np.std(error))
    assert 12.0 < ratio < 48.0
    assert abs(np.mean(error)) < 0.3 * np.std(error)


def test_disturbances_do_not_come_back():
    made = make(Case(51, 3, "single", ("step-disturbance",)))
    assert made.truth["repeatable"] is False
    assert made.truth["effects"][0]["parameters"]["time"] < made.recording["t"].iloc[-1]
    plant = made.truth["plant"]
    again = sample(
        TransferFunction(tuple(plant["numerator"]), tuple(plant["denominator"])),
        made.same_kind["u"].to_numpy(),
        Acquisition(
            made.truth["period"],
            "zoh",
            made.simulation["sensor"]["kind"],
            made.truth["exposure"] or None,
            made.truth["latency"],
        ),
    )
    late = slice(len(again) // 2, None)
    assert made.truth["initial_state"] == "zero"
    assert np.max(np.abs(again[late] - made.same_kind["clean"].to_numpy()[late])) < 1e-5 * np.std(again)
