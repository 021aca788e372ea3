"""The input on its way to the machine: hold, delay, static curves, play and slew, all exact on straight pieces."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit
from camid.proof.concealed.machine_integrator import Segments
from camid.proof.concealed.rig_setup import MOVING_LEAD, TAIL, Setup

Array = NDArray[np.float64]
Curve = Callable[[Array], Array]

PIECES = 16  # straight pieces of a frame for an input that is not held


def pieces(start: Array, value: Array, slope: Array) -> Segments:
    """Straight pieces without jumps of the velocity."""
    return Segments(start, value, slope, np.zeros(len(start)))


def held(start: Array, value: Array) -> Segments:
    """Constant pieces."""
    return pieces(start, value, np.zeros(len(start)))


def _ends(segments: Segments) -> Array:
    """Value at the end of every piece; the last one is as long as the one before."""
    duration = np.diff(segments.start, append=2.0 * segments.start[-1] - segments.start[-2])
    return segments.value + segments.slope * duration


def connected(start: Array, corner: Array) -> Segments:
    """Straight lines through corners; constant after the last."""
    slope = np.diff(corner, append=corner[-1]) / np.diff(start, append=start[-1] + 1.0)
    return pieces(start, corner, slope)


def refined(segments: Segments, period: float) -> Segments:
    """The same input in more pieces where it is not constant."""
    if not np.any(segments.slope):
        return segments
    offsets = np.arange(PIECES) / PIECES * period
    longest = float(np.max(np.diff(segments.start)))
    if longest < 0.9 * period:
        return segments
    start = (segments.start[:, None] + offsets).ravel()
    value = (segments.value[:, None] + segments.slope[:, None] * offsets).ravel()
    return pieces(start, value, np.repeat(segments.slope, PIECES))


def curve(function: Curve) -> Callable[[Segments, float], Segments]:
    """A static curve as an input map."""

    def apply(segments: Segments, period: float) -> Segments:
        fine = refined(segments, period)
        first, last = function(fine.value), function(_ends(fine))
        duration = np.diff(fine.start, append=2.0 * fine.start[-1] - fine.start[-2])
        return pieces(fine.start, first, np.where(fine.slope == 0.0, 0.0, (last - first) / duration))

    return apply


@njit
def _play(values: Array, half_width: float, share: float) -> Array:
    result = np.empty_like(values)
    inside = 0.0
    for i in range(len(values)):
        inside = min(max(inside, values[i] - half_width), values[i] + half_width)
        result[i] = inside + share * (values[i] - inside)
    return result


def play(half_width: float, share: float) -> Callable[[Segments, float], Segments]:
    """Backlash; a share of the motion within the gap gets through where the gap is soft."""

    def apply(segments: Segments, period: float) -> Segments:
        fine = refined(segments, period)
        return held(fine.start, _play(fine.value, half_width, share))

    return apply


def pulses_of_width(full: float, pulses: int) -> Callable[[Segments, float], Segments]:
    """Each held value as pulses of the full voltage in V that have the same area, so many in each piece.

    They are in the middle of their share of the time, as those of a symmetric carrier, so that nothing comes early.
    """

    def apply(segments: Segments, period: float) -> Segments:
        fine = refined(segments, period)
        length = np.diff(fine.start, append=2.0 * fine.start[-1] - fine.start[-2]) / pulses
        rise = (fine.start[:, None] + length[:, None] * np.arange(pulses)).ravel()
        level = np.repeat(fine.value, pulses)
        duty = np.clip(np.abs(level) / full, 0.0, 0.999)
        room = np.repeat(length, pulses)
        start = np.stack((rise, rise + 0.5 * (1.0 - duty) * room, rise + 0.5 * (1.0 + duty) * room), axis=1)
        none = np.zeros(len(duty))
        value = np.stack((none, full * np.sign(level), none), axis=1)
        kept = np.ones_like(start, dtype=bool)
        kept[:, 1:] = duty[:, None] > 0.0
        return held(start[kept], value[kept])

    return apply


@njit
def _slew(start: Array, target: Array, rate: float) -> tuple[Array, Array, Array]:
    times, values, slopes = np.empty(2 * len(start)), np.empty(2 * len(start)), np.zeros(2 * len(start))
    count, now = 0, 0.0
    for i in range(len(start)):
        end = start[i + 1] if i + 1 < len(start) else np.inf
        times[count], values[count] = start[i], now
        needed = abs(target[i] - now) / rate
        if needed > 0.0:
            slopes[count] = rate if target[i] > now else -rate
        count += 1
        if needed >= end - start[i]:
            now += slopes[count - 1] * (end - start[i])
            continue
        now = target[i]
        if needed > 0.0:
            times[count], values[count] = start[i] + needed, now
            count += 1
    return times[:count], values[:count], slopes[:count]


def slew(rate: float) -> Callable[[Segments, float], Segments]:
    """Slew limit in V/s for a held input."""

    def apply(segments: Segments, period: float) -> Segments:
        return pieces(*_slew(segments.start, segments.value, rate))

    return apply


def _with_kicks(segments: Segments, kicks: list[tuple[float, float]]) -> Segments:
    """Pieces cut where the velocity jumps."""
    for time, jump in kicks:
        before = int(np.searchsorted(segments.start, time, side="right")) - 1
        value, slope = 0.0, 0.0
        if before >= 0:
            slope = float(segments.slope[before])
            value = float(segments.value[before] + slope * (time - segments.start[before]))
        place = before + 1
        segments = Segments(
            np.insert(segments.start, place, time),
            np.insert(segments.value, place, value),
            np.insert(segments.slope, place, slope),
            np.insert(segments.kick, place, jump),
        )
    return segments


def input_path(setup: Setup, command: Array) -> Segments:
    """What reaches the actuator.

    Parameters
    ----------
    setup : Setup
    command : ndarray, shape (setup.input_length,)
        V; the first sample belongs to the first frame, or to the first frame of the lead where the machine is moving.
    """
    first = -MOVING_LEAD if setup.moving else 0
    start = np.arange(first, first + len(command), dtype=np.float64) * setup.period
    if setup.hold == "zoh":
        segments = held(start, command)
    elif setup.hold == "foh":
        segments = connected(start, command)
    else:
        from scipy.signal import resample

        around = np.concatenate([np.zeros(TAIL), command, np.zeros(TAIL)])
        fine = resample(around, PIECES * len(around))[PIECES * TAIL : -PIECES * TAIL]
        corners: Array = start[0] + np.arange(len(fine), dtype=np.float64) * setup.period / PIECES
        segments = connected(corners, fine)
    for change in setup.input_maps:
        segments = change(segments, setup.period)
    if setup.transport_delay:
        segments = Segments(segments.start + setup.transport_delay, segments.value, segments.slope, segments.kick)
    return _with_kicks(segments, setup.kicks)
