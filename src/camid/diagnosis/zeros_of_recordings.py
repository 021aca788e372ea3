"""Zeros of the sensor that differ between recordings: a camera that was moved from one to the next.

A simulation that says nothing of the sensor's zero leaves it to be estimated, one for all recordings of a rig. Where
the camera, or the rig below it, was touched between two of them each has its own, and no effect is one of the plant
that only makes up for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Diagnosis, Signals
from camid.diagnosis.search.hypothesis_search import is_far_off
from camid.diagnosis.watch import Watch
from camid.fitting.fit import Fitted, evaluate
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import OFFSET
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Share of the sum of squares that zeros explain from which they are tried in the place of anything else, and the
# logarithm of the likelihood ratio that they need beside that.
WORTH_TRYING, STRONG = 0.1, 10.0
# Verdicts with which nothing else is looked for.
TOLD = ("explained", "adequate")
# Standard deviations from which zeros differ.
CERTAIN = 5.0
# Rounds in which zeros and coefficients are estimated in turn at most, and the change, in standard deviations of the
# zeros, that is none.
MOST_ROUNDS, SETTLED = 4, 0.1


def with_own_zeros(problem: Problem, base: Fitted, start: Model) -> tuple[Problem, Array] | None:
    """The problem with a zero for each recording, where these explain much of what a model leaves; None elsewhere.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        The nominal structure re-estimated, with one zero for all.
    start : Model
        The nominal structure before that.

    Returns
    -------
    Problem, ndarray of shape (R,)
        With readings that are counted from about the first one's zero, and by how much they are moved for that.
    """
    kind = problem.kind
    alone = all(e.same_run_as is None and e.seen is None for e in problem.experiments)
    if len(problem.fitted_runs) < 2 or not kind.offset_free or not kind.one_reading or not alone or base.weighted:
        return None
    moved = np.zeros(len(problem.experiments))
    for round_ in range(MOST_ROUNDS):
        change, deviations, share = zeros_beyond(problem, base)
        model = base.model
        if round_ == 0 and not _is_much(base, share):
            elsewhere = _of_the_start(problem, base, start)
            if elsewhere is None:
                return None
            change, model = elsewhere
        moved += change
        experiments = [replace(e, output=e.output - zero) for e, zero in zip(problem.experiments, change, strict=True)]
        problem = replace(problem, experiments=experiments)
        base = kind.refit(problem, model)
        if np.all(np.abs(change) <= SETTLED * deviations):
            break
    # What the first one reads at the plant's zero is known from here on: the zeros of all are free about it.
    offset = float(base.model.constants[OFFSET.name])
    experiments = [replace(e, offset=offset, estimate_offset=False) for e in problem.experiments]
    kind = replace(kind, offset=offset, offset_free=False)
    return replace(problem, experiments=experiments, kind=kind, own_zeros=True), moved


def _is_much(base: Fitted, share: float) -> bool:
    """Whether a share of what a model leaves is worth a try, and no chance."""
    return share >= WORTH_TRYING and -0.5 * len(base.residual) * log(max(1.0 - share, 1e-300)) >= STRONG


def _of_the_start(problem: Problem, base: Fitted, start: Model) -> tuple[Array, Model] | None:
    """Zeros of the recordings beyond the first one's, and a model that leaves little beside them; None without one.

    A plant that begins anywhere may integrate to be at another place in each recording, and re-estimated with one zero
    for all it does: its zeros explain nothing then. Those beside the coefficients as given were never bent.
    """
    if not is_far_off(problem, base):
        return None
    experiments = [replace(e, offset=0.0, estimate_offset=False) for e in problem.experiments]
    kind = replace(problem.kind, offset=0.0, offset_free=False)
    own = replace(problem, experiments=experiments, kind=kind, own_zeros=True)
    try:
        found = kind.refit(own, replace(start, constants=kind.constants()))
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):  # it diverges from there
        return None
    if not _is_much(base, 1.0 - found.cost / max(base.cost, 1e-300)):
        return None
    simulated = replace(own, own_zeros=False).simulate(found.model)
    zeros = np.array([own.zero(output, index) for index, output in enumerate(simulated)])
    first = float(zeros[problem.fitted_runs[0]])
    model = replace(found.model, constants={**start.constants, OFFSET.name: first})
    return zeros - first, model


def zeros_beyond(problem: Problem, fitted: Fitted) -> tuple[Array, Array, float]:
    """Zeros of recordings beyond the first one's that a model leaves, and the share of what is left that they explain.

    Parameters
    ----------
    problem : Problem
        Of several recordings that are fitted.
    fitted : Fitted

    Returns
    -------
    ndarray, ndarray, shapes (R,), and float
        Zeros and their standard deviations, in units of y; zero for the first one.
    """
    _, *others = problem.fitted_runs
    run_of_row = problem.fitted([np.full(len(e.output), i) for i, e in enumerate(problem.experiments)])
    steps = problem.over_noise(np.column_stack([run_of_row == run for run in others]).astype(float))
    # One zero for all, coefficients, effects and initial states follow.
    following = np.column_stack([fitted.sensitivities, problem.over_noise(np.ones(len(run_of_row)))])
    beyond = steps - following @ np.linalg.lstsq(following, steps, rcond=None)[0]
    found = np.linalg.lstsq(beyond, fitted.residual, rcond=None)[0]
    rest = fitted.residual - beyond @ found
    variance = float(rest @ rest) / max(len(rest) - following.shape[1] - len(others), 1)
    values, deviations = np.zeros(len(problem.experiments)), np.zeros(len(problem.experiments))
    values[others] = found
    deviations[others] = np.sqrt(variance * np.diag(np.linalg.pinv(beyond.T @ beyond)))
    return values, deviations, 1.0 - float(rest @ rest) / max(fitted.cost, 1e-300)


@dataclass(frozen=True)
class CountedFromOwn:
    """A diagnosis of recordings that are counted from a zero each.

    Attributes
    ----------
    diagnosis : Diagnosis
    values, deviations : ndarray, shape (R,)
        By how much each recording reads more than the first one at the plant's zero, in units of y.
    moved : ndarray, shape (R,)
        By how much the readings were moved for the diagnosis.
    recorded : list of ndarray, shapes (N,)
        The readings as they were.
    watch : Watch
        What it left out.
    """

    diagnosis: Diagnosis
    values: Array
    deviations: Array
    moved: Array
    recorded: list[Array]
    watch: Watch

    @classmethod
    def of(
        cls, diagnosis: Diagnosis, improved: Fitted, moved: Array, recorded: list[Array], watch: Watch
    ) -> CountedFromOwn:
        """With the zeros that its improved model leaves, which its coefficients and effects make sure of."""
        together = replace(improved.problem, own_zeros=False)
        values, deviations, _ = zeros_beyond(together, evaluate(together, improved.model))
        return cls(diagnosis, moved + values, deviations, moved, recorded, watch)

    @property
    def tells_all(self) -> bool:
        """Whether zeros differ beside all that is found, and nothing but noise is left: no other search does better."""
        known = self.deviations > 0.0
        differ = bool(np.any(np.abs(self.values[known]) > CERTAIN * self.deviations[known]))
        return differ and self.diagnosis.verdict in TOLD and not self.diagnosis.structured

    def is_likelier(self, other: Diagnosis) -> bool:
        """Whether they are likelier than a diagnosis with one zero for all, by Bayes's criterion."""
        own, beside = self.diagnosis.conditions, other.conditions
        if own is None or beside is None or beside.noise <= 0.0 or own.noise <= 0.0:
            return False
        more = _numbers(self.diagnosis) + int(np.count_nonzero(self.deviations)) - _numbers(other)
        return 2.0 * own.rows * log(beside.noise / own.noise) > more * log(own.rows)

    def taken(self, watch: Watch) -> Diagnosis:
        """The diagnosis as the recordings read, with what it left out in the place of what another one did."""
        watch.set(self.watch.state())
        drawn = [self.diagnosis.signals, *self.diagnosis.further_signals]
        first, *further = map(_as_read, drawn, self.moved, self.recorded)
        return replace(
            self.diagnosis,
            signals=first,
            further_signals=further,
            # There is no one zero that suits them all.
            improved=replace(self.diagnosis.improved, offset="estimate", offset_deviation=None),
            warnings=[*self._sentences(), *self.diagnosis.warnings],
        )

    def _sentences(self) -> list[str]:
        return [
            f"recording {index + 1} reads {value:.4g} ± {deviation:.1g} y more than the first one at the plant's zero "
            "(the camera was moved, or the rig began elsewhere): each is counted from a zero of its own"
            for index, (value, deviation) in enumerate(zip(self.values, self.deviations, strict=True))
            if deviation > 0.0
        ]


def _numbers(diagnosis: Diagnosis) -> int:
    """How many numbers a diagnosis has estimated beside the plant's."""
    return sum(len(f.parameters) for f in diagnosis.findings) + sum(len(part.knots) for part in diagnosis.learned)


def _as_read(signals: Signals, zero: float, recorded: Array) -> Signals:
    """Signals as the recording reads."""
    simulated = {name: getattr(signals, name) + zero for name in ("nominal", "refitted", "improved")}
    return replace(signals, recorded=recorded, **simulated)
