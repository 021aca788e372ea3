"""Correlations of residuals: for linear models those of identify, for all others by the engine."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lsim

import camid
from camid.errors import InputError
from tests.support import linear_rig as rig
from tests.support import pendulum_and_drive as rigs
from tests.support.two_rates import SIMULATION as TWO_RATES
from tests.support.two_rates import two_rates


def same(found, expected):
    pd.testing.assert_frame_equal(found, expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"plant": rig.plant([1.0, 300.0], [2.0, 6.0, 200.0])},
        {"initial_state": "estimate"},
        {"validation": {"start": 10.0, "end": 12.0}},
    ],
)
def test_a_model_leaves_what_identify_says_that_it_does(changes, tmp_path):
    """After it was written to a file and read back."""
    recording = rig.recording(count=400)
    result = camid.identify(recording, rig.simulation(**changes))
    camid.write_simulation(result.simulation, tmp_path / "model.yaml")
    found = camid.residuals(recording, tmp_path / "model.yaml")
    same(found.numbers, result.residual_analysis.correlations(result.period))
    assert found.analysis.whiteness_p == pytest.approx(result.residual_analysis.whiteness_p, rel=1e-4)
    assert found.analysis.independence_p == pytest.approx(result.residual_analysis.independence_p, rel=1e-4)
    assert found.nrmse == pytest.approx(result.nrmse, rel=1e-6)


def test_the_bias_of_an_integrator_is_accounted_for(tmp_path):
    """Offset and bias that were estimated stand in the file as numbers, and a fit took what they explain."""
    time, random = rig.PERIOD * np.arange(400), np.random.default_rng(0)
    signal = rig.steps(400)
    moved = lsim(([1.0], [1.0, 2.0, 0.0]), signal + 0.02, time, interp=False)[1]
    recording = pd.DataFrame({"t": time, "u": signal, "y": moved + 0.02 * random.standard_normal(400)})
    content = rig.simulation(plant=rig.plant([1.2], [1.0, 1.8, 0.0]), sensor={"column": "y", "kind": "instant"})
    result = camid.identify(recording, content)
    assert {row["name"] for row in result.constants()} == {"offset of the sensor", "bias of the input"}
    camid.write_simulation(result.simulation, tmp_path / "model.yaml")
    same(camid.residuals(recording, tmp_path / "model.yaml").numbers, result.residuals().numbers)
    same(result.residuals().numbers, result.residual_analysis.correlations(result.period))


def test_named_constants_leave_the_same(tmp_path):
    recording = rig.recording(count=400)
    physical = {
        "parameters": {"mass": 0.01, "damping": 0.03, "stiffness": 1.0},
        "transfer_function": {"numerator": ["1.5"], "denominator": ["mass", "damping", "stiffness"]},
    }
    result = camid.identify(recording, rig.simulation(plant={"physical": physical}))
    camid.write_simulation(result.simulation, tmp_path / "model.yaml")
    found = camid.residuals(recording, tmp_path / "model.yaml")
    same(found.numbers, result.residual_analysis.correlations(result.period))


def test_a_belief_is_taken_as_it_is():
    """Nothing of it was fitted: coefficients that are wrong show, and must not be forgiven."""
    recording = rig.recording(count=400)
    wrong = camid.residuals(recording, rig.simulation(plant=rig.plant([130.0], [1.0, 3.0, 90.0])))
    right = camid.residuals(recording, rig.simulation())
    assert wrong.analysis.independence_p < 1e-6
    assert right.analysis.independence_p > 0.01
    assert right.analysis.whiteness_p > 0.01
    assert any("states no accuracy" in sentence for sentence in wrong.said())


FRICTION = {"id": "coulomb-friction", "parameters": {"force": 0.2}, "standard_deviations": {"force": 0.01}}


def test_effects_are_tested_by_the_engine():
    """White noise on what the right model simulates; the model without friction leaves structure."""
    table = rig.recording(count=400, noise=0.0)
    simulated = camid.simulate(table, rig.simulation(effects=[FRICTION]))["simulated"]
    random = np.random.default_rng(3)
    table["y"] = simulated + 0.05 * simulated.std() * random.standard_normal(400)
    right = camid.residuals(table, rig.simulation(effects=[FRICTION]))
    assert right.analysis.whiteness_p > 0.01
    assert right.analysis.independence_p > 0.01
    wrong = camid.residuals(table, rig.simulation())
    assert wrong.analysis.whiteness_p < 1e-6


def test_the_engine_and_the_exact_path_agree():
    """An effect of no size sends a linear plant through the engine."""
    recording = rig.recording(count=400)
    nothing = {"id": "quadratic-drag", "parameters": {"coefficient": 0.0}}
    offset = {"column": "y", "kind": "camera", "offset": 0.0}
    exact = camid.residuals(recording, rig.simulation(sensor=offset)).numbers
    engine = camid.residuals(recording, rig.simulation(sensor=offset, effects=[nothing])).numbers
    near = exact["lag"].isin(engine["lag"])
    pd.testing.assert_frame_equal(exact[near].reset_index(drop=True), engine, rtol=2e-3, atol=2e-4)


def test_a_pendulum_is_tested_and_has_no_input():
    recording = rigs.pendulum(natural_frequency=5.5, damping=0.01, rest=3.1, angle=4.5, noise=0.01, count=600)
    result = camid.identify(recording, rigs.pendulum_simulation(natural_frequency=5.4, damping=0.01, rest=3.1))
    found = camid.residuals(recording, result)
    assert found.analysis.whiteness_p > 0.001
    assert found.analysis.independence_p is None
    assert found.numbers["crosscorrelation"].isna().all()
    assert len(found.figure().axes) == 1


def test_in_a_closed_loop_the_control_is_tested_against_the_reference():
    clean = rigs.drive(mass=12.0, viscous=30.0, friction=0.0, bias=0.0)
    random = np.random.default_rng(5)
    recording = clean.assign(u=clean["u"] + 0.3 * random.standard_normal(len(clean)))
    right = camid.residuals(recording, rigs.drive_simulation(12.0, 30.0))
    assert right.signals == ("u", "r")
    assert right.analysis.independence_p > 0.001
    assert camid.residuals(recording, rigs.drive_simulation(14.0, 30.0)).analysis.independence_p < 1e-6


def test_frames_between_the_samples_of_the_drive_are_tested_by_the_engine():
    table = two_rates()
    right = camid.residuals(table, TWO_RATES)
    assert right.analysis.independence_p > 0.001
    wrong = TWO_RATES | {"plant": rig.plant([90.0], [1.0, 2.0, 75.0])}
    assert camid.residuals(table, wrong).analysis.independence_p < 1e-6
    assert camid.compare(table, TWO_RATES).fits["fit"][0] > 98.0


def test_several_recordings_are_tested_together():
    tables = [rig.recording(count=300, seed=s) for s in (1, 4)]
    result = camid.identify(tables, rig.simulation())
    same(camid.residuals(tables, result).numbers, result.residual_analysis.correlations(result.period))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"sensor": {"column": "y", "kind": "camera", "latency": "estimate"}}, "the latency is not known yet"),
        ({"sensor": {"column": "z", "kind": "camera"}}, "no column 'z'"),
        ({"effects": [{"id": "coulomb-friction", "parameters": {"force": -1.0}}]}, "must be at least 0"),
        ({"plant": rig.plant([1.0], [1.0])}, "the plant has no dynamics"),
    ],
)
def test_what_cannot_be_tested_is_refused_in_one_line(changes, said):
    with pytest.raises(InputError) as caught:
        camid.residuals(rig.recording(count=100), rig.simulation(**changes))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_too_few_samples_are_said():
    found = camid.residuals(rig.recording(count=5), rig.simulation())
    assert "too few samples" in found.said()[1]
    assert found.short_table().rows
    assert found.figure() is not None


def test_recordings_of_other_periods_are_refused(tmp_path):
    table = rig.recording(count=300)
    for name, part in (("first.csv", table), ("second.csv", table.iloc[::2])):
        part.to_csv(tmp_path / name, index=False)
    files = [tmp_path / "first.csv", tmp_path / "second.csv"]
    with pytest.raises(InputError, match=r"second\.csv: its period is .* ms, that of .*first\.csv .*by themselves$"):
        camid.residuals(files, rig.simulation())
