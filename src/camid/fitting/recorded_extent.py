"""What the recordings of a problem span: :class:`camid.effects.extent.Extent`."""

from __future__ import annotations

import numpy as np

from camid.effects.extent import Extent
from camid.effects.noise import noise_beside_motion
from camid.fitting.problem import Problem


def extent_of(problem: Problem) -> Extent:
    """Way, time, speed and input that the recordings of a problem reach."""
    positions = problem.kind.recorded_positions(problem)
    span = max(float(np.ptp(each)) for each in positions)
    duration = max(float(time[-1] - time[0]) for time in problem.times)
    period = problem.acquisition.period
    # Noise is in the differences of two rows, too: that has to be taken from their mean square.
    squares = [
        float(np.mean(np.gradient(each, period) ** 2)) - 0.5 * (noise_beside_motion(each) / period) ** 2
        for each in positions
        if len(each) > 1
    ]
    speed = float(np.sqrt(max(*squares, (span / duration) ** 2)))
    # In a loop that is declared the command is not known beforehand.
    commands = [
        np.inf if problem.kind.loop(index) is not None else float(np.max(np.abs(each.signal), initial=0.0))
        for index, each in enumerate(problem.experiments)
    ]
    return Extent(span, duration, speed, max(commands))
