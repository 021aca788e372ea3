"""Plant and clocks fitted to the frames themselves, with the input as the drive logged it.

Rows of a recording hold the mean of an input that changes within them, or frames that are interpolated, both of which
shift the motion by hundredths of a frame. Here the plant is simulated on the samples of the drive, and each exposure is
taken where the clocks say that it lies.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.effects.declared import effects_of
from camid.engine.run import move, seen
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.packing import Packing
from camid.fitting.problem import Problem
from camid.identification.from_recordings import experiments_of
from camid.joining.clocks import Clocks, sandwich
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Step of the differences that replace derivatives, in what a number is measured by: frames for the clocks.
DIFFERENCE = 1e-4
# Largest number of evaluations.
STEPS = 30
# Residual of a simulation that diverged, in standard deviations of the output.
RUNAWAY = 1e3


def fitted_to_frames(
    believed: Simulation,
    drive_time: Array,
    drive: Mapping[str, Array],
    time: Array,
    output: Array,
    clocks: Clocks,
    latency: float,
) -> Clocks:
    """The clocks of least squares.

    Parameters
    ----------
    believed : Simulation
        With coefficients that follow the motion, and no latency or skew.
    drive_time : ndarray, shape (M,)
    drive : dict of str to ndarray of shape (M,)
    time, output : ndarray, shape (N,)
        Of the frames, by the clock of the clip.
    clocks : Clocks
        To start from, within a part of a period of the plant.
    latency : float
        Seconds, as it is declared.

    Raises
    ------
    ValueError
        If the tables overlap nowhere, or the simulation diverges from the start.
    """
    from scipy.optimize import least_squares

    about = np.interp(drive_time, clocks.to_drive(time), output)
    problem = _on_drive(believed, drive_time, {**drive, believed.output_column: about})
    exposure = 0.0 if believed.sensor == "instant" else float(believed.exposure or np.median(np.diff(time)))
    rows = _inside(clocks.to_drive(time) - latency, exposure, drive_time)
    known, wanted = time[rows], output[rows]
    middle, length, frame = float(known.mean()), float(np.ptp(known)), float(np.median(np.diff(known)))
    at_middle, rate = float(clocks.to_drive(np.array([middle]))[0]), 1.0 + clocks.skew
    # The median of steps whose digits are rounded would be off by milliseconds at the end.
    period = float(drive_time[-1] - drive_time[0]) / (len(drive_time) - 1)
    start = problem.with_initial_states(model_of(problem, effects_of(believed)))
    packing = Packing.of(problem, start)
    worst = RUNAWAY * (float(np.std(wanted)) or 1.0)

    def error(vector: Array) -> Array:
        chain = problem.chain(packing.unpack(vector[2:]), 0)
        chain = replace(chain, acquisition=replace(chain.acquisition, period=period))
        delivered = at_middle + frame * vector[0] + (rate + frame * vector[1] / length) * (known - middle)
        motion = move(chain, problem.experiments[0].signal, problem.times[0])
        found = seen(chain, motion, delivered - latency - drive_time[0], exposure)
        return np.asarray(np.clip(np.nan_to_num(wanted - found, nan=worst), -worst, worst))

    def slopes(vector: Array) -> Array:
        columns, centre = [], error(vector)
        for i in range(len(vector)):
            moved = vector.copy()
            moved[i] += DIFFERENCE
            columns.append((error(moved) - centre) / DIFFERENCE)
        return np.column_stack(columns)

    begin = np.concatenate([[0.0, 0.0], np.clip(packing.pack(start), packing.lower, packing.upper)])
    free = np.full(2, np.inf)
    low, high = np.concatenate([-free, packing.lower]), np.concatenate([free, packing.upper])
    if not np.all(np.abs(error(begin)) < worst):
        raise ValueError("the plant of the simulation diverges for the input of the drive")
    found = least_squares(error, begin, jac=slopes, bounds=(low, high), x_scale="jac", max_nfev=STEPS)
    skew = rate + frame * found.x[1] / length - 1.0
    # Of the offset at the clip's zero and of the skew, by the time in the middle and what is gained over the clip.
    carried = frame * np.array([[1.0, -middle / length], [0.0, 1.0 / length]])
    covariance = carried @ sandwich(slopes(found.x), found.fun)[:2, :2] @ carried.T
    offset = at_middle + frame * found.x[0] - (1.0 + skew) * middle
    left = float(found.fun @ found.fun) / max(float(np.var(wanted)) * len(wanted), 1e-300)
    return Clocks(float(offset), float(skew), covariance, float(np.sqrt(max(1.0 - left, 0.0))))


def _on_drive(believed: Simulation, drive_time: Array, columns: Mapping[str, Array]) -> Problem:
    """The plant on the samples of the drive, from whose first one on it moves from an unknown state.

    The output among the columns is about that of the clip: initial states and units are taken from it.
    """
    table = pd.DataFrame({"t": drive_time - drive_time[0], **columns})
    instant = replace(believed, sensor="instant", exposure=None, initial_state="estimate", offset="estimate")
    recordings, experiments, _ = experiments_of([table], instant, None)
    return problem_of(instant, structure_of(instant), recordings, experiments)


def _inside(end: Array, exposure: float, drive_time: Array) -> NDArray[np.bool_]:
    """Which exposures lie within the log of the drive, with a frame to spare for the clocks to move."""
    frame = float(np.median(np.diff(end)))
    return np.asarray((end - exposure > drive_time[0] + frame) & (end < drive_time[-1] - frame))
