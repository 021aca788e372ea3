"""How large the noise of each row is where the motion makes it uneven, as times that scatter do.

Least squares weighs all rows alike, and where most of the noise is that of a fast motion it hears little of what the
slow one says. Rows over the standard deviation of their noise weigh as much as they say (Aitken 1936, Proc. R. Soc.
Edinburgh 55, 42–48).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.situation import Situation
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.fitting.unseen import unseen

Array = NDArray[np.float64]

# A noise-like effect is named where its absence would show as much in fewer recordings than this.
LARGEST_P_VALUE = 1e-4
# Time between the readings whose difference is their rate, as a share of the period.
RATE_STEP = 0.05
# Share of the variance of uneven noise that does not depend on the motion, at least.
LEAST_EVEN = 0.05
# Share of the variance of what is left that has to change from frame to frame: the rest is structure, or a colour.
LEAST_FROM_FRAME_TO_FRAME = 0.5
# Readings that a limit has to recur in.
FEWEST_AT_A_LIMIT = 5
# Ratio of what rows say over their noise to what they say when all weigh alike from which they are compared over it.
WORTH_WEIGHING = 1.5
# Sum of squares, in variances of the noise, of what times that scatter do to the mean of the readings, up to which that
# is left out of account.
LARGEST_BEND = 16.0


def longest_first(problem: Problem) -> list[int]:
    """The recordings that are fitted: noise is recognised in the longest, and may be refuted by the others."""
    return sorted(problem.fitted_runs, key=lambda run: -np.count_nonzero(problem.experiments[run].used))


def with_rate_of_reading(problem: Problem, model: Model, index: int) -> Situation:
    """What recognition needs of a recording, with the rate of its reading.

    Differences from frame to frame fall short of the rate of a motion that turns round within a few frames, and what is
    divided by them is too large. A reading that is delivered later is that of an earlier time, and the next one
    delivered nearly a period later is that of a time just behind. A force that jumps with a frame may bend the reading
    there, so that the rate before and that behind are taken as their root mean square: noise has its mean variance.
    """
    situation = _beside_limits(problem.situation(model, index))
    reading = problem.simulate_one(model, index)
    chain = problem.chain(model, index)
    # In a loop, and where an observer pulls, a latency moves the plant itself; and some kinds of plant compare no
    # reading.
    moves = chain.loop is not None or chain.pull is not None
    if moves or not np.array_equal(reading, situation.position):
        return situation
    period = problem.acquisition.period
    step = RATE_STEP * period
    earlier, later = (problem.delivered_later(t).simulate_one(model, index) for t in (step, period - step))
    before = (reading - earlier) / step
    behind = np.append((later[1:] - reading[:-1]) / step, before[-1])
    return replace(situation, velocity=np.copysign(np.sqrt(0.5 * (before**2 + behind**2)), before + behind))


def _beside_limits(situation: Situation) -> Situation:
    """Without readings at a limit, which have no noise: that of the others would seem to grow with speed or reading."""
    return replace(situation, used=situation.used & ~at_a_limit(situation.recorded, situation.used))


def at_a_limit(recorded: Array, used: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Readings at a limit of what reads them, shape (N,): the largest or least where it recurs. They have no noise."""
    rows = np.zeros(len(recorded), bool)
    for end in (np.min(recorded[used], initial=np.inf), np.max(recorded[used], initial=-np.inf)):
        here = used & (recorded == end)
        rows |= here & (np.count_nonzero(here) >= FEWEST_AT_A_LIMIT)
    return rows


def standard_deviation(effects: Sequence[Effect], situation: Situation) -> Array | None:
    """Standard deviation of the noise in each row, shape (N,), where effects make it uneven; else None."""
    added = [v for effect in effects if (v := effect.added_variance(situation)) is not None]
    if not added:
        return None
    moving = np.sum(added, axis=0)
    variance = float(np.mean(situation.residual[situation.used] ** 2))
    rest = max(variance - float(np.mean(moving[situation.used])), LEAST_EVEN * variance)
    return np.asarray(np.sqrt(rest + moving))


