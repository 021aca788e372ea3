"""Input on the integrator's grid: hold, actuator effects, known forces, and the controller of a closed loop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.controller import Loop
from camid.chain.hold import driven
from camid.effects.base import Effect
from camid.engine.feedback import Feedback

Array = NDArray[np.float64]

# Periods that the motion goes on past the last frame, for exposures that effects shift.
MARGIN = 2


def grid_input(
    effects: Sequence[Effect],
    signal: Array,
    acquisition: Acquisition,
    delay: int,
    steps: int,
    loop: Loop | None = None,
    known_force: tuple[Array, str] | None = None,
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

    Returns
    -------
    start, end : ndarray, shape (M,)
    """
    step = acquisition.period / steps
    start, end = _between(signal if loop is None else np.zeros(len(signal)), acquisition.hold, delay, steps)
    # What an actuator makes of a controller's output, the integrator has to find out as it goes.
    for effect in effects if loop is None else ():
        start, end = effect.transform(start, end, step)
    if known_force is not None:
        extra_start, extra_end = _between(known_force[0], known_force[1], delay, steps)
        start, end = start + extra_start, end + extra_end
    return np.ascontiguousarray(start), np.ascontiguousarray(end)


def feedback_of(loop: Loop | None, steps: int) -> Feedback:
    """The controller as the integrator takes it."""
    if loop is None:
        return Feedback(0, np.zeros(0), 0.0, 0.0, 0.0, np.zeros(0))
    controller, reference = loop.controller, np.ascontiguousarray(loop.reference, dtype=float)
    return Feedback(
        steps,
        reference,
        float(controller.position_gain),
        float(controller.velocity_gain),
        float(controller.limit),
        np.zeros(len(reference)),
    )


def _between(signal: Array, hold: str, delay: int, steps: int) -> tuple[Array, Array]:
    """Input at the start and end of each step, zero before the record and constant past it."""
    signal, _ = driven(np.asarray(signal, dtype=float), hold)
    first = np.concatenate([np.zeros(delay), signal, np.full(MARGIN, signal[-1])])
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
