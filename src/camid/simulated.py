"""What a simulation makes of the input of a recording, row by row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.loading import RecordingSource, acquisition_of, experiment_of, load_recordings, warnings_of
from camid.recording import Recording
from camid.sampling import spline
from camid.simulation import Simulation

if TYPE_CHECKING:
    import pandas as pd

    from camid.identification.predictor import Experiment

Array = NDArray[np.float64]


def simulated_table(recording: RecordingSource, believed: Simulation) -> pd.DataFrame:
    """See :func:`camid.simulate`."""
    import pandas as pd

    recordings = load_recordings(recording, believed, output_needed=believed.estimates_initial_state)
    added = {"simulated", *(["experiment"] if len(recordings) > 1 else [])}
    for name in (believed.time_column, believed.output_column):
        if name in added:
            raise InputError(
                f"a recorded column is called '{name}' like one of the result",
                where=believed.source,
                mend="rename the column",
            )
    parts = []
    for one in recordings:
        simulated = _simulated(one, believed)
        if not np.all(np.isfinite(simulated)):
            raise InputError(
                "the simulated output exceeds every floating-point number",
                where=believed.source,
                mend="check the transfer function and the units of the input",
            )
        table: dict[str, Any] = {"experiment": one.experiment} if len(recordings) > 1 else {}
        # Where the file's times are irregular, the simulation ran on a grid: back to the recorded times.
        on_grid = one.recorded_time is one.time
        table |= {
            believed.time_column: one.recorded_time,
            "simulated": simulated if on_grid else spline(one.time, simulated, one.recorded_time),
        }
        if believed.output_column in one.recorded_columns:
            table[believed.output_column] = one.recorded_columns[believed.output_column]
        parts.append(pd.DataFrame(table))
    result = parts[0] if len(parts) == 1 else pd.concat(parts, ignore_index=True)
    if said := warnings_of(recordings):
        result.attrs["warnings"] = list(said)
    return result


def _simulated(recording: Recording, simulation: Simulation) -> Array:
    from camid.chain import sample
    from camid.identification.predictor import Predictor, Structure

    if simulation.effects:
        return _simulated_with_effects(recording, simulation)
    if not simulation.estimates_initial_state or simulation.plant.order == 0:
        acquisition = acquisition_of(recording, simulation)
        signal = (
            np.zeros(len(recording)) if simulation.input_column is None else recording.columns[simulation.input_column]
        )
        return sample(simulation.plant, signal, acquisition)
    monic = simulation.plant.monic
    structure = Structure.fixed(monic)
    experiment = experiment_of(recording, simulation)
    _refuse_few(experiment.used.sum(), structure.order, recording)
    predictor = Predictor.around(structure, [experiment], np.array(monic.denominator))
    simulated = predictor.simulate(predictor.with_fitted_initial_states(structure.coefficients()))[0]
    return _from_first_known(simulated, predictor.experiments[0])


def _refuse_few(rows: int, states: int, recording: Recording) -> None:
    if rows <= states:
        raise InputError(
            f"{rows} samples are fewer than needed for {states} initial states",
            where=recording.source,
            mend="record longer, or set initial_state: zero",
        )


def _from_first_known(simulated: Array, experiment: Experiment) -> Array:
    """Frames exposed before the record saw an input that nobody wrote down: the first known value stands for them."""
    if experiment.estimate_initial_state and not experiment.free_motion_before_record:
        first = min(experiment.acquisition.window()[0], len(simulated) - 1)
        simulated[:first] = simulated[first]
    return simulated


def _simulated_with_effects(recording: Recording, simulation: Simulation) -> Array:
    from camid.diagnosis.fit import at_best_start, fit
    from camid.diagnosis.problem import Model, Problem
    from camid.engine import Chain, run
    from camid.identification.predictor import Structure
    from camid.physics.declared import effects_of

    # The output is the expected one, and effects that change the noise alone do not change it.
    effects = tuple(e for e in effects_of(simulation) if not e.noise_like)
    try:
        if not simulation.estimates_initial_state:
            signal = (
                np.zeros(len(recording))
                if simulation.input_column is None
                else recording.columns[simulation.input_column]
            )
            return run(Chain(simulation.plant, acquisition_of(recording, simulation), effects), signal, recording.time)
        experiment = experiment_of(recording, simulation)
        structure = Structure.fixed(simulation.plant.monic)
        _refuse_few(experiment.used.sum(), structure.order, recording)
        problem = Problem(structure, [experiment], [recording.time])
        start = at_best_start(problem, Model(structure.coefficients(), effects))
        fitted = fit(problem, start, steps=40, fixed=len(effects))
        return _from_first_known(problem.simulate(fitted.model)[0], experiment)
    except InputError:
        raise
    except (ValueError, ArithmeticError) as error:
        raise InputError(str(error), where=simulation.effects[0].where, mend="see docs/effects.md") from None
