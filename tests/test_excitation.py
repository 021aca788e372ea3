import numpy as np
import pytest

from camid.excitation import pseudo_random_binary_sequence


@pytest.mark.parametrize("order", [2, 5, 9, 11])
def test_sequence_has_maximal_length_two_levels_and_flat_autocorrelation(order):
    signal = pseudo_random_binary_sequence(order)
    assert len(signal) == 2**order - 1
    assert set(signal) == {-1.0, 1.0}
    assert signal.sum() == 1.0
    for lag in range(1, len(signal)):
        assert signal @ np.roll(signal, lag) == -1.0


def test_periods_and_amplitude():
    signal = pseudo_random_binary_sequence(5, periods=3, amplitude=0.5)
    assert len(signal) == 93
    assert np.array_equal(signal[:31], signal[31:62])
    assert np.max(signal) == 0.5


def test_no_period_is_refused():
    with pytest.raises(ValueError, match="at least one period"):
        pseudo_random_binary_sequence(5, periods=0)
