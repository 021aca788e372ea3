"""Properties of exact sampling and of polynomial roots, for any plant, hold, exposure and latency."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.signal import tf2ss

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, polynomial_roots

COUNT = 12


@st.composite
def plants(draw):
    """Strictly proper stable plants of one to four poles, real ones and modes, from slow to past the frame rate."""
    real = draw(st.lists(st.floats(0.05, 8.0), max_size=2))
    modes = draw(st.lists(st.tuples(st.floats(0.1, 12.0), st.floats(0.02, 0.95)), min_size=not real, max_size=1))
    denominator = np.array([1.0])
    for pole in real:
        denominator = np.polymul(denominator, [1.0, pole])
    for omega, damping in modes:
        denominator = np.polymul(denominator, [1.0, 2.0 * damping * omega, omega**2])
    size = draw(st.integers(1, len(denominator) - 1))
    numerator = [draw(st.sampled_from([-2.0, 0.5, 3.0])), *draw(st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3))]
    return TransferFunction(tuple(numerator[:size]), tuple(denominator))


@st.composite
def acquisitions(draw):
    """Both holds, both sensors, exposures up to the period and latencies of several periods; the period is 1 s."""
    hold, latency = draw(st.sampled_from(["zoh", "foh"])), draw(st.floats(0.0, 2.5))
    if draw(st.booleans()):
        return Acquisition(1.0, hold, "instant", None, latency)
    return Acquisition(1.0, hold, "camera", draw(st.floats(0.05, 1.0)), latency)


signals = st.lists(st.sampled_from([-1.0, -0.3, 0.0, 0.7, 1.0]), min_size=COUNT, max_size=COUNT).map(np.array)


def by_matrix_exponential(plant, signal, acquisition):
    """The same from one matrix exponential for each instant: states, integral of the output, input and its slope."""
    a, b, c, _ = tf2ss(plant.numerator, plant.denominator)
    n = len(a)
    whole = np.zeros((n + 3, n + 3))
    whole[:n, :n], whole[:n, n + 1 : n + 2], whole[n, :n], whole[n + 1, n + 2] = a, b, c[0], 1.0
    states = np.zeros((COUNT + 1, n + 1))

    def moved(k, duration):
        slope = signal[min(k + 1, COUNT - 1)] - signal[k] if acquisition.hold == "foh" else 0.0
        return (expm(duration * whole) @ np.concatenate([states[k], [signal[k], slope]]))[: n + 1]

    for k in range(COUNT):
        states[k + 1] = moved(k, 1.0)

    def at(time):
        return np.zeros(n + 1) if time <= 0.0 else moved(int(time), time - int(time))

    end = np.arange(COUNT) - acquisition.latency
    if acquisition.sensor == "instant":
        return np.array([c[0] @ at(t)[:n] for t in end])
    return np.array([(at(t)[n] - at(t - acquisition.exposure)[n]) / acquisition.exposure for t in end])


@given(plants(), signals, acquisitions())
def test_samples_are_those_of_the_matrix_exponential(plant, signal, acquisition):
    expected = by_matrix_exponential(plant, signal, acquisition)
    size = np.max(np.abs(expected)) + abs(plant.static_gain())
    np.testing.assert_allclose(sample(plant, signal, acquisition), expected, rtol=0.0, atol=1e-8 * size)


@given(plants(), signals, signals, acquisitions(), st.floats(-3.0, 3.0))
def test_outputs_add_up_like_inputs(plant, first, second, acquisition, factor):
    whole = sample(plant, first + factor * second, acquisition)
    parts = sample(plant, first, acquisition), factor * sample(plant, second, acquisition)
    size = np.max(np.abs(parts)) + abs(plant.static_gain())
    np.testing.assert_allclose(whole, parts[0] + parts[1], rtol=0.0, atol=1e-10 * size)


@given(plants(), signals, acquisitions())
def test_a_later_input_has_a_later_output(plant, signal, acquisition):
    # A straight line needs a first sample of zero to start from.
    signal = np.concatenate([[0.0], signal])
    once = sample(plant, signal, acquisition)
    later = sample(plant, np.concatenate([np.zeros(3), signal]), acquisition)
    size = np.max(np.abs(once)) + abs(plant.static_gain())
    assert np.all(later[:3] == 0.0)
    np.testing.assert_allclose(later[3:], once, rtol=0.0, atol=1e-10 * size)


@given(plants(), signals, acquisitions(), st.sampled_from([1e-6, 1e-3, 60.0, 1e4]))
def test_the_unit_of_time_does_not_matter(plant, signal, acquisition, unit):
    """In milliseconds the period is a thousand times as long and each derivative a thousandth."""
    degree = len(plant.denominator) - 1
    slower = TransferFunction(
        tuple(b * unit ** (len(plant.numerator) - 1 - i) for i, b in enumerate(plant.numerator)),
        tuple(a * unit ** (degree - i) for i, a in enumerate(plant.denominator)),
    )
    exposure = None if acquisition.sensor == "instant" else unit * acquisition.exposure
    changed = Acquisition(unit, acquisition.hold, acquisition.sensor, exposure, unit * acquisition.latency)
    expected = sample(plant, signal, acquisition)
    size = np.max(np.abs(expected)) + abs(plant.static_gain())
    np.testing.assert_allclose(sample(slower, signal, changed), expected, rtol=0.0, atol=1e-7 * size)


@given(
    st.floats(0.1, 10.0),
    st.lists(st.floats(-1e3, 1e3).map(lambda r: round(r, 3)), max_size=2),
    st.lists(st.tuples(st.floats(-50.0, 50.0), st.floats(0.1, 50.0)), max_size=1),
)
def test_roots_make_the_polynomial_vanish_and_come_in_pairs(lead, real, pairs):
    coefficients = np.array([lead])
    for root in real:
        coefficients = np.polymul(coefficients, [1.0, -root])
    for middle, half in pairs:
        coefficients = np.polymul(coefficients, [1.0, -2.0 * middle, middle**2 + half**2])
    roots = polynomial_roots(tuple(coefficients))
    assert len(roots) == len(coefficients) - 1
    for root in roots:
        scale = sum(abs(c) * abs(root) ** (len(coefficients) - 1 - i) for i, c in enumerate(coefficients))
        assert abs(np.polyval(coefficients, root)) <= 1e-11 * scale
    assert np.sum(roots).imag == pytest.approx(0.0, abs=1e-9)
    assert coefficients[0] * np.prod(-roots) == pytest.approx(coefficients[-1], rel=1e-6, abs=1e-9)
