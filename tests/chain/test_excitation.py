import numpy as np
import pytest

from camid.chain.excitation import multilevel, multisine, pseudo_random_binary_sequence, two_level_amplitudes


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


@pytest.mark.parametrize(
    "make",
    [
        lambda n: pseudo_random_binary_sequence(5, periods=n),
        lambda n: two_level_amplitudes(5, 1.0, 2.0, periods=n),
        lambda n: multilevel(5, 3, np.random.default_rng(1), periods=n),
        lambda n: multisine(31, [1, 2], periods=n),
    ],
)
def test_no_period_is_refused(make):
    with pytest.raises(ValueError, match="at least one period"):
        make(0)


def test_second_part_is_the_first_at_another_amplitude():
    signal = two_level_amplitudes(6, 0.5, 2.0, periods=2)
    assert len(signal) == 4 * 63
    assert set(np.abs(signal[:126])) == {0.5}
    assert np.array_equal(signal[126:], 4.0 * signal[:126])


def test_multilevel_changes_with_the_binary_sequence_and_uses_every_level_equally_often():
    binary = pseudo_random_binary_sequence(9)
    signal = multilevel(9, 5, np.random.default_rng(3), amplitude=2.0)
    assert len(signal) == 511
    assert set(signal) == {-2.0, -1.0, 0.0, 1.0, 2.0}
    changes, allowed = np.flatnonzero(np.diff(signal)), np.flatnonzero(np.diff(binary))
    assert set(changes) < set(allowed)
    assert len(changes) > len(allowed) / 2
    of_each_run = signal[np.concatenate([[0], allowed + 1])]
    counts = np.unique(of_each_run, return_counts=True)[1]
    assert np.ptp(counts) <= 1


def test_multilevel_follows_its_generator_and_repeats_its_period():
    first, again, other = (multilevel(7, 4, np.random.default_rng(seed), periods=2) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    assert np.array_equal(first[:127], first[127:])
    with pytest.raises(ValueError, match="at least two levels"):
        multilevel(7, 1, np.random.default_rng(1))


@pytest.mark.parametrize("length", [200, 511])
@pytest.mark.parametrize("phases", ["schroeder", "random"])
def test_multisine_excites_the_given_lines_alike_and_no_other(length, phases):
    lines = [1, 4, 7, 60, 99]
    signal = multisine(
        length, lines, periods=2, root_mean_square=3.0, phases=phases, generator=np.random.default_rng(5)
    )
    assert len(signal) == 2 * length
    assert np.allclose(signal[:length], signal[length:])
    assert np.sqrt(np.mean(signal**2)) == pytest.approx(3.0)
    amplitudes = 2.0 / length * np.abs(np.fft.rfft(signal[:length]))
    expected = np.zeros(length // 2 + 1)
    expected[lines] = 3.0 * np.sqrt(2.0 / len(lines))
    assert amplitudes == pytest.approx(expected, abs=1e-12)


def test_multisine_has_the_phases_of_schroeder():
    spectrum = np.fft.rfft(multisine(64, [2, 3, 5, 9]))
    assert np.angle(spectrum[[2, 3, 5, 9]] * np.exp(1j * np.pi * np.array([0, 2, 6, 12]) / 4)) == pytest.approx(
        0.0, abs=1e-12
    )


def test_schroeder_keeps_the_peak_low():
    lines = range(1, 60)

    def crest(**options):
        return np.max(np.abs(multisine(2048, lines, **options)))

    assert crest() < 1.8  # Schroeder (1970): about 1.7 for a flat spectrum; all phases equal: sqrt(2 * 59) = 10.9
    assert crest(phases="random", generator=np.random.default_rng(2)) > 2.2


@pytest.mark.parametrize(
    ("lines", "options", "message"),
    [
        ([], {}, "empty"),
        ([1, 1], {}, "repeated"),
        ([0], {}, "between 1 and 31"),
        ([32], {}, "between 1 and 31"),
        ([1], {"phases": "zero"}, "schroeder or random"),
        ([1], {"phases": "random"}, "generator"),
    ],
)
def test_a_multisine_that_cannot_be_is_refused(lines, options, message):
    with pytest.raises(ValueError, match=message):
        multisine(64, lines, **options)


@pytest.mark.parametrize("order", range(2, 21))
def test_sequence_is_that_of_scipy(order):
    from scipy.signal import max_len_seq

    assert np.array_equal(pseudo_random_binary_sequence(order), 2.0 * max_len_seq(order)[0] - 1.0)


@pytest.mark.parametrize("order", [0, 1, 33])
def test_register_without_known_taps_is_refused(order):
    with pytest.raises(ValueError, match=f"is 2 to 32, not {order}"):
        pseudo_random_binary_sequence(order)
