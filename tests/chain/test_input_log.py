"""An input with times of its own: integrals, means and moments are those of the held or straight signal."""

import numpy as np
import pytest
from scipy.integrate import quad

from camid.chain.input_log import InputLog

TIME = 3.0 + np.cumsum(np.random.default_rng(0).uniform(0.05, 0.15, 30))
VALUES = np.random.default_rng(1).standard_normal(30)


def value(hold, t):
    if t < TIME[0]:
        return 0.0
    if hold == "zoh":
        return VALUES[np.searchsorted(TIME, t, side="right") - 1]
    return np.interp(t, TIME, VALUES)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_integrals_are_those_of_the_signal(hold):
    log = InputLog(TIME, VALUES, hold)
    wanted = np.array([2.5, TIME[0], 3.77, TIME[7], 4.9, TIME[-1], TIME[-1] + 0.7])
    area, moment = log.pieces.integrals(wanted)
    for i, end in enumerate(wanted):
        corners = [t for t in TIME if t < end]
        low = min(TIME[0], end)
        exact = quad(lambda t: value(hold, t), low, end, points=corners or None, limit=200)[0]
        first = quad(lambda t: (t - TIME[0]) * value(hold, t), low, end, points=corners or None, limit=200)[0]
        assert area[i] == pytest.approx(exact, abs=1e-9)
        assert moment[i] == pytest.approx(first, abs=1e-9)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_values_between_the_samples(hold):
    log = InputLog(TIME, VALUES, hold)
    wanted = np.linspace(2.0, TIME[-1] + 1.0, 200)
    np.testing.assert_allclose(log.pieces.at(wanted), [value(hold, t) for t in wanted], atol=1e-12)


def test_a_grid_step_pushes_a_mass_as_the_input_does():
    """Velocity and position of a free mass at the end of every step, from the lines and from the input itself."""
    log = InputLog(TIME, VALUES, "zoh")
    start, step, count = 2.9, 0.13, 25
    first, last = log.on_grid(start, step, count)
    velocity = position = true_velocity = true_position = 0.0
    for k in range(count):
        a, b = start + k * step, start + (k + 1) * step
        position += velocity * step + first[k] * step**2 / 2 + (last[k] - first[k]) * step**2 / 6
        velocity += 0.5 * (first[k] + last[k]) * step
        area, moment = (np.diff(v)[0] for v in log.pieces.integrals(np.array([a, b])))
        true_position += true_velocity * step + (b - TIME[0]) * area - moment
        true_velocity += area
        assert velocity == pytest.approx(true_velocity, abs=1e-12)
        assert position == pytest.approx(true_position, abs=1e-12)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
def test_samples_are_divided_into_pieces_of_the_same_signal(hold):
    log = InputLog(TIME, VALUES, hold)
    time, first, last = log.divided(5)
    assert len(time) == 5 * len(TIME)
    inside = time < TIME[-1] - 1e-9
    np.testing.assert_allclose(first[inside], log.pieces.at(time[inside] + 1e-12), atol=1e-9)
    ends = np.append(time[1:], np.inf)[inside]
    np.testing.assert_allclose(last[inside], log.pieces.at(ends - 1e-9), atol=1e-6)
    assert (last is first) == (hold == "zoh")


def test_rows_hold_the_mean_of_a_held_input_and_the_value_of_a_straight_one():
    rows = np.array([3.2, 3.5, 3.8])
    zoh, foh = InputLog(TIME, VALUES, "zoh"), InputLog(TIME, VALUES, "foh")
    np.testing.assert_allclose(zoh.samples(rows, 0.3), zoh.pieces.means(np.array([3.2, 3.5, 3.8, 4.1])))
    np.testing.assert_allclose(foh.samples(rows, 0.3), foh.pieces.at(rows))
    assert zoh.with_hold("foh").hold == "foh"
    assert zoh.with_hold("foh") is zoh.with_hold("foh")
