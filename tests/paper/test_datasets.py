import numpy as np
import pandas as pd
import pytest

from camid.chain.camera_models import closed_form
from camid.paper.cases import declared_experiment
from camid.paper.datasets import (
    neglected_mode_outputs,
    noise_level,
    noise_samples,
    sampling_period_outputs,
    sweep_periods,
    with_closing_frame,
)
from camid.workflow.dataset_files import read_configuration, write_dataset

PLANT = {"static_gain": 1.0, "natural_frequency": 10.0, "damping": 0.1}
SWEEP = {"start": 0.02, "stop": 0.1, "step": 0.04, "noise_samples": 2}


def test_periods_are_as_written():
    assert list(sweep_periods(SWEEP)) == [0.02, 0.06, 0.1]


def test_outputs_follow_the_difference_equation_of_the_paper(excitation):
    """(16) driven sample by sample gives the dataset."""
    outputs = sampling_period_outputs(pd.DataFrame({"u": excitation}), PLANT, SWEEP)
    group = outputs[outputs["period"] == 0.06]
    model = closed_form(1.0, 10.0, 0.1, 0.06)
    held = with_closing_frame(excitation)
    expected = np.zeros(len(held))
    for k in range(1, len(held)):
        past = [(expected[k - i] if k >= i else 0.0) for i in (1, 2)]
        inputs = [(held[k - 1 - i] if k >= 1 + i else 0.0) for i in range(3)]
        expected[k] = model.alpha[0] * past[0] - model.alpha[1] * past[1] + np.dot(model.beta, inputs)
    assert np.allclose(group["w"], expected, atol=1e-12)
    assert len(group) == 512


def test_noise_streams_are_the_first_of_the_sequence_and_differ():
    noise = noise_samples(pd.DataFrame({"u": np.zeros(511)}), SWEEP, seed=7)
    first = noise[(noise["period"] == 0.02) & (noise["sample"] == 0)]["noise"].to_numpy()
    expected = np.random.default_rng(np.random.SeedSequence(7, spawn_key=(0, 0))).standard_normal(512)
    assert np.array_equal(first, expected)
    groups = [g["noise"].to_numpy() for _, g in noise.groupby(["period", "sample"])]
    assert len(groups) == 6
    assert np.max(np.abs(np.corrcoef(groups) - np.eye(6))) < 0.2


def test_neglected_mode_outputs_have_camera_and_instant_sensor(excitation):
    sweep = {"period": 0.02, "damping": 0.1, "start": 1.0, "stop": 4.0, "points": 3}
    outputs = neglected_mode_outputs(pd.DataFrame({"u": excitation}), PLANT, sweep)
    assert sorted(outputs["omega_1"].unique()) == pytest.approx([50.0, 100.0, 200.0])
    assert outputs["camera"].std() < outputs["instant"].std()


def test_pairing_by_hand():
    signal, output = np.array([1.0, -1.0, 1.0, 0.0]), np.array([0.0, 0.1, 0.2, 0.3])
    held = declared_experiment(signal, output, 0.1, {"hold": "zoh", "sensor": "instant", "shift": 1})
    assert np.array_equal(held.signal, [1.0, -1.0, 1.0])
    assert np.array_equal(held.output, [0.1, 0.2, 0.3])
    rising = declared_experiment(signal, output, 0.1, {"hold": "foh", "sensor": "instant", "shift": 1})
    assert np.array_equal(rising.signal, [0.0, 1.0, -1.0, 1.0])
    assert np.array_equal(rising.output, output)


def test_signal_to_noise_ratio_of_powers_and_of_amplitudes():
    output = np.array([1.0, -1.0, 1.0, -1.0])
    assert noise_level(output, 10.0, "power") == pytest.approx(1.0 / np.sqrt(10.0))
    assert noise_level(output, 10.0, "amplitude") == pytest.approx(0.1)


def test_dataset_carries_its_configuration(tmp_path):
    path = tmp_path / "table.parquet"
    write_dataset(pd.DataFrame({"a": [1.0]}), path, {"seed": 3, "sweep": SWEEP})
    assert read_configuration(path) == {"seed": 3, "sweep": SWEEP}
    assert list(pd.read_parquet(path).columns) == ["a"]
