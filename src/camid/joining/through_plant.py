"""The offset and the skew between two clocks where the drive's table holds the input and the clip the output alone.

The simulation says what links them: its plant is re-estimated together with the latency and the skew that the camera's
clock has against that of the drive, for the input as the drive logged it and the exposures where they lie. What the
latency holds of the camera's own delay cannot be told from the offset.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.effects.declared import effects_of
from camid.errors import InputError
from camid.fitting.fit import Fitted
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.plants.constants import LATENCY, SKEW
from camid.fitting.simulated_output import simulated_output
from camid.identification.from_recordings import experiments_of, load_recordings
from camid.joining.clocks import Clocks, first_alignment, sandwich
from camid.joining.rows import JoinedRows, joined_rows
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Rounds of alignment and estimate, at least and at most; the first starts from the believed plant.
FEWEST_ROUNDS, MOST_ROUNDS = 2, 8
# Change of the time in the middle of the clip, in frames, that ends them, and latency that is at its bound of zero.
SETTLED, AT_BOUND = 0.02, 0.02
# Peaks of the correlation that are tried, and the correlation with which one is taken for the right one: a plant with
# wrong coefficients that swings long agrees with the motion at several swings.
MOST_PEAKS = 5
WELL_EXPLAINED = 0.95
# The frames are read this much later than they are taken for, in periods, so that the latency that is fitted is free to
# be shorter, too; and twice as much in each round after one whose latency ended at zero.
LATER = 1.0


def aligned_through_plant(
    simulation: Simulation,
    drive_time: Array,
    drive: Mapping[str, Array],
    time: Array,
    clip: Mapping[str, Array],
    progress: Callable[[str], None] | None,
) -> tuple[Clocks, Simulation]:
    """Clocks, and the simulation with its plant re-estimated.

    Parameters
    ----------
    simulation : Simulation
        Names the input among the columns of the drive and the output among those of the clip.
    drive_time : ndarray, shape (M,)
    drive : dict of str to ndarray of shape (M,)
    time : ndarray, shape (N,)
        Of the frames, on the clock of the clip.
    clip : dict of str to ndarray of shape (N,)
    progress : callable, optional

    Raises
    ------
    ValueError
        If the tables overlap nowhere, or nothing can be fitted.
    """
    declared = simulation.known_latency
    believed = replace(
        simulation,
        time_column="t",
        latency=0.0,
        latency_deviation=None,
        skew=0.0,
        skew_deviation=None,
        validation=None,
        reading=replace(simulation.reading, period=None, missing="leave-out", runs=()),
    )
    motion = _motion(believed, drive_time, drive)
    output = clip[simulation.output_column]
    best: tuple[Clocks, Simulation] | None = None
    for rank in range(MOST_PEAKS):
        if progress:
            progress("aligning the clocks")
        try:
            start = first_alignment(time, output, drive_time, motion, rank)
            found = _followed(believed, drive_time, drive, time, output, start, declared)
        except InputError:
            if best is None:
                raise
            break
        except (ValueError, ArithmeticError):
            continue
        if best is None or found[0].correlation > best[0].correlation:
            best = found
        if best[0].correlation >= WELL_EXPLAINED:
            break
    if best is None:
        raise ValueError("the motion of the clip follows the input of the drive nowhere")
    return best


def _followed(
    believed: Simulation,
    drive_time: Array,
    drive: Mapping[str, Array],
    time: Array,
    output: Array,
    start: tuple[float, float, float],
    declared: float,
) -> tuple[Clocks, Simulation]:
    """Clocks and simulation after rounds of alignment and estimate, from an offset and a skew."""
    clocks = Clocks(start[0], start[1], np.zeros((2, 2)), 0.0)
    frame, margin = float(np.median(np.diff(time))), LATER
    middle = 0.5 * (time[:1] + time[-1:])
    for done in range(1, MOST_ROUNDS + 1):
        taken = clocks.to_drive(middle)
        rows = joined_rows(
            drive_time, drive, clocks.to_drive(time) + margin * frame, {believed.output_column: output}, "t"
        )
        fitted, believed = _fitted(believed, rows)
        clocks = _with(clocks, fitted, margin * frame, declared)
        at_bound = fitted.model.constants[LATENCY.name] < AT_BOUND * frame
        moved = abs(float((clocks.to_drive(middle) - taken)[0]))
        if done >= FEWEST_ROUNDS and not at_bound and moved < SETTLED * frame:
            break
        margin = 2.0 * margin if at_bound else LATER
    return clocks, believed


def _motion(believed: Simulation, drive_time: Array, drive: Mapping[str, Array]) -> Array:
    """Output of the believed plant for the drive's input, from rest; shape (M,)."""
    table = pd.DataFrame({"t": drive_time - drive_time[0], **drive})
    alone = replace(believed, sensor="instant", exposure=None, initial_state="zero", offset=0.0, bias=None)
    (recording,) = load_recordings(table, alone, output_needed=False)
    return np.asarray(np.interp(drive_time - drive_time[0], recording.time, simulated_output(alone, recording)[0]))


