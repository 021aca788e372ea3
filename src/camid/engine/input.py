"""Input on the integrator's grid: hold, actuator effects, known forces, and the controller of a closed loop."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.controller import Loop
from camid.chain.hold import driven
from camid.chain.input_log import InputLog, StraightPieces
from camid.chain.observer import Pull
from camid.chain.plant import TransferFunction
from camid.compiled import njit
from camid.effects.base import Effect
from camid.engine.feedback import Feedback

Array = NDArray[np.float64]

# Periods that the motion goes on past the last frame, for exposures that effects shift; where they shift them further,
# it goes on further, by this share of the recording at most.
MARGIN, MOST_PAST = 2, 0.25
# Parts of a frame in each of which an actuator makes a straight line of its input, and their length in radians of the
# plant's fastest motion: kinks lie anywhere. A fit may come by plants of any speed, which no frames show.
PARTS, MOST_PARTS = 24, 400
PART = 0.022
# Parts of a sample at least for an input that has times of its own, which has as many in a frame.
FEWEST_LOG_PARTS = 4


def grid_input(
    effects: Sequence[Effect],
    signal: Array,
    acquisition: Acquisition,
    delay: int,
    steps: int,
    loop: Loop | None = None,
    known_force: tuple[Array, str] | None = None,
    log: tuple[InputLog, float] | None = None,
    parts: int = 1,
    margin: int = MARGIN,
) -> tuple[Array, Array]:
    """Input at the start and end of each step of the grid; zero where a controller makes it.

    Parameters
    ----------
    effects : sequence of Effect
    signal : ndarray, shape (N,)
        Recorded input u_k.
    acquisition : Acquisition
    delay : int
        Periods by which the grid begins before the record.
    steps : int
        In a period.
    loop : Loop, optional
    known_force : tuple of (ndarray of shape (N,), {"zoh", "foh"}), optional
        A force that is a function of time.
    log : tuple of (InputLog, float), optional
        The input at times of its own in place of ``signal``, and the time at which the grid begins, in seconds.
    parts : int
        Of a period, at least, in each of which an actuator makes a straight line of its input.
    margin : int
        Periods by which the grid goes on past the record, in which the input stays as it was; see :func:`periods_past`.

    Returns
    -------
    start, end : ndarray, shape (M,)
    """
    step = acquisition.period / steps
    if log is not None:
        start, end = _logged(effects, log[0], acquisition, log[1], step, (delay + len(signal) + margin) * steps)
    else:
        signal = signal if loop is None else np.zeros(len(signal))
        # What an actuator makes of a controller's output, the integrator has to find out as it goes.
        parts = ceil(parts / steps) if loop is None else 1
        start, end = _between(signal, acquisition.hold, delay, steps * parts, margin)
        for effect in effects if loop is None else ():
            start, end = effect.transform(start, end, step / parts)
        if parts > 1:
            start, end = _joined(start, end, parts)
    if known_force is not None:
        extra_start, extra_end = _between(known_force[0], known_force[1], delay, steps, margin)
        start, end = start + extra_start, end + extra_end
    return np.ascontiguousarray(start), np.ascontiguousarray(end)


def periods_past(effects: Sequence[Effect], time: Array, period: float) -> int:
    """Periods by which the motion is simulated past the last of the recorded times, shape (N,)."""
    ahead = max((effect.ahead(time) for effect in effects), default=0.0)
    return MARGIN + min(ceil(ahead / period), int(MOST_PAST * len(time)))


def parts_in_a_period(effects: Sequence[Effect], acquisition: Acquisition, plant: TransferFunction) -> int:
    """Parts of a period in which the input is a straight line behind the actuator: one where it is held there, too.

    Parameters
    ----------
    effects : sequence of Effect
    acquisition : Acquisition
    plant : TransferFunction
        Which sees how an actuator bends the input within a step.
    """
    bending = (e for e in effects if type(e).transform is not Effect.transform)
    if all(acquisition.hold == "zoh" and effect.keeps_hold for effect in bending):
        return 1
    return min(max(PARTS, ceil(acquisition.period * plant.fastest_pole / PART)), MOST_PARTS)


@njit(nogil=True)
def _joined(start: Array, end: Array, parts: int) -> tuple[Array, Array]:
    """Lines in steps of so many parts each, with the mean and the first moment of the lines in these."""
    count = len(start) // parts
    first, last = np.empty(count), np.empty(count)
    for k in range(count):
        mean, moment = 0.0, 0.0
        for part in range(parts):
            here, there = start[k * parts + part], end[k * parts + part]
            mean += 0.5 * (here + there)
            # Of a step of unit length about its middle: what the middle of the part contributes, and the slope in it.
            moment += 0.5 * (here + there) * ((part + 0.5) / parts - 0.5) + (there - here) / (12.0 * parts)
        mean, moment = mean / parts, moment / parts
        first[k], last[k] = mean - 6.0 * moment, mean + 6.0 * moment
    return first, last


def _logged(
    effects: Sequence[Effect], log: InputLog, acquisition: Acquisition, begin: float, step: float, count: int
) -> tuple[Array, Array]:
    """Lines in the steps of a grid for an input with times of its own, and what actuators make of it.

    They act on the samples as they were logged: what a step of the grid holds of several samples is none that they saw.
    """
    log = log.with_hold(acquisition.hold)
    actuators = [e for e in effects if type(e).transform is not Effect.transform]
    if not actuators:
        return log.on_grid(begin, step, count)
    held = log.hold == "zoh" and all(e.keeps_hold for e in actuators)
    parts = 1 if held else max(ceil(PARTS * log.period / acquisition.period), FEWEST_LOG_PARTS)
    time, start, end = log.divided(parts)
    part = log.period / parts
    # The sample before the log, when nothing was put in.
    both = end is start
    start = np.concatenate([[0.0], start])
    end = start if both else np.concatenate([[0.0], end])
    for effect in actuators:
        start, end = effect.transform(start, end, part)
    pieces = StraightPieces(time, start[1:], end[1:], float(end[0]))
    return pieces.on_grid(begin, step, count)


def feedback_of(loop: Loop | None, pull: Pull | None, steps: int) -> Feedback:
    """The controller, or the observer, as the integrator takes it."""
    if pull is not None:
        frames, observer = np.ascontiguousarray(pull.frames, dtype=float), pull.observer
        gains, errors = (observer.position_gain, observer.velocity_gain), np.zeros(len(frames))
        return Feedback(steps, frames, *gains, np.inf, errors, pull.exposure, pull.acquisition.latency)
    if loop is None:
        return Feedback(0, np.zeros(0), 0.0, 0.0, 0.0, np.zeros(0), -1.0, 0.0)
    controller, reference = loop.controller, np.ascontiguousarray(loop.reference, dtype=float)
    return Feedback(
        steps,
        reference,
        float(controller.position_gain),
        float(controller.velocity_gain),
        float(controller.limit),
        np.zeros(len(reference)),
        -1.0,
        0.0,
    )


def _between(signal: Array, hold: str, delay: int, steps: int, margin: int) -> tuple[Array, Array]:
    """Input at the start and end of each step, zero before the record and constant past it."""
    signal, _ = driven(np.asarray(signal, dtype=float), hold)
    first = np.concatenate([np.zeros(delay), signal, np.full(margin, signal[-1])])
    if hold == "zoh":
        start = np.repeat(first, steps)
        return start, start
    following = np.append(first[1:], first[-1])
    if delay:
        following[delay - 1] = 0.0  # the input begins with the record, without a ramp towards it
    share = np.arange(steps) / steps
    slope = (following - first)[:, None]
    start = (first[:, None] + slope * share).ravel()
    return start, (first[:, None] + slope * (share + 1.0 / steps)).ravel()
