"""Spectra and coloured rows are those of scipy.signal."""

import numpy as np
import pytest
import scipy.signal

from camid.identification.autoregression import coloured
from camid.identification.welch import cross_spectrum

PERIOD = 0.02


@pytest.mark.parametrize("segment", [16, 33, 64, 100])
def test_cross_spectrum(segment):
    random = np.random.default_rng(5)
    first, second = random.normal(3.0, 1.0, 100), random.normal(-1.0, 2.0, 100)
    expected = scipy.signal.csd(first, second, 1.0 / PERIOD, "hann", segment, segment // 2)
    for found, one in zip(cross_spectrum(first, second, PERIOD, segment), expected, strict=True):
        np.testing.assert_allclose(found, one, atol=1e-15)


def test_spectrum():
    rows = np.random.default_rng(6).normal(size=500).cumsum()
    frequency, density = scipy.signal.welch(rows, 1.0 / PERIOD, nperseg=256)
    found = cross_spectrum(rows, rows, PERIOD, 256)
    np.testing.assert_allclose(found[0], frequency)
    np.testing.assert_allclose(found[1].real, density)


@pytest.mark.parametrize("whitening", [[1.0], [1.0, -0.9], [1.0, -1.6, 0.8, 0.1]])
@pytest.mark.parametrize("shape", [(200,), (200, 3), (2,), (0, 2)])
def test_coloured(whitening, shape):
    rows = np.random.default_rng(7).normal(size=shape)
    expected = scipy.signal.lfilter([1.0], whitening, rows, axis=0) if rows.size else rows
    np.testing.assert_allclose(coloured(rows, np.array(whitening)), expected, rtol=1e-10)
    backwards = coloured(rows[::-1].copy(), np.array(whitening))
    np.testing.assert_array_equal(coloured(rows[::-1], np.array(whitening)), backwards)