def _fitted(believed: Simulation, rows: JoinedRows) -> tuple[Fitted, Simulation]:
    """Plant, latency and skew, fitted to the frames where they lie; and the simulation with the plant."""
    reading = replace(believed.reading, frame_time=rows.frame_time)
    free = replace(believed, reading=reading, latency="estimate", skew="estimate", initial_state="estimate")
    recordings, experiments, _ = experiments_of([pd.DataFrame(rows.columns)], free, None)
    structure = structure_of(free)
    problem = problem_of(free, structure, recordings, experiments)
    nominal = model_of(problem, effects_of(free))
    fitted = problem.kind.refit(problem, problem.with_initial_states(nominal))
    found = problem.kind.written_back(free, structure, fitted)
    closed = {"latency": 0.0, "latency_deviation": None, "skew": 0.0, "skew_deviation": None}
    return fitted, replace(found, initial_state=believed.initial_state, reading=believed.reading, **closed)  # type: ignore[arg-type]


def _with(clocks: Clocks, fitted: Fitted, later: float, declared: float) -> Clocks:
    """The clocks after what a fit found of the frames that they dated.

    A frame that was taken to be delivered at r has the mean over an exposure that ended at r + skew (r − r_0) −
    latency, with r_0 the first of them, and was delivered the declared latency after that. The frames were taken to be
    ``later`` seconds later than they are.
    """
    names, constants = fitted.packing.names, fitted.model.constants
    latency, skew = constants[LATENCY.name], constants[SKEW.name]
    time = fitted.problem.times[0]
    since = 0.5 * float(time[-1] - time[0])
    # How much later than taken a frame in the middle is, and the skew: they are all but independent.
    shift = skew * since - latency
    by_latency, by_skew = (fitted.sensitivities[:, names.index(c.name)] for c in (LATENCY, SKEW))
    others = np.delete(fitted.sensitivities, [names.index(c.name) for c in (LATENCY, SKEW)], axis=1)
    table = np.column_stack([-by_latency, by_skew + since * by_latency, others])
    covariance = sandwich(table, fitted.residual)[:2, :2]
    # Of the offset at the clip's zero, and of the skew.
    begin = clocks.offset + later - (float(time[0]) + since)
    carried = np.array([[1.0, begin], [0.0, 1.0 + clocks.skew]])
    recorded = fitted.problem.output
    left = fitted.cost / max(float(np.var(recorded)) * len(recorded), 1e-300)
    return Clocks(
        clocks.offset + later + shift + skew * begin + declared,
        (1.0 + skew) * (1.0 + clocks.skew) - 1.0,
        carried @ covariance @ carried.T,
        float(np.sqrt(max(1.0 - left, 0.0))),
    )
