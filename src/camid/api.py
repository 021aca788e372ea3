"""The Python API that the commands call: ``identify``, ``select_order`` and ``simulate``."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.identification.result import Identification
from camid.recording import Recording, read_recording
from camid.simulation import Simulation, load_simulation

if TYPE_CHECKING:
    import pandas as pd

    from camid.chain import Acquisition
    from camid.identification.estimate import Estimate
    from camid.identification.order_selection import OrderSelection
    from camid.identification.predictor import Experiment, Structure
    from camid.plant import TransferFunction

Array = NDArray[np.float64]
RecordingSource = str | os.PathLike[str] | Any
SimulationSource = str | os.PathLike[str] | Mapping[str, Any] | Simulation


def load_recording(recording: RecordingSource, simulation: Simulation, *, output_needed: bool) -> Recording:
    """Columns that a simulation names, checked against each other."""
    roles = {
        "time": simulation.time_column,
        "input": simulation.input_column,
        "output": simulation.output_column,
    }
    for (one, first), (other, second) in combinations(roles.items(), 2):
        if first == second:
            raise InputError(
                f"{one} and {other} are the same column '{first}'", where=simulation.source, mend="name two columns"
            )
    named = [simulation.input_column, simulation.output_column if output_needed else None]
    required = [column for column in named if column is not None]
    optional = [] if output_needed else [simulation.output_column]
    return read_recording(recording, simulation.time_column, required, optional)


def _acquisition(recording: Recording, simulation: Simulation) -> Acquisition:
    acquisition = simulation.acquisition(recording.period, recording.period_uncertainty)
    duration = float(recording.time[-1] - recording.time[0])
    if acquisition.latency > duration:
        raise InputError(
            f"latency = {acquisition.latency:g} s is longer than {recording.source}, which lasts {duration:g} s",
            where=f"{simulation.source}, sensor",
            mend="give it in seconds",
        )
    return acquisition


def _experiment(recording: Recording, simulation: Simulation) -> Experiment:
    from camid.identification.predictor import Experiment

    acquisition = _acquisition(recording, simulation)
    count = len(recording)
    signal = np.zeros(count) if simulation.input_column is None else recording.columns[simulation.input_column]
    used = np.ones(count, bool)
    if simulation.estimates_initial_state and simulation.input_column is not None:
        # What the input did before the record is unknown, so frames exposed before its beginning say nothing.
        used[: acquisition.window()[0]] = False
    return Experiment(
        signal, recording.columns[simulation.output_column], acquisition, used, simulation.estimates_initial_state
    )


def _validation_rows(recording: Recording, simulation: Simulation) -> NDArray[np.bool_]:
    if simulation.validation is None:
        return np.zeros(len(recording), bool)
    start, end = simulation.validation
    rows = (recording.time >= start) & (recording.time <= end)
    if not rows.any():
        raise InputError(
            f"no row of the recording lies between {start:g} s and {end:g} s",
            where=f"{simulation.source}, validation",
            mend=f"the recording lasts from {recording.time[0]:g} s to {recording.time[-1]:g} s",
        )
    return rows


def _experiments(
    recording: RecordingSource | Sequence[RecordingSource],
    believed: Simulation,
    progress: Callable[[str], None] | None,
) -> tuple[list[Recording], list[Experiment], list[NDArray[np.bool_]]]:
    """Recordings, what is fitted of them, and their validation rows."""
    sources = recording if isinstance(recording, list | tuple) else [recording]
    if not sources:
        raise InputError("no recording is given", mend="name at least one")
    files = [os.path.realpath(source) for source in sources if isinstance(source, str | os.PathLike)]
    if len(set(files)) < len(files):
        raise InputError(
            "the same recording is named twice", where=str(sources[0]), mend="what it says would count double"
        )
    if progress:
        progress("reading the recording")
    recordings = [load_recording(source, believed, output_needed=True) for source in sources]
    experiments, held_out = [], []
    for one in recordings:
        experiment = _experiment(one, believed)
        rows = _validation_rows(one, believed)
        held_out.append(rows & experiment.used)
        experiments.append(replace(experiment, used=experiment.used & ~rows))
        _refuse_constant(one, believed)
    if believed.input_column is not None and not any(np.any(e.signal) for e in experiments):
        raise InputError(
            f"column '{believed.input_column}' is zero throughout",
            where=recordings[0].source,
            mend="for a free decay say input: null in the simulation",
        )
    return recordings, experiments, held_out


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
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known", mend=f"it must be one of {', '.join(METHODS)}")
    wanted, nominal = _wanted(believed, structure)
    recordings, experiments, held_out = _experiments(recording, believed, progress)
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


def _refuse_constant(recording: Recording, simulation: Simulation) -> None:
    if np.ptp(recording.columns[simulation.output_column]) == 0.0:
        raise InputError(
            f"column '{simulation.output_column}' is constant",
            where=recording.source,
            mend="there is nothing to identify in it",
        )
    column = simulation.input_column
    if column is not None and not np.any(recording.columns[column]) and not simulation.estimates_initial_state:
        raise InputError(
            f"column '{column}' is zero throughout",
            where=recording.source,
            mend="for a free decay say input: null and initial_state: estimate",
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
    if largest < 1:
        raise InputError(f"the largest order is {largest}", mend="it takes at least one pole")
    recordings, experiments, _ = _experiments(recording, believed, progress)
    try:
        return run(experiments, largest, progress=progress)
    except (ValueError, ArithmeticError) as error:
        raise InputError(str(error), where=recordings[0].source, mend="record longer, or check the units") from None


def simulate(recording: RecordingSource, simulation: SimulationSource) -> pd.DataFrame:
    """Run a simulation on the input of a recording.

    Parameters
    ----------
    recording : path or DataFrame
    simulation : path, mapping or Simulation

    Returns
    -------
    DataFrame
        One row a recorded row, in order: the time column, ``simulated`` and, where it is recorded, the output column.

    Raises
    ------
    InputError
        If recording and simulation do not fit together, or the initial state is to be fitted and there is no output.
    """
    import pandas as pd

    believed = load_simulation(simulation)
    loaded = load_recording(recording, believed, output_needed=believed.estimates_initial_state)
    if "simulated" in {believed.time_column, believed.output_column}:
        raise InputError(
            "a recorded column is called 'simulated' like the result", where=believed.source, mend="rename the column"
        )
    table = {believed.time_column: loaded.time}
    simulated = _simulated(loaded, believed)
    if not np.all(np.isfinite(simulated)):
        raise InputError(
            "the simulated output exceeds every floating-point number",
            where=believed.source,
            mend="check the transfer function and the units of the input",
        )
    table["simulated"] = simulated
    if believed.output_column in loaded.columns:
        table[believed.output_column] = loaded.columns[believed.output_column]
    return pd.DataFrame(table)


def _simulated(recording: Recording, simulation: Simulation) -> Array:
    from camid.chain import sample
    from camid.identification.predictor import Predictor, Structure

    if not simulation.estimates_initial_state or simulation.plant.order == 0:
        acquisition = _acquisition(recording, simulation)
        signal = (
            np.zeros(len(recording)) if simulation.input_column is None else recording.columns[simulation.input_column]
        )
        return sample(simulation.plant, signal, acquisition)
    monic = simulation.plant.monic
    structure = Structure(
        np.array(monic.numerator),
        np.array(monic.denominator),
        np.zeros(len(monic.numerator), bool),
        np.zeros(len(monic.denominator), bool),
    )
    experiment = _experiment(recording, simulation)
    if experiment.used.sum() <= structure.order:
        raise InputError(
            f"{experiment.used.sum()} samples are fewer than needed for {structure.order} initial states",
            where=recording.source,
            mend="record longer, or set initial_state: zero",
        )
    predictor = Predictor.around(structure, [experiment], np.array(monic.denominator))
    simulated = predictor.simulate(predictor.with_fitted_initial_states(structure.coefficients()))[0]
    experiment = predictor.experiments[0]
    if not experiment.free_motion_before_record:
        # Frames exposed before the record saw an input that nobody wrote down: the first known value stands for them.
        first = int(np.argmax(experiment.used))
        simulated[:first] = simulated[first]
    return simulated
