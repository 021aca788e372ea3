import control
import numpy as np
import pytest

from camid.chain import camera_models as camera
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order

PERIODS = [0.02, 0.1, 0.3]


@pytest.mark.parametrize("period", PERIODS)
def test_both_versions_of_model_1_agree(period, excitation):
    """Frequency response (12) against (8) behind an integrator, and the two run in time."""
    frequencies = np.geomspace(0.1, 40.0, 200) / period
    integrator = control.tf([1.0], [1.0, 0.0])
    first = camera.averaging_filter(period)(np.exp(1j * frequencies * period)) * integrator(1j * frequencies)
    assert np.allclose(first, camera.model_1_response(frequencies, period), atol=1e-12)
    assert np.allclose(camera.model_1_first_version_response(frequencies, period), first, atol=1e-12)
    plant = second_order(1.0, 10.0, 0.1)
    integrated = camera.measurement_from_integral(plant, excitation, period)
    assert np.allclose(integrated, sample(plant, excitation, Acquisition(period)), atol=1e-12)


@pytest.mark.parametrize("period", PERIODS)
def test_closed_form_is_the_exact_discretisation(period):
    written = camera.closed_form(1.3, 10.0, 0.1, period)
    exact = camera.sampled_model(second_order(1.3, 10.0, 0.1), Acquisition(period))
    assert np.allclose(exact.num[0][0], written.beta, rtol=0, atol=5e-15)
    assert np.allclose(exact.den[0][0], [1.0, -written.alpha[0], written.alpha[1], 0.0], atol=5e-15)


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("plant", [second_order(1.0, 10.0, 0.1), TransferFunction((1.0, 3.0), (1.0, 2.0, 5.0, 7.0))])
def test_equation_14_is_the_first_order_hold_equivalent_behind_one_delay(plant, period):
    held = camera.sampled_model(plant, Acquisition(period))
    triangle = camera.first_order_hold_equivalent(plant, period)
    z = np.exp(1j * np.linspace(0.05, 3.0, 50))
    assert np.allclose(held(z), triangle(z) / z, rtol=1e-9)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize(("exposure", "latency"), [(1.0, 0.0), (0.4, 0.0), (0.8, 0.6), (0.3, 2.2)])
def test_sampled_model_reproduces_the_chain(hold, exposure, latency, excitation):
    plant = TransferFunction((1.0, 3.0), (1.0, 2.0, 5.0, 7.0))
    acquisition = Acquisition(0.2, hold, "camera", 0.2 * exposure, 0.2 * latency)
    model = camera.sampled_model(plant, acquisition)
    # The hold of a first sample that is not zero has no rise in front, so the excitation begins with a zero.
    signal = np.concatenate([[0.0], excitation])
    _, response = control.forced_response(model, U=signal)
    assert np.allclose(response, sample(plant, signal, acquisition), atol=1e-9)


def test_model_2_and_model_3_responses_and_systems():
    period = 0.02
    frequencies = np.array([1.0, 40.0, 120.0])
    z = np.exp(1j * frequencies * period)
    assert np.allclose(camera.model_2(period)(z), camera.model_2_response(frequencies, period))
    assert np.allclose(camera.model_3(period, frequencies)(1j * frequencies), np.exp(-0.5j * frequencies * period))
    assert np.allclose(
        camera.model_1(period, frequencies)(1j * frequencies), camera.model_1_response(frequencies, period)
    )


def test_zeros_and_common_phase_of_the_models():
    period = 0.02
    assert abs(camera.model_1_response(2.0 * np.pi * 3.0 / period, period)) < 1e-15
    assert abs(camera.model_2_response(2.0 * np.pi * 2.5 / period, period)) < 1e-15
    frequencies = np.linspace(1.0, 0.99 * np.pi / period, 40)
    phases = [
        np.angle(f(frequencies, period))
        for f in (camera.model_1_response, camera.model_2_response, camera.model_3_response)
    ]
    assert np.allclose(phases[0], phases[2])
    assert np.allclose(phases[1], phases[2])


def test_rational_model_1_is_accurate_up_to_the_shannon_frequency():
    period = 0.02
    frequencies = np.linspace(0.1, np.pi / period, 60)
    rational = camera.model_1_rational(period)
    assert np.max(np.abs(rational(1j * frequencies) - camera.model_1_response(frequencies, period))) < 1e-5


def test_shorter_exposure_and_latency_move_zeros_and_phase():
    period = 0.02
    response = camera.model_1_response(np.array([2.0 * np.pi / 0.005, 10.0]), period, 0.005, 0.003)
    assert abs(response[0]) < 1e-12
    assert np.angle(response[1]) == pytest.approx(-10.0 * (0.003 + 0.0025))
