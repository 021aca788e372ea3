"""The camera: averages over windows of a finely sampled motion, and the way of the readings into the recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.proof.concealed.input_path import input_path
from camid.proof.concealed.machine_integrator import Trajectory, integrate
from camid.proof.concealed.rig_setup import TAIL, Setup

Array = NDArray[np.float64]

ROLLING_ITERATIONS = 40


class _Antiderivative:
    """Integral of a signal that is known with its slope on both sides of equally spaced nodes.

    Between two nodes it is the polynomial of fifth degree that has the integral, the signal and its slope at both ends.
    """

    def __init__(self, start: float, step: float, value: Array, after: Array, before: Array, integral: Array) -> None:
        self.start, self.step = start, step
        self.value, self.after, self.before, self.integral = value, after, before, integral

    def at(self, time: Array) -> tuple[Array, Array]:
        """Integral and signal at times in s within the nodes."""
        h = self.step
        position = np.clip((time - self.start) / h, 0.0, len(self.after))
        # A time that is a node except for rounding belongs to the interval that begins there.
        i = np.minimum(np.floor(position + 1e-9).astype(np.int64), len(self.after) - 1)
        x = np.clip(position - i, 0.0, 1.0)
        q0, v0, a0 = self.integral[i], h * self.value[i], h * h * self.after[i]
        q1, v1, a1 = self.integral[i + 1], h * self.value[i + 1], h * h * self.before[i]
        rest, slope_rest, curve_rest = q1 - q0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
        c3 = 10.0 * rest - 4.0 * slope_rest + 0.5 * curve_rest
        c4 = -15.0 * rest + 7.0 * slope_rest - curve_rest
        c5 = 6.0 * rest - 3.0 * slope_rest + 0.5 * curve_rest
        integral = q0 + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))))
        value = (v0 + x * (a0 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / h
        return integral, value


def _signal(setup: Setup, trajectory: Trajectory, *, distorted: bool = True) -> _Antiderivative:
    """Position of what is seen in the output's units, distorted where the lens does so."""
    scale = setup.rig.output_scale
    position, integral = scale * trajectory.position, scale * trajectory.integral
    after, before = scale * trajectory.velocity_after, scale * trajectory.velocity_before
    maps = [each for each in (setup.load_map, setup.position_map if distorted else None) if each is not None]
    for each in maps:
        position, factor = each(position)
        after, before = after * factor[:-1], before * factor[1:]
    if maps:
        # Trapezoidal rule with the slopes at the ends.
        mean = 0.5 * (position[1:] + position[:-1]) + trajectory.step / 12.0 * (after - before)
        integral = np.concatenate([[0.0], np.cumsum(mean * trajectory.step)])
    return _Antiderivative(trajectory.start, trajectory.step, position, after, before, integral)


def position_at(setup: Setup, trajectory: Trajectory, time: Array) -> Array:
    """Undistorted position in the output's units at times in s."""
    return _signal(setup, trajectory, distorted=False).at(time)[1]


def _averages(signal: _Antiderivative, end: Array, length: float) -> Array:
    """Means over the windows that end at the given times, or values there where the length is zero."""
    if length == 0.0:
        return signal.at(end)[1]
    return (signal.at(end)[0] - signal.at(end - length)[0]) / length


def _weighted(setup: Setup, trajectory: Trajectory, end: Array, length: float) -> Array:
    """Means with weights that depend on the speed (paper equation (2))."""
    assert setup.speed_weight is not None
    scale = setup.rig.output_scale
    speed = scale * np.append(trajectory.velocity_after, trajectory.velocity_before[-1])
    weight = setup.speed_weight(np.abs(speed))
    nodes = trajectory.start + trajectory.step * np.arange(len(speed))

    def accumulated(values: Array) -> Array:
        sums = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))])
        return np.interp(end, nodes, sums) - np.interp(end - length, nodes, sums)

    total = accumulated(weight)
    plain = _averages(_signal(setup, trajectory), end, length)
    moving = total > 1e-9 * np.max(weight) * length / trajectory.step
    weighted = accumulated(weight * scale * trajectory.position)
    return np.where(moving, weighted / np.where(moving, total, 1.0), plain)


def motion(setup: Setup, command: Array, refinement: int = 1) -> Trajectory:
    """Motion of the machine under a command in V, from before the first frame to after the last.

    Raises
    ------
    camid.proof.concealed.machine_integrator.DivergedError
        If the motion leaves every bound.
    """
    segments = input_path(setup, command)
    moved = integrate(
        setup.parameters, segments, setup.period, -setup.lead, setup.frames + TAIL, refinement * setup.refinement
    )
    return replace(moved, command=command[setup.first : setup.first + setup.frames])


def readings(setup: Setup, trajectory: Trajectory, jitter: Array | None = None) -> Array:
    """Frame values before offsets, clipping and noise, in the output's units.

    Parameters
    ----------
    setup : Setup
    trajectory : Trajectory
    jitter : ndarray, shape (N,), optional
        Errors of the frames' times in s.

    Returns
    -------
    ndarray, shape (N,)
    """
    end: Array = np.arange(setup.frames, dtype=np.float64) * setup.period * (1.0 + setup.skew) - setup.latency
    if jitter is not None:
        end = end + jitter
    if setup.speed_weight is not None:
        return _weighted(setup, trajectory, end, setup.exposure)
    signal = _signal(setup, trajectory)
    values = _averages(signal, end, setup.exposure)
    if setup.rolling:
        # The row that is read is where the marker is seen: a fixed point.
        for _ in range(ROLLING_ITERATIONS):
            before, values = values, _averages(signal, end + setup.rolling * values, setup.exposure)
            if np.max(np.abs(values - before)) < 1e-9 * np.max(np.abs(values)):
                break
    if setup.pickup:
        assert trajectory.command is not None  # of a motion that is recorded
        values = values + setup.pickup * trajectory.command
    return values


def clean(setup: Setup, values: Array) -> Array:
    """Readings with everything that is deterministic, and without noise."""
    time: Array = np.arange(setup.frames, dtype=np.float64) * setup.period
    for change in (*setup.before_noise, *setup.after_noise):
        values = change(values, time, None)
    return values


def record(
    setup: Setup, trajectory: Trajectory, noise_std: float, noise: np.random.Generator, events: np.random.Generator
) -> Array:
    """What is written into the recording.

    Parameters
    ----------
    setup : Setup
    trajectory : Trajectory
    noise_std : float
        Of the additive noise, in the output's units.
    noise, events : numpy.random.Generator
        Sources of the additive noise, and of all else that is random.
    """
    time: Array = np.arange(setup.frames, dtype=np.float64) * setup.period
    jitter = setup.jitter * events.standard_normal(setup.frames) if setup.jitter else None
    values = readings(setup, trajectory, jitter)
    drawn = noise.standard_normal(setup.frames) if setup.colour is None else setup.colour(noise, setup.frames)
    repeated = np.zeros(setup.frames, bool)
    if setup.partial_repeats:
        # The camera restarts: a frame is exposed for a part of its time, and delivered a second time in the next.
        repeated = events.random(setup.frames) < setup.partial_repeats
        repeated[0] = False
        cut = readings(replace(setup.copy(), exposure=0.4 * setup.exposure), trajectory)
        values = np.where(np.append(repeated[1:], False), cut, values)
    for change in setup.before_noise:
        values = change(values, time, events)
    values = values + noise_std * drawn
    index = np.arange(setup.frames)
    values = values[np.maximum.accumulate(np.where(repeated, 0, index))]
    for change in setup.after_noise:
        values = change(values, time, events)
    return values
