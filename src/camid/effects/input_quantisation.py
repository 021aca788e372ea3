"""Coarse steps of the command: a converter or a pulse width of few bits, or few speeds that a drive knows."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import copysign
from typing import ClassVar

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.command import at_both_ends, levels
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import LEAST_FACTOR
from camid.effects.residual_regression import ResidualRegression, sampled
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Steps that the largest command may hold, one after the other: a fit finds one from half a step of the largest away.
COUNTS = np.arange(0.6, 20.0, 0.2)
# The same of small steps, of which a fit finds none from a tenth of a step of the largest away, and how many of them
# are looked at closely.
MANY_COUNTS, MOST_PROMISING = np.arange(20.0, 450.0, 0.1), 120
# Steps that are held against a residual at once, which bounds the memory that takes.
AT_ONCE = 100
COUNTS_IN_A_LOOP = (1.2, 2.5, 5.0, 10.0)
BEST, FEWEST_LEVELS = 2, 3
# Steps about one that was fitted, in shares of it: how far, then about the best of these, and how many each time; and
# the sum of squares, as a share, below which one is worth a fit.
NEARLY, AROUND, LEAST_FALL = (3e-2, 1e-3, 3e-5), np.linspace(-1.0, 1.0, 401), 0.999


class InputQuantisation(Effect):
    """A command that is rounded to steps."""

    identifier = "input-quantisation"
    place = "actuator"
    title = "Quantisation of the command"
    equation = r"u' = q\,\mathrm{round}(u/q)"
    reference = "Franklin, Powell & Workman (1998), Digital Control of Dynamic Systems, 3rd ed., chapter 10"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("step", "u", "step q of the command", 1e-300),)
    separated_by = (SeparatingExperiment.MANY_LEVELS,)
    strength = "step"
    trials = "frequencies"
    keeps_hold = True
    size_is_shape = True
    jumps_by = "step"

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return copysign(values[0] * np.floor(abs(signal) / values[0] + 0.5), signal)

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Round to the nearest step."""
        size = self.values["step"]
        return at_both_ends(lambda u: _rounded(u, size), start, end)

    def scaled(self, factor: float) -> InputQuantisation:
        """Other steps."""
        return self.with_vector(self.vector * max(factor, LEAST_FACTOR))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """The large and the small steps that leave least of the residual, to first order; of a loop, some sizes."""
        if situation.controlled:
            yield from (cls(step=situation.largest("signal") / count) for count in COUNTS_IN_A_LOOP)
            return
        regression = _regression(situation)
        if regression.fails:
            return
        largest, signal = situation.largest("signal"), regression.situation.signal[:, None]
        for steps in (largest / COUNTS, _promising(regression, largest / MANY_COUNTS)):
            left, shown = regression.left(_rounded(signal, steps) - signal)
            falls = np.where(shown, 2.0 * regression.residual @ left - np.sum(left**2, axis=0), 0.0)
            for _ in range(BEST):
                best = int(np.argmax(falls))
                if falls[best] <= 0.0:
                    break
                yield cls(step=float(steps[best]))
                falls[max(best - 2, 0) : best + 3] = 0.0

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Steps of nearly the same size that round some commands the other way, to which no derivative leads."""
        regression = _regression(situation)
        if situation.controlled or regression.fails:
            return ()
        signal, step = regression.situation.signal[:, None], self.values["step"]
        now, least = _rounded(signal, np.array([step])), float(regression.residual @ regression.residual)
        worth = LEAST_FALL * least
        for share in NEARLY:
            steps = step * (1.0 + share * AROUND)
            left, _ = regression.left(_rounded(signal, steps) - now)
            costs = np.sum((regression.residual[:, None] - left) ** 2, axis=0)
            if np.min(costs) < least:
                step, least = _middle(steps, costs), float(np.min(costs))
        return (InputQuantisation(step=step),) if least < worth else ()

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """An input of few levels shows nothing of it that is not another curve."""
        if situation.acquisition.hold == "zoh" and levels(situation.all_signals) < FEWEST_LEVELS:
            return "the input has two absolute values at most, for which steps of the command are another curve"
        return None


def _rounded(signal: Array, steps: Array | float) -> Array:
    """A command, shape (N,) or (N, 1), rounded to a step, or to some, shape (c,): halves away from zero."""
    return np.asarray(np.copysign(steps * np.floor(np.abs(signal) / steps + 0.5), signal))


def _middle(steps: Array, costs: Array) -> float:
    """The middle of the steps around the best one that round all commands as it does: others may tell them apart."""
    best = int(np.argmin(costs))
    worse = np.flatnonzero(costs > costs[best] / LEAST_FALL)
    first, last = np.max(worse[worse < best], initial=-1) + 1, np.min(worse[worse > best], initial=len(costs)) - 1
    return float(0.5 * (steps[first] + steps[last]))


def _promising(regression: ResidualRegression, steps: Array) -> Array:
    """Those of many small steps whose response follows the residual best, as if all were of the size of the step.

    The product of a residual and a response is that of what answers in reversed time and the signal.
    """
    signal, reversed_answer = regression.situation.signal[:, None], regression.reversed_answer
    blocks = np.split(steps, range(AT_ONCE, len(steps), AT_ONCE))
    products = np.concatenate([reversed_answer @ (_rounded(signal, block) - signal) for block in blocks])
    best = np.argsort(-products / steps, kind="stable")[:MOST_PROMISING]
    return steps[np.sort(best)]


def _regression(situation: Situation) -> ResidualRegression:
    """What responses to changes of the command explain of a residual."""
    return ResidualRegression(situation, lambda signals: sampled(situation.plant, signals, situation.acquisition))
