"""Least squares in discrete time."""

import numpy as np
import pytest

from camid.identification.discrete_time import least_squares


def driven(noise: float, seed: int = 7, count: int = 2000) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    signal, output = random.standard_normal(count), np.zeros(count)
    for i in range(2, count):
        output[i] = 1.5 * output[i - 1] - 0.7 * output[i - 2] + 0.4 * signal[i - 1] + noise * random.standard_normal()
    return signal, output


def test_what_it_finds_lies_within_its_deviations():
    found = least_squares(*driven(0.1), poles=2, zeros=0, delay=1)
    errors = np.array([found.denominator[1] + 1.5, found.denominator[2] - 0.7, found.numerator[0] - 0.4])
    assert np.all(np.abs(errors) < 3.0 * found.standard_deviations)


@pytest.mark.parametrize("unit", [1e-12, 1e9])
def test_units_change_nothing(unit):
    """Micrometres beside thousands of newtons: the square of such a table has lost one of them in rounding."""
    signal, output = driven(0.1)
    expected = least_squares(signal, output, poles=2, zeros=0, delay=1)
    found = least_squares(signal, unit * output, poles=2, zeros=0, delay=1)
    np.testing.assert_allclose(found.denominator, expected.denominator, rtol=1e-8)
    np.testing.assert_allclose(found.numerator, unit * expected.numerator, rtol=1e-8)
    np.testing.assert_allclose(found.standard_deviations, expected.standard_deviations * [1.0, 1.0, unit], rtol=1e-6)


def test_too_few_samples_are_refused():
    with pytest.raises(ValueError, match="3 samples are too few for 3 parameters"):
        least_squares(np.ones(3), np.ones(3), poles=2, zeros=0, delay=1)
