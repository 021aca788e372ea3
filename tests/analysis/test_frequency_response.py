"""Frequency responses, their bands, and those of recordings."""

import control
import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete, tf2ss

import camid
from camid.chain.camera_models import model_1_response
from camid.errors import InputError
from tests.support import linear_rig as rig
from tests.support.two_rates import SIMULATION as TWO_RATES
from tests.support.two_rates import two_rates

TRUE = control.tf(rig.NUMERATOR, rig.DENOMINATOR)
OMEGA = np.geomspace(1.0, 60.0, 40)
UNKNOWN_LATENCY = {"column": "y", "kind": "camera", "latency": "estimate"}


def curve(view, name):
    table = view.numbers
    return table[table["model"] == name]


def test_the_response_is_that_of_python_control(identified):
    found = curve(camid.bode(TRUE, frequencies=(0.1, 100.0)), "model 1")
    magnitude, phase, _ = control.frequency_response(TRUE, found["angular_frequency"].to_numpy())
    np.testing.assert_allclose(found["magnitude"], magnitude, rtol=1e-9)
    np.testing.assert_allclose(found["phase"], np.degrees(np.unwrap(phase)), atol=1e-6)
    np.testing.assert_allclose(found["magnitude_db"], 20.0 * np.log10(magnitude), atol=1e-9)
    assert found["magnitude_db_deviation"].isna().all()


def test_the_band_is_the_spread_of_models_drawn_from_the_covariance(identified):
    """Plants drawn from the estimate's covariance: their magnitudes and phases scatter as the band says."""
    simulation = identified.simulation
    mean = np.array([*simulation.plant.numerator, *simulation.plant.denominator[1:]])
    drawn = np.random.default_rng(0).multivariate_normal(mean, simulation.covariance, 2000)
    lead, s = simulation.plant.denominator[0], 1j * OMEGA[:, None]
    responses = drawn[:, 0] / (lead * s**2 + drawn[:, 1] * s + drawn[:, 2])
    found = curve(camid.bode(identified, frequencies=(OMEGA[0], OMEGA[-1])), "identified")
    for name, values in (
        ("magnitude_db_deviation", 20.0 * np.log10(np.abs(responses))),
        ("phase_deviation", np.degrees(np.unwrap(np.angle(responses), axis=0))),
    ):
        stated = np.interp(OMEGA, found["angular_frequency"], found[name])
        np.testing.assert_allclose(stated, np.std(values, axis=1), rtol=0.08)


@pytest.mark.slow
def test_the_band_holds_the_truth_as_often_as_it_says():
    """Of 40 recordings with noise of their own, at the resonance and away from it."""
    inside = np.zeros(2)
    for seed in range(40):
        table = rig.recording(count=300, noise=0.0)
        table["y"] += 0.1 * table["y"].std() * np.random.default_rng(seed).standard_normal(300)
        found = camid.identify(table, rig.simulation())
        rows = camid.bode(found, frequencies=(1.0, 100.0)).numbers
        for i, omega in enumerate((3.0, 10.0)):
            at = {c: np.interp(omega, rows["angular_frequency"], rows[c]) for c in rows.columns[3:6]}
            true = 20.0 * np.log10(abs(TRUE(1j * omega)))
            inside[i] += abs(at["magnitude_db"] - true) < 1.96 * at["magnitude_db_deviation"]
    assert np.all(inside >= 34)  # 38 are expected; fewer than 34 happen once in 200


def test_the_camera_is_shown_when_it_is_asked_for(identified):
    alone, seen = (camid.bode(identified, frequencies=(1.0, 300.0), camera=c) for c in (False, True))
    assert alone.shows == "plant alone"
    assert "exposure" in seen.shows
    one, other = (curve(v, "identified") for v in (alone, seen))
    filtered = model_1_response(one["angular_frequency"].to_numpy(), rig.PERIOD)
    np.testing.assert_allclose(other["magnitude"], one["magnitude"] * np.abs(filtered), rtol=1e-9)
    turned = np.exp(1j * np.radians(other["phase"] - one["phase"])) - filtered / np.abs(filtered)
    assert np.max(np.abs(turned)) < 1e-6
    # What is known exactly adds no uncertainty.
    np.testing.assert_allclose(other["phase_deviation"], one["phase_deviation"], rtol=1e-9)


@pytest.mark.parametrize("camera", [False, True])
@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_a_recording_shows_the_plant_that_made_it(camera, hold):
    """Hold and camera are divided out: left in, they would turn the phase by half a turn towards the Nyquist rate."""
    signal = rig.steps(3000, length=1)
    output = rig.film(signal, hold)
    output = output + 0.01 * np.std(output) * np.random.default_rng(1).standard_normal(len(output))
    table = pd.DataFrame({"t": rig.PERIOD * np.arange(len(signal)), "u": signal, "y": output})
    model = rig.simulation(input={"column": "u", "hold": hold})
    view = camid.bode(model, recording=table, camera=camera, segment=20.0)
    seen, omega = view.empirical.is_seen, view.empirical.angular_frequency
    seen &= omega < 40.0  # beyond, what aliases is as large
    expected = TRUE(1j * omega) * (model_1_response(omega, rig.PERIOD) if camera else 1.0)
    error = np.abs(view.empirical.response / expected - 1.0)[seen]
    assert np.count_nonzero(seen) > 100
    assert np.median(error) < 0.02
    spread = error / np.maximum(view.empirical.relative_deviation[seen], 0.01)
    assert np.mean(spread < 3.0) > 0.9
    other = TRUE(1j * omega) * (1.0 if camera else model_1_response(omega, rig.PERIOD))
    assert np.median(np.abs(view.empirical.response / other - 1.0)[seen & (omega > 20.0)]) > 0.2
    assert any("Welch" in sentence for sentence in view.said())


