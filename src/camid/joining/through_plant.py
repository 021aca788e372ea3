"""The offset and the skew between two clocks where the drive's table holds the input and the clip the output alone.

The simulation says what links them: its plant is re-estimated together with the latency and the skew that the camera's
clock has against that of the drive. What the latency holds of the camera's own delay cannot be told from the offset.
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
from camid.joining.clocks import Clocks, first_alignment
from camid.joining.frames import fitted_to_frames
from camid.joining.resampling import Rows, joined_rows
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Rounds of alignment and estimate on rows, before the frames themselves are fitted; the first starts from the believed
# plant.
ROUNDS = 2
# Peaks of the correlation that are tried, and the correlation with which one is taken for the right one: a plant with
# wrong coefficients that swings long agrees with the motion at several swings.
MOST_PEAKS = 5
WELL_EXPLAINED = 0.95
# The frames are read this much later than they are taken for, in periods, so that the latency that is fitted is free to
# be shorter, too.
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
    clocks, followed = best
    return fitted_to_frames(followed, drive_time, drive, time, output, clocks, declared), followed


def _followed(
    believed: Simulation,
    drive_time: Array,
    drive: Mapping[str, Array],
    time: Array,
    output: Array,
    start: tuple[float, float, float],
    declared: float,
) -> tuple[Clocks, Simulation]:
    """Clocks and simulation after rounds of alignment and estimate on rows, from an offset and a skew."""
    clocks = Clocks(start[0], start[1], np.zeros((2, 2)), 0.0)
    for _ in range(ROUNDS):
        frames = clocks.to_drive(time)
        later = LATER * float(np.median(np.diff(frames)))
        rows = joined_rows(drive_time, drive, frames + later, {believed.output_column: output}, "t")
        fitted, believed = _fitted(believed, pd.DataFrame({**rows.columns, "t": rows.columns["t"] - rows.start}))
        clocks = _with(clocks, fitted, rows, later, declared)
    return clocks, believed


def _motion(believed: Simulation, drive_time: Array, drive: Mapping[str, Array]) -> Array:
    """Output of the believed plant for the drive's input, from rest; shape (M,)."""
    table = pd.DataFrame({"t": drive_time - drive_time[0], **drive})
    alone = replace(believed, sensor="instant", exposure=None, initial_state="zero", offset=0.0, bias=None)
    (recording,) = load_recordings(table, alone, output_needed=False)
    return np.asarray(np.interp(drive_time - drive_time[0], recording.time, simulated_output(alone, recording)[0]))


def _fitted(believed: Simulation, table: pd.DataFrame) -> tuple[Fitted, Simulation]:
    """Plant, latency and skew, and the simulation with the plant."""
    free = replace(believed, latency="estimate", skew="estimate", initial_state="estimate")
    recordings, experiments, _ = experiments_of([table], free, None)
    structure = structure_of(free)
    problem = problem_of(free, structure, recordings, experiments)
    nominal = model_of(problem, effects_of(free))
    fitted = problem.kind.refit(problem, problem.with_initial_states(nominal))
    found = problem.kind.written_back(free, structure, fitted)
    closed = {"latency": 0.0, "latency_deviation": None, "skew": 0.0, "skew_deviation": None}
    return fitted, replace(found, initial_state=believed.initial_state, **closed)  # type: ignore[arg-type]


def _with(clocks: Clocks, fitted: Fitted, rows: Rows, later: float, declared: float) -> Clocks:
    """The clocks after what a fit found of the rows that they made.

    A row at r, counted from the first one, holds the mean over an exposure that ended at (1 + skew) r − latency, and
    its frame has the latency that is declared. The frames were taken to be ``later`` seconds later than they are.
    """
    names, model = fitted.packing.names, fitted.model
    latency, skew = model.constants[LATENCY.name], model.constants[SKEW.name]
    # r = rate · (assumed time of the frame) + shift
    rate = 1.0 / (1.0 + rows.skew)
    moved = rate * (clocks.offset + later - rows.start + rows.latency)
    chosen = [names.index(LATENCY.name), names.index(SKEW.name)]
    # Of the offset at the clip's zero, and of the skew, by latency and skew.
    carried = np.array([[-1.0, moved], [0.0, rate * (1.0 + clocks.skew)]])
    covariance = carried @ fitted.covariance[np.ix_(chosen, chosen)] @ carried.T
    recorded = fitted.problem.output
    left = fitted.cost / max(float(np.var(recorded)) * len(recorded), 1e-300)
    return Clocks(
        rows.start + (1.0 + skew) * moved - latency + declared,
        (1.0 + skew) * rate * (1.0 + clocks.skew) - 1.0,
        covariance,
        float(np.sqrt(max(1.0 - left, 0.0))),
    )
