"""The Python API that the commands call: ``identify``, ``select_order``, ``simulate``, ``diagnose`` and ``track``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.identification.result import Identification
from camid.loading import RecordingSource, SimulationSource, experiments_of, warnings_of
from camid.simulation import load_simulation

if TYPE_CHECKING:
    import os

    import pandas as pd

    from camid.diagnosis.result import Diagnosis
    from camid.identification.order_selection import OrderSelection
    from camid.tracking.result import Track

Array = NDArray[np.float64]


def identify(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    *,
    structure: tuple[int, int] | None = None,
    method: str = "srivc",
    progress: Callable[[str], None] | None = None,
) -> Identification:
    """Re-estimate the plant of a simulation from one or several recordings of the same rig.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
        Each has an initial state of its own, if it is estimated.
    simulation : path, mapping or Simulation
        Its transfer function gives the orders and one starting value; a mapping may hold a continuous-time
        python-control system with one input and one output as ``plant``. A known delay is the sensor's latency;
        coefficients with ``free: false`` keep their value.
    structure : (int, int), optional
        Numbers of poles and zeros; the transfer function of the simulation then counts for nothing. Needs an input.
    method : {"srivc", "output-error", "plain-srivc"}
        See :func:`camid.identification.estimate.estimate`.
    progress : callable, optional
        Called with a sentence about the step at hand.

    Raises
    ------
    InputError
        If recording and simulation do not fit together or the data are too few.
    """
    from camid.identified import identification_of

    return identification_of(recording, load_simulation(simulation), structure, method, progress)


def select_order(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    *,
    largest: int = 4,
    progress: Callable[[str], None] | None = None,
) -> OrderSelection:
    """Estimate plants of every order and choose the lowest that explains one or several recordings of a rig.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
    simulation : path, mapping or Simulation
        What is believed of input, sensor and initial state; its plant counts for nothing.
    largest : int
        Largest number of poles.
    progress : callable, optional
        Called with a sentence about the step at hand.

    Returns
    -------
    OrderSelection
        ``table`` of all candidates, and ``poles`` and ``zeros`` of the chosen one.

    Raises
    ------
    InputError
        If recording and simulation do not fit together, there is no input, or the data are too few.
    """
    from camid.identification.order_selection import select_order as run

    believed = load_simulation(simulation)
    if believed.input_column is None:
        raise InputError("a free decay says nothing of the zeros", where=believed.source, mend="record an input, too")
    if believed.effects:
        raise InputError(
            "order compares linear chains, and this simulation has effects",
            where=believed.effects[0].where,
            mend="remove the effects",
        )
    if believed.controller is not None:
        raise InputError(
            "order compares plants behind an input that nothing feeds back to, and this one has a controller",
            where=believed.source,
            mend="write the plant, and let identify or diagnose estimate it in its loop",
        )
    if largest < 1:
        raise InputError(f"the largest order is {largest}", mend="it takes at least one pole")
    recordings, experiments, _ = experiments_of(recording, believed, progress)
    try:
        selection = run(experiments, largest, progress=progress)
        return replace(selection, recording_warnings=warnings_of(recordings))
    except (ValueError, ArithmeticError) as error:
        raise InputError(str(error), where=recordings[0].source, mend="record longer, or check the units") from None


def simulate(recording: RecordingSource, simulation: SimulationSource) -> pd.DataFrame:
    """Run a simulation on the input of a recording.

    Parameters
    ----------
    recording : path or DataFrame
    simulation : path, mapping or Simulation
        Effects included. Those that change the noise alone (quantisation, outliers, …) leave the expected output as
        it is.

    Returns
    -------
    DataFrame
        One row a recorded row, in order and in SI units: the time column, ``simulated`` and, where it is recorded, the
        output column; ``experiment`` before them where a file holds several. ``attrs["warnings"]`` says what was done
        to the rows, if anything.

    Raises
    ------
    InputError
        If recording and simulation do not fit together, or the initial state is to be fitted and there is no output.
    """
    from camid.simulated import simulated_table

    return simulated_table(recording, load_simulation(simulation))


def diagnose(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    *,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Find, name and model what a simulation leaves out.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
        Of one rig. Of several the last one validates and the others are fitted, unless the simulation says which rows
        validate.
    simulation : path, mapping or Simulation
        What is believed of the rig: structure, nominal coefficients, declarations, effects that are known already.
    progress : callable, optional
        Called with a sentence about the step at hand.

    Returns
    -------
    Diagnosis
        :func:`camid.diagnosis.files.write_diagnosis` puts it into files.

    Raises
    ------
    InputError
        If recording and simulation do not fit together or the data are too few.
    """
    from camid.diagnosis.files import diagnose as run_diagnosis

    return run_diagnosis(recording, simulation, progress)


def track(
    video: str | os.PathLike[str],
    *,
    colour: str | None = None,
    bright: bool = False,
    dark: bool = False,
    region: tuple[int, int, int, int] | None = None,
    method: str = "grey-level",
    scale: float | None = None,
    unit: str | None = None,
    origin: tuple[float, float] = (0.0, 0.0),
    upwards: bool = False,
    frame_rate: float | None = None,
    start: float | None = None,
    end: float | None = None,
    longest_gap: int = 30,
    allow_truncated: bool = False,
    threads: int = 1,
    preview: str | os.PathLike[str] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Track:
    """Measure the positions of a marker in a video.

    Parameters
    ----------
    video : path
        A file that FFmpeg decodes, or a folder of PNG images with a number in their names.
    colour : str, optional
        The marker is of this hue: a CSS name or ``#rrggbb``.
    bright, dark : bool
        It is the brightest or the darkest thing. Without a choice it is what moves.
    region : (int, int, int, int), optional
        x, y of the upper left corner, width and height in px: where the marker is in the first frame.
    method : {"grey-level", "gradient"}
        Whose position ``x`` and ``y`` are. The grey-level centroid is the mean of the position over the exposure,
        which is what the camera of a simulation means; the gradient centroid is the paper's.
    scale : float, optional
        Units of length per pixel; with ``unit``.
    unit : str, optional
        Of length, e.g. ``m``.
    origin : (float, float)
        x, y in px of the point that becomes 0, 0; the centre of the upper left pixel by default.
    upwards : bool
        Whether y points up; in the image it points down.
    frame_rate : float, optional
        Frames per second, for what has no time stamps.
    start, end : float, optional
        Seconds: which part of the clip is used.
    longest_gap : int
        Frames in a row that may be without the marker.
    allow_truncated : bool
        Take what can be read of a file that ends in the middle.
    threads : int
        Threads that decode.
    preview : path, optional
        Where a picture of the result goes (PNG).
    progress : callable, optional
        Called with a sentence about the step at hand.

    Returns
    -------
    Track
        ``table`` is the recording.

    Raises
    ------
    InputError
        If the options contradict each other, the video cannot be read, or the marker is nowhere, one of several,
        lost, or leaves the image.
    """
    from pathlib import Path

    from camid.tracking.options import Options
    from camid.tracking.track import track_video

    options = Options(
        colour=colour,
        bright=bright,
        dark=dark,
        region=region,
        method=method,
        scale=scale,
        unit=unit,
        origin=origin,
        upwards=upwards,
        frame_rate=frame_rate,
        start=start,
        end=end,
        longest_gap=longest_gap,
        allow_truncated=allow_truncated,
        threads=threads,
    )
    return track_video(Path(video), options, preview=None if preview is None else Path(preview), progress=progress)