def test_frames_between_the_samples_of_the_drive_show_the_plant_too():
    table = two_rates(seconds=60.0)
    view = camid.bode(TWO_RATES, recording=table, segment=6.0)
    omega = view.empirical.angular_frequency
    near = view.empirical.is_seen & (omega < 30.0)
    expected = np.polyval([105.3], 1j * omega) / np.polyval([1.0, 2.7, 81.0], 1j * omega)
    assert np.count_nonzero(near) > 20
    assert np.median(np.abs(view.empirical.response / expected - 1.0)[near]) < 0.05


def test_of_a_recording_without_the_rig_nothing_is_seen():
    random = np.random.default_rng(0)
    table = rig.recording(count=2000).assign(y=random.standard_normal(2000))
    view = camid.bode(rig.simulation(), recording=table)
    assert np.mean(view.empirical.is_seen) < 0.01


def test_in_a_closed_loop_the_reference_is_what_drives():
    """Noise that comes back through the controller bends the plain ratio of input and output, and not this one."""
    random, count, period = np.random.default_rng(2), 6000, 0.05
    moves, pushes, seen, _, _ = cont2discrete(tf2ss(rig.NUMERATOR, rig.DENOMINATOR), period)
    state, rows = np.zeros((2, 1)), []
    for reference in random.standard_normal(count):
        read = float((seen @ state)[0, 0]) + 0.5 * random.standard_normal()
        control = 0.5 * (reference - read)
        rows.append((reference, control, read))
        state = moves @ state + pushes * control
    table = pd.DataFrame(rows, columns=["r", "u", "y"]).assign(t=period * np.arange(count))
    content = rig.simulation(sensor={"column": "y", "kind": "instant"})
    controller = {"reference": "r", "position_gain": 1.0, "velocity_gain": 1.0}
    errors = []
    for model in (content | {"controller": controller}, content):
        view = camid.bode(model, recording=table, segment=15.0)
        omega = view.empirical.angular_frequency
        near = (omega > 1.0) & (omega < 15.0)
        errors.append(np.abs(np.mean(view.empirical.response[near] / TRUE(1j * omega[near])) - 1.0))
    assert errors[0] < 0.05
    assert errors[1] > 3.0 * errors[0]
    assert any("without its controller" in s for s in camid.bode(content | {"controller": controller}).said())


def test_a_file_of_several_experiments_is_averaged(tmp_path):
    tables = [rig.recording(count=400, seed=s).assign(run=str(s)) for s in range(4)]
    model = rig.simulation(recording={"experiment": {"column": "run"}})
    one = camid.bode(rig.simulation(), recording=tables[0], segment=5.0).empirical
    pd.concat(tables).to_csv(tmp_path / "four.csv", index=False)
    view = camid.bode(model, recording=tmp_path / "four.csv", segment=5.0)
    assert view.empirical.averages == pytest.approx(4.0 * one.averages)
    assert any("4 experiments are averaged" in sentence for sentence in view.said())


@pytest.mark.parametrize(
    ("options", "changes", "said"),
    [
        ({"frequencies": (0.0, 1.0)}, {}, "give two positive ones, ascending"),
        ({"frequencies": (3.0, 1.0)}, {}, "frequencies from 3 to 1 rad/s"),
        ({"frequencies": (1.0, float("nan"))}, {}, "frequencies from 1 to nan"),
        ({"segment": 1.0}, {}, "a segment is one of a recording"),
        ({"segment": 1e9, "recording": True}, {}, "a segment of 1e+09 s has"),
        ({"segment": -1.0, "recording": True}, {}, "a segment of -1 s has"),
        ({"camera": True}, {}, "write exposure into the file, or name a recording"),
        ({"camera": True}, {"sensor": UNKNOWN_LATENCY}, "the latency is not known yet"),
        ({"recording": True}, {"input": None, "initial_state": "estimate"}, "without an input"),
        ({"recording": True}, {"sensor": {"column": "z", "kind": "camera"}}, "no column 'z'"),
        ({}, {"effects": [{"id": "cuolomb-friction", "parameters": {"force": 1.0}}]}, "did you mean"),
    ],
)
def test_what_has_no_frequency_response_is_refused_in_one_line(options, changes, said):
    options = options | ({"recording": rig.recording(count=100)} if options.get("recording") else {})
    with pytest.raises(InputError) as caught:
        camid.bode(rig.simulation(**changes), **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
