"""Times of step responses: as many as the motion of every pole needs while it lasts, and few afterwards."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.analysis.linear_model import LinearModel
from camid.errors import InputError
from camid.number_text import plain

Array = NDArray[np.float64]

# Points of a response: so many for each cycle of the fastest mode, within limits.
POINTS_OF_CYCLE, FEWEST_POINTS, MOST_POINTS = 32, 1001, 20001
# Of a mode that does not die away in time, fewer would show another motion than its own.
FEWEST_OF_CYCLE = 8
# Points of a time constant of a real pole, and time constants after which a motion has died away: what is left of its
# slope then is multiplied by the step of a grid that may be some million times as coarse.
POINTS_OF_CONSTANT, CONSTANTS = 8, 25.0


@dataclass(frozen=True)
class StepTimes:
    """Uniform grids of times in seconds from zero on; the last is over the whole duration, those before finer."""

    grids: tuple[Array, ...]

    def sampled(self, run: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Times, and what a function of uniform times gives there; each grid counts from where the finer one ends."""
        times, values, end = [], [], -1.0
        for grid in self.grids:
            later = grid > end
            times.append(grid[later])
            values.append(run(grid)[later])
            end = float(grid[-1])
        return np.concatenate(times), np.concatenate(values)


def step_times(models: list[LinearModel], duration: float) -> StepTimes:
    """Times from zero to a duration in seconds for the modes of some models.

    Raises
    ------
    InputError
        If a mode swings more often than can be shown.
    """
    poles = np.concatenate([model.plant.poles() for model in models])
    cycles = duration / (2.0 * np.pi) * float(np.max(poles.imag, initial=0.0))
    wanted = POINTS_OF_CYCLE * cycles
    count = int(np.clip(wanted, FEWEST_POINTS, MOST_POINTS)) if wanted <= MOST_POINTS else FEWEST_POINTS
    finest, grids = duration / (count - 1), [np.linspace(0.0, duration, count)]
    needed = {part for model in models for pole in model.plant.poles() if (part := _needed(model, pole, duration))}
    for end, step in sorted(needed, reverse=True):
        if step < finest:
            finest = step
            grids.append(np.linspace(0.0, end, int(np.clip(np.ceil(end / step), 2, MOST_POINTS)) + 1))
    return StepTimes(tuple(reversed(grids)))


def _needed(model: LinearModel, pole: complex, duration: float) -> tuple[float, float] | None:
    """How long the motion of a pole lasts, and the step that shows it; None of a pole at zero."""
    rate, swing = abs(pole.real), abs(pole.imag)
    if rate == 0.0 and swing == 0.0:
        return None
    end = duration if pole.real >= 0.0 else min(duration, CONSTANTS / rate)
    if swing == 0.0:
        return end, 1.0 / (POINTS_OF_CONSTANT * rate)
    period = 2.0 * np.pi / swing
    if FEWEST_OF_CYCLE * end / period > MOST_POINTS:
        longest = 0.99 * MOST_POINTS * period / FEWEST_OF_CYCLE
        raise InputError(
            f"{plain(end / period, 3)} cycles of the mode at {plain(swing, 4)} rad/s are more than can be shown",
            where=model.simulation.source or model.name,
            hint=f"give a duration of at most {plain(longest, 2)} s in place of {plain(duration, 4)} s",
        )
    return end, period / POINTS_OF_CYCLE
