"""Fit a model to parts of the recordings that each begin with a state of their own, and to ever longer ones.

Where nothing holds a motion, a small error grows with the time, and the sum of squares over a whole recording has other
minima all over: a body that comes to rest a little earlier is pushed the other way. Over a short part it is smooth. The
states that the parts begin with are free numbers (Bock 1983, "Recent advances in parameter identification techniques
for O.D.E."; that this smooths the sum of squares: Ribeiro, Tiels, Umenberger, Schön & Aguirre 2020, Automatica 121,
109158).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from camid.chain.companion_form import time_scale
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.initial_motion import recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

# The least length of a part in time constants 1/ω of the plant, and the parts of all recordings at most.
LEAST_LENGTH, MOST_PARTS = 2.0, 32
# Evaluations for each length, and how often derivatives are computed anew in them.
STEPS, REFRESHES = 15, 4
# By what the number of parts is divided that each round begins with: where one is caught, another is not.
ROUNDS = (1, 2, 1)
# Variance of what is left of a whole recording over that of the parts, up to which a model follows as well to the end.
AS_GOOD = 1.2


def may_be_cut(problem: Problem) -> bool:
    """Whether parts of the recordings stand alone: none in a loop, with an input log or of several columns."""
    return all(
        problem.kind.loop(i) is None and e.input_log is None and e.seen is None and e.same_run_as is None
        for i, e in enumerate(problem.experiments)
    )


def in_parts(problem: Problem, parts: int) -> Problem:
    """The fitted span of each recording in parts, each a recording with an unknown initial state.

    Parameters
    ----------
    problem : Problem
        See :func:`may_be_cut`.
    parts : int
        Of the longest recording; of the others as many as have about that length.
    """
    ends = [int(np.flatnonzero(e.used)[-1]) + 1 if e.used.any() else 0 for e in problem.experiments]
    length = max(ends) / parts
    rows: list[tuple[int, slice]] = []
    for index, end in enumerate(ends):
        bounds = np.linspace(0, end, max(round(end / length), 1) + 1).round().astype(int).tolist()
        rows += [(index, slice(*pair)) for pair in pairwise(bounds)]
    rows = [(index, part) for index, part in rows if problem.experiments[index].used[part].any()]
    noise = problem.relative_noise
    experiments = [
        replace(e, signal=e.signal[part], output=e.output[part], used=e.used[part], estimate_initial_state=True)
        for e, part in ((problem.experiments[i], part) for i, part in rows)
    ]
    kind = problem.kind
    if problem.structure.denominator[-1] == 0.0:
        # Of a plant that integrates the zero is where its state says, and that is free.
        experiments = [replace(e, estimate_offset=False) for e in experiments]
        kind = kind.with_unknown(experiments)
    return replace(
        problem,
        experiments=experiments,
        times=[problem.times[i][part] for i, part in rows],
        kind=kind,
        steps=None,
        relative_noise=None if noise is None else tuple(noise[i][part] for i, part in rows),
    )


def shot_several_times(problem: Problem, start: Model) -> Model:
    """A model fitted to parts of the recordings, half as many each time; the best on the whole of what is left of it.

    Parameters
    ----------
    problem : Problem
        See :func:`may_be_cut`.
    start : Model
        Whose coefficients and effects are nearly right; returned where no fit leads to a better one.
    """
    best, least = start, evaluate(problem, start).cost
    most = _most_parts(problem, start)
    for parts in [max(most // divisor, 1) for divisor in ROUNDS]:
        found, cost, settled = _one_round(problem, best, parts)
        if cost < least:
            best, least = found, cost
        if settled:
            break
    return best


def on_shortest_parts(problem: Problem, starts: Sequence[Model]) -> list[Fitted]:
    """Models fitted to the shortest parts, where a sum of squares is smooth, the likeliest first.

    Parameters
    ----------
    problem : Problem
        See :func:`may_be_cut`.
    starts : sequence of Model
        One at least.
    """
    cut = in_parts(problem, max(_most_parts(problem, start) for start in starts))
    fitted = side_by_side(partial(_fitted_to_parts, cut), starts)
    closest = min(fitted, key=lambda each: each.cost)
    return sorted(fitted, key=lambda each: each.criterion_beyond(closest))


def _fitted_to_parts(cut: Problem, model: Model) -> Fitted:
    """A model fitted to parts, from states that they show."""
    begin = recorded_start(cut, replace(model, initial=()))
    return fit(cut, begin, steps=STEPS, refreshes=REFRESHES, finest=False)


def _one_round(problem: Problem, model: Model, parts: int) -> tuple[Model, float, bool]:
    """The best model on the whole of those that fits to ever longer parts end in, and its sum of squares there.

    Also whether it leaves there what it leaves of parts: then there is nothing more to be found.
    """
    settled, least = False, np.inf
    tried: list[tuple[float, int, Model]] = []
    while parts >= 1 and not settled:
        fitted = _fitted_to_parts(in_parts(problem, parts), model)
        model = fitted.model
        whole = evaluate(problem, recorded_start(problem, replace(model, initial=())))
        least = min(least, fitted.cost / len(fitted.residual))
        settled = whole.cost / len(whole.residual) <= AS_GOOD * least
        tried.append((whole.cost, len(tried), whole.model))
        parts //= 2
    cost, _, best = min(tried)
    return best, cost, settled


def _most_parts(problem: Problem, start: Model) -> int:
    """How many parts the longest recording is cut into first: a power of two, so that halves are parts again."""
    recordings = zip(problem.experiments, problem.times, strict=True)
    spans = [float(t[e.used][-1] - t[0]) for e, t in recordings if e.used.any()]
    own = time_scale((1.0, *start.coefficients[problem.structure.degree + 1 :]))
    least = LEAST_LENGTH * min(own, time_scale(problem.structure.denominator))
    most = MOST_PARTS * max(spans) / sum(spans)
    return int(2 ** np.floor(np.log2(np.clip(max(spans) / least, 1.0, max(most, 1.0)))))
