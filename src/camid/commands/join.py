"""``camid.join``: a clip and the log of a drive, on two clocks, become one recording."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.effects.own_effects import EffectSource, own_effects
from camid.errors import InputError
from camid.identification.from_recordings import SimulationSource
from camid.joining.clocks import LEAST_CORRELATION, USUAL_SKEW, Clocks, CommonSignal, aligned, first_alignment
from camid.joining.rows import joined_rows
from camid.joining.tables import TimedTable, timed_table
from camid.joining.through_plant import WELL_EXPLAINED, aligned_through_plant
from camid.linear_algebra_threads import one_blas_thread
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation
from camid.writing import without_infinities

Array = NDArray[np.float64]
PathLike = str | os.PathLike[str]

# Below this the alignment through a plant is none.
LEAST_EXPLAINED = 0.5
# Columns that are named have to agree at least so well.
LEAST_FOLLOWED = 0.5
# Frames are dated this much later than they are taken for, in periods, so that a latency that is fitted is free to be
# shorter, too.
LATER = 0.5
# Columns of a clip that are no motion.
ACCURACIES = ("_std", "quality", "repeated")


@dataclass(frozen=True)
class Joined:
    """What ``camid.join`` returns.

    Attributes
    ----------
    table : DataFrame
        The recording: time of the drive in seconds, the columns of the drive, the times of the frames on its clock, the
        columns of the clip.
    clocks : Clocks
        Offset and skew with their covariance.
    method : str
        What they were estimated from, in words.
    period : float
        Seconds between rows.
    frame_time : str
        Column with the times of the frames; rows without a frame are blank there.
    latency : float
        Seconds by which those times are later than the time stamps on the clock of the drive, so that a latency that is
        estimated is free to be shorter, too.
    frames : int
    simulation : Simulation or None
        That which was given, with the times of the frames, and latency and skew left open.
    remarks : tuple of str
    """

    table: pd.DataFrame
    clocks: Clocks
    method: str
    period: float
    frame_time: str
    latency: float
    frames: int
    simulation: Simulation | None
    remarks: tuple[str, ...]

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        clocks = self.clocks
        content = {
            "schema": 1,
            "method": self.method,
            "offset": clocks.offset,
            "offset_standard_deviation": clocks.offset_deviation,
            "skew": clocks.skew,
            "skew_standard_deviation": clocks.skew_deviation,
            "covariance": clocks.covariance.tolist(),
            "correlation": clocks.correlation,
            "rows": len(self.table),
            "period": self.period,
            "frames": self.frames,
            "frame_time": self.frame_time,
            "latency": self.latency,
            "remarks": list(self.remarks),
        }
        return {key: without_infinities(value) for key, value in content.items()}


@one_blas_thread()
def join(
    clip: PathLike,
    drive: PathLike,
    *,
    simulation: SimulationSource | None = None,
    match: tuple[str, str] | None = None,
    exposure: float | None = None,
    clip_time: str | None = None,
    drive_time: str | None = None,
    progress: Callable[[str], None] | None = None,
    effects: Sequence[EffectSource] | EffectSource = (),
) -> Joined:
    """Bring the table of a clip and that of a drive onto one clock.

    Parameters
    ----------
    clip, drive : path
        Tables with a time column each, in seconds of clocks of their own.
    simulation : path, mapping or Simulation, optional
        Says how the input in the drive's table leads to the output in the clip's: the clocks are then aligned through
        its plant, which is re-estimated on the way.
    match : (str, str), optional
        Column of the clip and column of the drive that hold the same motion, flash or step; where neither this nor a
        simulation is given, the pair that agrees best is taken.
    exposure : float, optional
        Seconds of the camera's exposure, over which what is matched is averaged.
    clip_time, drive_time : str, optional
        Time columns, where they are not recognised.
    progress : callable, optional
        Called with a sentence about the current step.
    effects : sequence of path or subclass of Effect, optional
        Effects of your own that the simulation may name. A file is Python, and is run.

    Raises
    ------
    InputError
        If a table cannot be read, or nothing that both hold aligns them.
    """
    if simulation is not None and match is not None:
        raise InputError("a simulation and two columns to match are given", hint="keep one of them")
    if exposure is not None and not 0.0 <= exposure < float("inf"):
        raise InputError(f"--exposure {exposure:g}", hint="it takes a number of seconds")
    seen, logged = timed_table(Path(clip), clip_time), timed_table(Path(drive), drive_time, whole=True)
    believed = None if simulation is None else load_simulation(simulation)
    # Times as large as those of a computer's clock have few digits left for microseconds.
    first, first_drive = float(seen.time[0]), float(logged.time[0])
    seen, logged = replace(seen, time=seen.time - first), replace(logged, time=logged.time - first_drive)
    try:
        if believed is not None:
            with own_effects(effects):
                clocks, method = _through_plant(believed, seen, logged, progress)
        else:
            clocks, method = _through_signal(seen, logged, match, exposure, progress)
        common = [name for name in seen.columns if name in logged.columns or name == logged.time_column]
        clip_columns = {f"{n}_clip" if n in common else n: values for n, values in seen.columns.items()}
        later = LATER * float(np.median(np.diff(seen.time)))
        delivered = clocks.to_drive(seen.time) + later
        rows = joined_rows(logged.time, logged.columns, delivered, clip_columns, logged.time_column)
    except InputError:
        raise
    except (ValueError, ArithmeticError) as error:
        raise InputError(
            str(error), where=seen.source, hint="check that both tables are of one run, and what is matched"
        ) from None
    remarks = rows.remarks
    if believed is not None:
        blank = bool(np.any(~np.isfinite(seen.column(believed.output_column))))
        missing = "leave-out" if blank else believed.reading.missing
        reading = replace(believed.reading, frame_time=rows.frame_time, missing=missing)
        believed = replace(
            believed, time_column=logged.time_column, latency="estimate", skew="estimate", reading=reading
        )
        if clocks.correlation < WELL_EXPLAINED:
            share = f"{100.0 * clocks.correlation**2:.0f} % of the motion"
            remarks = (f"the plant explains {share}: is the offset that of another swing? check the plant", *remarks)
    else:
        assumed = "the exposure is taken for zero; if it is not, the offset is off by half of it: --exposure"
        remarks = (*_doubts(clocks), *([assumed] if exposure is None else []), *remarks)
    for column in (logged.time_column, rows.frame_time):
        rows.columns[column] = rows.columns[column] + first_drive
    clocks = clocks.counted_from(first, first_drive)
    table = pd.DataFrame(rows.columns)
    return Joined(table, clocks, method, rows.period, rows.frame_time, later, rows.frames, believed, remarks)


def _through_plant(
    believed: Simulation, seen: TimedTable, logged: TimedTable, progress: Callable[[str], None] | None
) -> tuple[Clocks, str]:
    """Clocks through the plant of a simulation."""
    if believed.input_column is None:
        raise InputError("a free decay has no input to align", where=believed.source, hint="match two columns")
    if believed.controller is not None or believed.observer is not None:
        raise InputError("a closed loop does not show the clocks", where=believed.source, hint="match two columns")
    for table, column in ((logged, believed.input_column), (seen, believed.output_column)):
        table.column(column)
    known = np.isfinite(seen.column(believed.output_column))
    driven = {name: logged.column(name) for name in (believed.input_column, *believed.reading.added)}
    output = {believed.output_column: seen.column(believed.output_column)[known]}
    clocks, _ = aligned_through_plant(believed, logged.time, driven, seen.time[known], output, progress)
    if clocks.correlation < LEAST_EXPLAINED or not np.all(np.isfinite(clocks.covariance)):
        raise ValueError(
            f"the plant of the simulation does not lead from '{believed.input_column}' to '{believed.output_column}': "
            f"it explains {100.0 * clocks.correlation**2:.0f} % of the motion"
        )
    return clocks, f"the motion of {believed.output_column} after {believed.input_column}, through the plant"


def _through_signal(
    seen: TimedTable,
    logged: TimedTable,
    match: tuple[str, str] | None,
    exposure: float | None,
    progress: Callable[[str], None] | None,
) -> tuple[Clocks, str]:
    """Clocks from a signal that both tables hold."""
    if progress:
        progress("aligning the clocks")
    pair = match or _best_pair(seen, logged)
    values, other = seen.column(pair[0]), logged.column(pair[1])
    known, other_known = np.isfinite(values), np.isfinite(other)
    time, other_time = seen.time[known], logged.time[other_known]
    offset, skew, correlation = first_alignment(time, values[known], other_time, other[other_known])
    if match is None and correlation < LEAST_CORRELATION:
        raise ValueError(
            f"no column of the clip follows one of the drive: the nearest are '{pair[0]}' and '{pair[1]}' with a "
            f"correlation of {correlation:.2f} (name them with --match, or give a --simulation)"
        )
    frame = float(np.median(np.diff(time)))
    signal = CommonSignal(other_time, other[other_known], exposure or 0.0, frame)
    if len(signal.edges) and exposure is None:  # a frame that an edge falls into says where in it
        signal = CommonSignal(other_time, other[other_known], frame, frame)
    clocks = aligned(time, values[known], signal, (offset, skew))
    # What is not the same quantity agrees by chance, and best where the clocks run apart as no clocks do.
    apart = _runs_apart(clocks)
    if clocks.correlation < (LEAST_CORRELATION if apart else LEAST_FOLLOWED):
        raise ValueError(
            f"'{pair[0]}' of the clip does not follow '{pair[1]}' of the drive: their correlation is "
            f"{clocks.correlation:.2f}{f' with a skew of {1e6 * clocks.skew:.0f}·10⁻⁶' if apart else ''}"
        )
    return clocks, f"'{pair[0]}' of the clip and '{pair[1]}' of the drive"


def _runs_apart(clocks: Clocks) -> bool:
    """Whether the skew is beyond that of clocks in general, for certain."""
    return abs(clocks.skew) > USUAL_SKEW + 2.0 * clocks.skew_deviation


def _doubts(clocks: Clocks) -> tuple[str, ...]:
    """What speaks against two columns being the same quantity, a sentence each."""
    doubts = []
    if clocks.correlation < LEAST_CORRELATION:
        doubts.append(
            f"the correlation of what is matched is {clocks.correlation:.2f}: is it the same quantity? if not, "
            "such as a position and a command, offset and skew are more wrong than they say; --simulation joins those"
        )
    if _runs_apart(clocks):
        usual = f"{1e6 * USUAL_SKEW:.0f}·10⁻⁶"
        doubts.append(
            f"the skew is {1e6 * clocks.skew:.0f}·10⁻⁶, and clocks hardly run apart by more than {usual}: "
            "is what is matched the same quantity, and are both times in seconds?"
        )
    return tuple(doubts)


def _best_pair(seen: TimedTable, logged: TimedTable) -> tuple[str, str]:
    """The columns that agree best at some lag."""
    best, found = -1.0, None
    for name, values in seen.columns.items():
        if name.endswith(ACCURACIES) or not np.all(np.isfinite(values)) or float(np.ptp(values)) == 0.0:
            continue
        for other, logged_values in logged.columns.items():
            if not np.all(np.isfinite(logged_values)) or float(np.ptp(logged_values)) == 0.0:
                continue
            agreement = first_alignment(seen.time, values, logged.time, logged_values)[2]
            if agreement > best:
                best, found = agreement, (name, other)
    if found is None:
        raise ValueError("no column changes in both tables")
    return found