def uneven_spread(problem: Problem, final: Fitted, effects: Sequence[Effect]) -> Array | None:
    """Relative standard deviation of the noise in each fitted row, shape (M,), where effects make it uneven.

    None where none does. One where rows are compared over it already.
    """
    if problem.relative_noise is not None:
        return np.ones(len(problem.output))
    if not any(effect.makes_variance_uneven for effect in effects):
        return None
    noise = _relative(effects, _situations(problem, final.model))
    return None if noise is None else problem.fitted(noise)


def relative_noise(problem: Problem, fitted: Fitted) -> tuple[Array, ...] | None:
    """Relative standard deviation of the noise in each row of each recording, where it is worth to weigh rows by it.

    Structure in what a model leaves may look like uneven noise. It goes on from frame to frame, and what times that
    scatter add does not, so that the second differences of what is left tell them apart.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted

    Returns
    -------
    tuple of ndarray, shapes (N,), or None
        None where the noise is even.
    """
    if problem.relative_noise is not None:
        return None
    each = _situations(problem, fitted.model)
    longest, *others = longest_first(problem)
    differences = _from_frame_to_frame(each[longest])
    if not differences.used.any():
        return None
    changing, whole = (float(np.mean(view.residual[view.used] ** 2)) for view in (differences, each[longest]))
    if changing < LEAST_FROM_FRAME_TO_FRAME * whole:
        return None
    found = []
    for _, effect in sorted(known_effects().items()):
        if effect.makes_variance_uneven and unseen(problem, effect) is None:
            recognition = effect.recognise(differences)
            if recognition is None or not recognition.named or recognition.p_value >= LARGEST_P_VALUE:
                continue
            if not any(recognition.effect.is_refuted(_from_frame_to_frame(each[run])) for run in others):
                found.append(recognition.effect)
    situations = each if found else []
    noise = _relative(found, situations)
    if noise is None:
        return None
    square = problem.fitted(noise) ** 2
    if not np.all(np.isfinite(square)) or np.mean(square) * np.mean(1.0 / square) < WORTH_WEIGHING:
        return None
    return None if any(_bend(effect, situations) > LARGEST_BEND for effect in found) else noise


def _situations(problem: Problem, model: Model) -> list[Situation]:
    return [with_rate_of_reading(problem, model, i) for i in range(len(problem.experiments))]


def _relative(effects: Sequence[Effect], situations: Sequence[Situation]) -> tuple[Array, ...] | None:
    """Standard deviation of the noise in each row of each recording over its root mean square there, shapes (N,)."""
    found = []
    for situation in situations:
        # What is not fitted tells nothing of its noise, and judges as it is.
        spread = standard_deviation(effects, situation) if situation.used.any() else np.ones(len(situation.time))
        if spread is None:
            return None
        rows = situation.used if situation.used.any() else np.ones(len(spread), bool)
        found.append(np.asarray(spread / np.sqrt(np.mean(spread[rows] ** 2))))
    return tuple(found) or None


def _bend(effect: Effect, situations: Sequence[Situation]) -> float:
    """Sum of squares of what an effect does to the mean of the fitted readings, in variances of their noise."""
    total = 0.0
    for situation in situations:
        bend, spread = effect.bend_of_mean(situation), standard_deviation([effect], situation)
        if bend is not None and spread is not None and situation.used.any():
            total += float(np.sum((bend / spread)[situation.used] ** 2))
    return total


def _from_frame_to_frame(situation: Situation) -> Situation:
    """The same with second differences of the residual, of which white noise has its own variance."""
    residual, used = np.zeros(len(situation.time)), np.zeros(len(situation.time), bool)
    residual[1:-1] = np.diff(situation.residual, 2) / np.sqrt(6.0)
    used[1:-1] = situation.used[:-2] & situation.used[1:-1] & situation.used[2:]
    square = situation.velocity**2
    speed = np.sqrt(np.convolve(np.pad(square, 1, "edge"), [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0], "valid"))
    return replace(situation, residual=residual, velocity=speed, used=used)
