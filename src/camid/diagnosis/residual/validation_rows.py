"""Which rows of the recordings judge, where the simulation does not say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

Array = NDArray[np.float64]
# Share of a recording that validates where the simulation does not say, and how much more of the mismatch than
# elsewhere that part may hold before another one is taken.
VALIDATION_SHARE = 0.2
CONCENTRATED_RATIO = 2.0
# Way beyond that of all other parts, as a share of the whole, from which a part of one that may go anywhere is no fair
# judge of them.
LARGEST_REACH = 0.05
# A part with a smaller share of the largest variance of the output is at rest.
AT_REST_SHARE = 0.002
# Rows of a running median, and the standard deviation that it leaves of white noise (order statistics of a Gaussian).
MEDIAN_ROWS, MEDIAN_DEVIATION = 5, 0.5356
# Rows that are needed for an unknown of the plant, and in any case: the tests for structure hold up to seventy
# functions of input, motion and output against the residual.
ROWS_PER_UNKNOWN = 5
FEWEST_ROWS = 100
# Rows that a delay may make those of what the input did before a recording that begins in motion, and that a clock that
# runs fast may make those of what it did after the end: one in so many, at most so many.
UNKNOWN_PAST, UNKNOWN_FUTURE, MOST_UNKNOWN = 50, 200, 50


def with_validation(
    problem: Problem, nominal: Model, held_out: list[NDArray[np.bool_]], *, last_judges: bool = False
) -> tuple[Problem, list[NDArray[np.bool_]], bool]:
    """The problem without the rows that validate, these rows, and whether they were chosen here.

    Of several recordings a part of each validates; with ``last_judges`` the whole of the last one, as it does in files
    that hold a record to estimate from and one to validate with.
    """
    if any(rows.any() for rows in held_out):
        return problem, held_out, False
    if last_judges:
        judging = _last_run(problem)
    else:
        refitted = problem.kind.refit(problem, replace(nominal, effects=())).model
        simulated = problem.simulate(refitted)
        integrates = problem.structure.plant(refitted.coefficients).denominator[-1] == 0.0
        judging = {
            r: _quiet_part(problem.experiments[r], problem.experiments[r].output - simulated[r], integrates)
            for r in problem.runs
        }
    validation = [e.used & judging[run] for e, run in zip(problem.experiments, problem.runs, strict=True)]
    used = [e.used & ~rows for e, rows in zip(problem.experiments, validation, strict=True)]
    return problem.with_used(used), validation, True


def without_unknown_input(
    experiments: Sequence[Experiment], held_out: Sequence[NDArray[np.bool_]], believed: Simulation
) -> tuple[list[Experiment], list[NDArray[np.bool_]]]:
    """Recordings without the rows of which a delay, or another clock, makes what was before the record or after it.

    What the input did then is unknown. Few rows would speak against every delay of a recording that begins in motion,
    and against every clock that runs fast, and loudly: all hypotheses are compared without them. The declared latency
    is left out already; a free decay has no input, and a controller's reference is not known to have been another.
    """
    if believed.input_column is None or believed.controller is not None:
        return list(experiments), list(held_out)
    known = []
    for experiment in experiments:
        rows = np.ones(len(experiment.used), bool)
        if believed.estimates_initial_state:
            rows[: experiment.acquisition.window()[0] + min(len(rows) // UNKNOWN_PAST, MOST_UNKNOWN)] = False
        rows[len(rows) - min(len(rows) // UNKNOWN_FUTURE, MOST_UNKNOWN) :] = False
        known.append(rows)
    return (
        [replace(e, used=e.used & rows) for e, rows in zip(experiments, known, strict=True)],
        [held & rows for held, rows in zip(held_out, known, strict=True)],
    )


def _last_run(problem: Problem) -> dict[int, NDArray[np.bool_]]:
    """Rows of each run, all of the last one, but for the first fifth where its initial state has to come from there."""
    judging = {r: np.zeros(len(problem.experiments[r].used), bool) for r in problem.runs}
    last = problem.runs[-1]
    judging[last][:] = True
    if problem.experiments[last].estimate_initial_state:
        judging[last][: len(judging[last]) // 5] = False
    return judging


def _quiet_part(experiment: Experiment, residual: Array, integrates: bool) -> NDArray[np.bool_]:
    """The last part of a recording that judges: another one where the rig rests or a single event makes the mismatch.

    Where the rig hardly moves in the last part (a free decay, the end of a chirp), it is the last one that does move.
    Where a plant that integrates, and may go anywhere, goes farther there than anywhere else, it is the last one that
    stays on the way of the others: a stop that is reached there alone would speak against all that is right before it,
    and nothing that is fitted would know of it. Where a single event makes most of the mismatch, it is that of those
    that move with the least.
    """
    parts = np.array_split(np.arange(len(residual)), round(1.0 / VALIDATION_SHARE))
    # Rows that are not fitted, as the first of a recording that begins in motion, may be far from the simulation.
    square = without_outliers(np.where(experiment.used, residual, 0.0)) ** 2
    energy = np.array([float(np.sum(square[p])) / max(int(np.count_nonzero(experiment.used[p])), 1) for p in parts])
    motion = np.array([float(np.var(experiment.output[p])) for p in parts])
    candidates = np.arange(1, len(parts))
    moving = _moving(motion, candidates)
    inside = moving[_reach(experiment.output, parts)[moving] <= LARGEST_REACH] if integrates else moving
    chosen = int((inside if len(inside) else moving)[-1])
    if energy[chosen] > CONCENTRATED_RATIO * float(np.mean(np.delete(energy, chosen))):
        # Beside a pendulum that has turned over all other parts would seem at rest.
        others = _moving(motion, np.delete(candidates, chosen - 1))
        quietest = int(others[np.argmin(energy[others])])
        chosen = quietest if energy[quietest] < energy[chosen] else chosen
    rows = np.zeros(len(residual), bool)
    rows[parts[chosen]] = True
    return rows


def _reach(output: Array, parts: Sequence[NDArray[np.intp]]) -> Array:
    """How far each part of a recording goes beyond all others, as a share of the way, shape (parts,)."""
    lowest, highest = (np.array([extreme(output[p]) for p in parts]) for extreme in (np.min, np.max))
    reach = [
        max(float(highest[i] - np.max(np.delete(highest, i))), float(np.min(np.delete(lowest, i)) - lowest[i]))
        for i in range(len(parts))
    ]
    return np.array(reach) / (float(np.ptp(output)) or 1.0)


def _moving(motion: Array, parts: NDArray[np.intp]) -> NDArray[np.intp]:
    """Those of some parts of a recording in which the rig does not rest beside the liveliest of them."""
    return parts[motion[parts] >= AT_REST_SHARE * float(np.max(motion[parts]))]


def without_outliers(residual: Array) -> Array:
    """A residual whose isolated values, which a sensor makes, are gone, and whose events, which last, are not.

    A running median of five rows, scaled so that white noise keeps its standard deviation.
    """
    # Loading scipy.ndimage for its running median alone would take longer than all else that is done here.
    rows = np.lib.stride_tricks.sliding_window_view(np.pad(residual, MEDIAN_ROWS // 2, mode="edge"), MEDIAN_ROWS)
    return np.asarray(np.median(rows, axis=-1)) / MEDIAN_DEVIATION


def refuse_too_short_to_diagnose(
    structure: Structure, experiments: list[Experiment], recordings: list[Recording]
) -> None:
    """Refuse recordings too short for the tests of structure to say anything."""
    unknowns = int(structure.free.sum()) + structure.order * sum(e.estimate_initial_state for e in experiments)
    rows = int(sum(e.used.sum() for e in experiments))
    needed = max(ROWS_PER_UNKNOWN * (unknowns + 1), FEWEST_ROWS)
    if rows < needed:
        raise InputError(
            f"{rows} samples are too few to diagnose a plant of {unknowns} unknowns",
            where=recordings[0].source,
            hint=f"record at least {needed} outside of the validation rows",
        )
