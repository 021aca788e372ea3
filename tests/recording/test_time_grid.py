"""Irregular times: which grid they are brought onto, what is interpolated, held, missing or refused."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator

from camid.errors import InputError
from camid.recording.time_grid import grid_of

PERIOD = 0.04


def grid(time):
    return grid_of(np.asarray(time, dtype=float), lambda row: f"row {row}")


def refusal(time):
    with pytest.raises(InputError) as caught:
        grid(time)
    return str(caught.value)


def jittered(share, count=400, start=7.0, seed=3):
    """Times that scatter by at most a share of the period about a regular grid."""
    noise = np.random.default_rng(seed).uniform(-share, share, count)
    return start + PERIOD * (np.arange(count) + noise)


def wave(time):
    """Two tones of ten and seventeen rows a period."""
    return np.sin(2 * np.pi * time / (10 * PERIOD)) + 0.3 * np.cos(2 * np.pi * time / (17 * PERIOD))


@pytest.mark.parametrize("share", [1e-5, 1e-3, 0.03, 0.2, 0.35])
def test_jitter_goes_onto_the_grid_that_it_scatters_about(share):
    time = jittered(share)
    found = grid(time)
    assert not found.regular
    assert len(found.time) == len(time)
    assert found.gaps is None
    assert abs(found.period - PERIOD) <= found.uncertainty
    np.testing.assert_allclose(found.time, 7.0 + PERIOD * np.arange(400), atol=0.1 * share * PERIOD)
    assert found.deviation == pytest.approx(share, rel=0.1)
    assert found.scatter == pytest.approx(share * PERIOD / np.sqrt(3.0), rel=0.1)


@pytest.mark.parametrize("share", [0.03, 0.2])
def test_the_output_is_interpolated_as_well_as_a_cubic_can(share):
    time = jittered(share)
    found = grid(time)
    output, missing = found.interpolated(wave(time))
    inside = slice(3, -3)
    assert not missing[inside].any()
    error = np.max(np.abs(output - wave(found.time))[inside])
    assert error < 6e-3 * share / 0.2
    assert error < 0.25 * np.max(
        np.abs(PchipInterpolator(time, wave(time))(found.time[inside]) - wave(found.time[inside]))
    )
    untouched = np.max(np.abs(wave(time) - wave(found.time)))
    assert error < 0.06 * untouched


@pytest.mark.parametrize("jitter", [0.0, 0.04])
def test_missing_rows_are_missing_and_nothing_else(jitter):
    kept = np.setdiff1d(np.arange(400), [5, 100, 101, 102, 250])
    time = jittered(jitter)[kept]
    found = grid(time)
    np.testing.assert_allclose(found.time, 7.0 + PERIOD * np.arange(400), atol=0.1 * PERIOD * (jitter + 1e-9))
    output, missing = found.interpolated(wave(time))
    assert np.flatnonzero(missing).tolist() == [5, 100, 101, 102, 250]
    np.testing.assert_allclose(output[~missing], wave(found.time)[~missing], atol=0.01 * (jitter > 0.0) + 1e-9)
    assert np.all(np.isfinite(output))
    assert np.flatnonzero(found.gaps).tolist() == [4, 98, 245]


def test_rows_without_a_value_are_missing():
    time = jittered(0.0)
    values = wave(time)
    values[[0, 9, 10, 399]] = np.nan
    output, missing = grid(time).interpolated(values)
    assert np.flatnonzero(missing).tolist() == [0, 9, 10, 399]
    np.testing.assert_array_equal(output[~missing], values[~missing])
    assert np.all(np.diff(output) != 0.0)
    jitter = jittered(0.03)
    values = wave(jitter)
    values[200:203] = np.nan
    assert np.flatnonzero(grid(jitter).interpolated(values)[1]).tolist() == [200, 201, 202]


@pytest.mark.parametrize("ratio", [0.75, 1.5])
def test_a_frame_rate_that_wanders(ratio):
    """From 25 frames/s on, slower or faster: no grid fits, and one of the typical step is as dense as the rows."""
    time = np.cumsum(PERIOD * np.linspace(1.0, ratio, 500))
    found = grid(time)
    assert found.period == pytest.approx(PERIOD * (1.0 + ratio) / 2.0, rel=0.05)
    assert found.deviation > 0.45
    output, missing = found.interpolated(wave(time))
    assert not missing.any()
    assert np.max(np.abs(output - wave(found.time))[3:-3]) < 0.02


@pytest.mark.parametrize("share", [1e-4, 0.2])
def test_a_held_input_keeps_its_area_and_does_not_jump_to_the_next_row(share):
    time = jittered(share, 60)
    values = np.random.default_rng(5).standard_normal(60)
    found = grid(time)
    held = found.held(values, "zoh")

    def piecewise(t):
        return values[int(np.searchsorted(time, t, side="right")) - 1] if t >= time[0] else 0.0

    for row in (0, 7, 30, 59):
        # What the first row's input does before the grid begins is in its first step.
        edges = min(found.time[row], time[0]) if row == 0 else found.time[row], found.time[row] + found.period
        inside = [t for t in time if edges[0] < t < edges[1]]
        area = quad(piecewise, *edges, points=inside or None)[0]
        assert held[row] == pytest.approx(area / found.period, abs=1e-6)
    assert np.max(np.abs(held - values)) <= 2.2 * share * np.max(np.abs(np.diff(values)))


def test_the_lines_of_a_first_order_hold_are_read_at_the_grid():
    time = jittered(0.2, 60)
    found = grid(time)
    np.testing.assert_allclose(found.held(3.0 * time - 1.0, "foh")[1:-1], (3.0 * found.time - 1.0)[1:-1], atol=1e-12)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_an_input_is_held_over_a_gap(hold):
    kept = np.setdiff1d(np.arange(60), [20, 21, 22])
    values = np.arange(60.0)[kept]
    held = grid(jittered(0.0, 60)[kept]).held(values, hold)
    np.testing.assert_allclose(held[:23], [*range(20), 19, 19, 19], atol=1e-6)
    np.testing.assert_allclose(held[23:], np.arange(23.0, 60.0), atol=1e-6)


def test_regular_and_rounded_times_stay_as_they_are():
    for time in (0.1 * np.arange(50), np.round(np.arange(50) / 30.0, 2), 1.7e9 + 0.02 * np.arange(50)):
        found = grid(time)
        assert found.regular
        np.testing.assert_array_equal(found.time, time)
        values = wave(time)
        np.testing.assert_array_equal(found.interpolated(values)[0], values)
        assert found.held(values, "zoh") is values


@pytest.mark.parametrize("digits", [6, 9])
def test_times_of_so_many_significant_digits_stay_as_they_are(digits):
    """As printf writes them with %g: the larger they are, the fewer decimals."""
    written = np.array([float(f"{k / 60.0:.{digits}g}") for k in range(2400)])
    grid = grid_of(written, str)
    assert grid.regular
    assert grid.period == pytest.approx(1.0 / 60.0, abs=2.0 * grid.uncertainty)


def test_too_irregular():
    time = PERIOD * np.arange(100)
    time[50] = time[49] + 0.03 * PERIOD
    assert "row 50: a step of 0.0012 s where the period is 0.0394062 s: the sampling is too irregular" in refusal(time)
    assert "the sampling is too irregular" in refusal(np.cumsum(np.random.default_rng(1).exponential(1.0, 200)))
    sparse = np.concatenate([PERIOD * np.arange(20) + k for k in range(0, 20, 4)])
    assert "% of the period's grid has no row near, the largest gap being 3.24 s" in refusal(sparse)
    assert "row 4" in refusal([0.0, 0.1, 0.2, 0.3, 1e12, 1e12 + 0.1, 1e12 + 0.2])
    assert "too irregular" in refusal([0.0, 1.0, 11.0, 12.0, 22.0, 23.0, 100.0])
