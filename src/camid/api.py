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
from camid.recording import Recording
from camid.simulation import Simulation, load_simulation

if TYPE_CHECKING:
    import os

    import pandas as pd

    from camid.diagnosis.result import Diagnosis
    from camid.identification.estimate import Estimate
    from camid.identification.order_selection import OrderSelection
    from camid.identification.predictor import Experiment, Structure
    from camid.plant import TransferFunction
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
    from camid.identification.estimate import METHODS, estimate

    believed = load_simulation(simulation)
    if believed.effects:
        raise InputError(
            "identify re-estimates linear chains, and this simulation has effects",
            where=believed.effects[0].where,
            mend="camid diagnose re-estimates plant and effects together (improved.yaml)",
        )
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known", mend=f"it must be one of {', '.join(METHODS)}")
    wanted, nominal = _wanted(believed, structure)
    recordings, experiments, held_out = experiments_of(recording, believed, progress)
    unknowns = int(wanted.free.sum()) + wanted.order * sum(e.estimate_initial_state for e in experiments)
    available = int(sum(e.used.sum() for e in experiments))
    if available <= unknowns:
        raise InputError(
            f"{available} samples are fewer than needed for {unknowns} parameters",
            where=recordings[0].source,
            mend="record longer, or choose a lower order",
        )
    if not wanted.free.any():
        raise InputError("no coefficient is free", where=believed.source, mend="free one under plant.free")
    try:
        result = estimate(wanted, experiments, nominal=nominal, method=method, progress=progress)
        identification = _identification(believed, result, recordings, experiments, held_out)
        return _analysed(identification, wanted, experiments, progress)
    except (ValueError, ArithmeticError) as error:
        raise InputError(
            f"no estimate: {error}", where=recordings[0].source, mend="try another order, or check the units"
        ) from None


def _wanted(believed: Simulation, structure: tuple[int, int] | None) -> tuple[Structure, TransferFunction | None]:
    """What is looked for, and the plant to start from where one is believed."""
    from camid.identification.predictor import Structure

    if believed.input_column is None:
        if not believed.estimates_initial_state:
            raise InputError(
                "without input and at rest nothing moves",
                where=believed.source,
                mend="set initial_state: estimate for a free decay",
            )
        if structure is not None:
            raise InputError(
                "a free decay says nothing of the numerator, and an order alone gives it no value",
                where=believed.source,
                mend="leave the order out and write a transfer_function",
            )
    if structure is not None:
        poles, zeros = structure
        if poles < 1 or not 0 <= zeros <= poles:
            raise InputError(
                f"order {poles} {zeros} is improper",
                mend="it takes at least one pole and at most as many zeros as poles",
            )
        return Structure.of_order(poles, zeros), None
    monic = believed.plant.monic
    if monic.order == 0:
        raise InputError("the plant has no dynamics", where=believed.source, mend="give it at least one pole")
    # A free decay says nothing of the numerator: it keeps its believed value.
    free_numerator = believed.free_numerator & (believed.input_column is not None)
    return (
        Structure(np.array(monic.numerator), np.array(monic.denominator), free_numerator, believed.free_denominator),
        believed.plant,
    )


def _identification(
    believed: Simulation,
    result: Estimate,
    recordings: list[Recording],
    experiments: list[Experiment],
    held_out: list[NDArray[np.bool_]],
) -> Identification:
    from camid.plant import TransferFunction

    lead = believed.plant.denominator[0] if len(believed.plant.denominator) == result.plant.order + 1 else 1.0
    split = len(result.plant.numerator)
    deviations, covariance = abs(lead) * result.standard_deviations, np.square(lead) * result.covariance
    free_numerator, free_denominator = result.free[:split], np.concatenate([[False], result.free[split:]])
    if believed.input_column is None:  # the numerator was not fitted, but a recording with an input may fit it
        free_numerator = believed.free_numerator
    plant = TransferFunction(
        tuple(lead * b for b in result.plant.numerator), tuple(lead * a for a in result.plant.denominator)
    )
    model = replace(
        believed,
        plant=plant,
        exposure=experiments[0].acquisition.exposure if believed.sensor == "camera" else None,
        free_numerator=free_numerator,
        free_denominator=free_denominator,
        # Where the data leave a coefficient undetermined there is no accuracy to write down.
        standard_deviations={
            "numerator": [float(v) for v in deviations[:split]],
            "denominator": [0.0, *(float(v) for v in deviations[split:])],
        }
        if np.all(np.isfinite(deviations))
        else None,
        covariance=covariance.tolist() if np.all(np.isfinite(covariance)) else None,
    )

    def nrmse(rows: list[NDArray[np.bool_]]) -> float:
        residual = np.concatenate([r[k] for r, k in zip(result.residuals, rows, strict=True)])
        recorded = np.concatenate([e.output[k] for e, k in zip(experiments, rows, strict=True)])
        spread = float(np.std(recorded))
        return float(np.sqrt(np.mean(residual**2))) / spread if spread > 0.0 else float("inf")

    fitted = [e.used for e in experiments]
    return Identification(
        simulation=model,
        estimate=result,
        converged=result.converged,
        period=recordings[0].period,
        rows_fitted=int(sum(k.sum() for k in fitted)),
        nrmse=nrmse(fitted),
        nrmse_validation=nrmse(held_out) if any(k.any() for k in held_out) else None,
        acquisition=experiments[0].acquisition,
        recording_warnings=warnings_of(recordings),
    )


def _analysed(
    identification: Identification,
    wanted: Structure,
    experiments: list[Experiment],
    progress: Callable[[str], None] | None,
) -> Identification:
    """The identification with the tests of its residual and, where they contradict the declaration, with others."""
    from camid.identification.declarations import alternative_declarations
    from camid.identification.residual_analysis import analyse_residual

    plant = identification.estimate.plant
    try:
        analysis = analyse_residual(wanted, plant, experiments)
    except (ValueError, ArithmeticError):  # a method without safeguard ran away
        return identification
    alternatives = []
    if identification.converged and analysis is not None and analysis.contradicts:
        alternatives = alternative_declarations(wanted, plant, experiments, progress)
    return replace(identification, residual_analysis=analysis, alternatives=alternatives)


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
