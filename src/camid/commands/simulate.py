"""``camid.simulate``: what a simulation makes of the input of a recording, row by row."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.identification.loading import (
    RecordingSource,
    SimulationSource,
    acquisition_of,
    experiment_of,
    load_recordings,
    warnings_of,
)
from camid.recording.recording import Recording
from camid.recording.time_grid import spline
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    import pandas as pd

    from camid.engine.run import Chain
    from camid.identification.experiment import Experiment

Array = NDArray[np.float64]


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
    return _simulated_table(recording, load_simulation(simulation))


def _simulated_table(recording: RecordingSource, believed: Simulation) -> pd.DataFrame:
    """Table of what a simulation makes of every experiment in a recording."""
    import pandas as pd

    recordings = load_recordings(recording, believed, output_needed=believed.estimates_initial_state)
    added = {"simulated"}
    if believed.controller is not None:
        added.add("simulated_input")
    if len(recordings) > 1:
        added.add("experiment")
    for name in (believed.time_column, believed.output_column):
        if name in added:
            raise InputError(
                f"a recorded column is called '{name}' like the result",
                where=believed.source,
                hint="rename the column",
            )
    parts = []
    for one in recordings:
        control: Array | None = None
        if believed.effects or believed.pendulum is not None or believed.controller is not None:
            simulated, control = _run_by_engine(one, believed)
        else:
            simulated = _simulated(one, believed)
        if not np.all(np.isfinite(simulated)):
            raise InputError(
                "the simulated output exceeds every floating-point number",
                where=believed.source,
                hint="check the transfer function and the units of the input",
            )
        table: dict[str, Any] = {"experiment": one.experiment} if len(recordings) > 1 else {}
        # Where the file's times are irregular, the simulation ran on a grid: back to the recorded times.
        on_grid = one.recorded_time is one.time
        table |= {
            believed.time_column: one.recorded_time,
            "simulated": simulated if on_grid else spline(one.time, simulated, one.recorded_time),
        }
        if control is not None:  # it is held between the samples of the controller
            held = np.clip(np.searchsorted(one.time, one.recorded_time + 0.5 * one.period) - 1, 0, len(control) - 1)
            table["simulated_input"] = control if on_grid else control[held]
            table[str(believed.input_column)] = one.recorded_columns.get(
                str(believed.input_column), one.columns[str(believed.input_column)]
            )
        if believed.output_column in one.recorded_columns:
            table[believed.output_column] = one.recorded_columns[believed.output_column]
        parts.append(pd.DataFrame(table))
    result = parts[0] if len(parts) == 1 else pd.concat(parts, ignore_index=True)
    if said := warnings_of(recordings):
        result.attrs["warnings"] = list(said)
    return result


def _simulated(recording: Recording, simulation: Simulation) -> Array:
    from camid.chain.exact import sample
    from camid.identification.predictor import Predictor
    from camid.identification.structure import Structure

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
            hint="record longer, or set initial_state: zero",
        )


def _from_first_known(simulated: Array, experiment: Experiment) -> Array:
    """Frames exposed before the record saw an input that nobody wrote down: the first known value stands for them."""
    if experiment.estimate_initial_state and not experiment.free_motion_before_record:
        first = min(experiment.acquisition.window()[0], len(simulated) - 1)
        simulated[:first] = simulated[first]
    return simulated


def _run_by_engine(recording: Recording, simulation: Simulation) -> tuple[Array, Array | None]:
    """Output, and what a controller puts out, of a chain that is not linear behind a recorded input."""
    from camid.engine.run import move, observed, run

    try:
        chain, signal, experiment = _chain(recording, simulation)
        if chain.loop is not None:
            motion = move(chain, signal, recording.time)
            return observed(chain, motion, recording.time), motion.control
        output = run(chain, signal, recording.time)
    except InputError:
        raise
    except (ValueError, ArithmeticError) as error:
        where = simulation.effects[0].where if simulation.effects else simulation.source
        raise InputError(str(error), where=where, hint="see docs/effects.md") from None
    return (output if experiment is None else _from_first_known(output, experiment)), None


def _chain(recording: Recording, simulation: Simulation) -> tuple[Chain, Array, Experiment | None]:
    """The chain with its initial state, its input, and what the state was fitted to, if it was."""
    from camid.chain.controller import Loop
    from camid.effects.declared import effects_of
    from camid.effects.pendulum import PendulumPlant
    from camid.engine.run import Chain
    from camid.fitting.fit import fit
    from camid.fitting.from_simulation import model_of, problem_of
    from camid.fitting.refit import at_best_start
    from camid.identification.structure import Structure

    # The output is the expected one, and effects that change the noise alone do not change it.
    effects = tuple(e for e in effects_of(simulation) if not e.noise_like)
    if not simulation.estimates_initial_state:
        free = simulation.input_column is None
        signal = np.zeros(len(recording)) if free else recording.columns[str(simulation.input_column)]
        pendulum = () if simulation.pendulum is None else (PendulumPlant(rest=simulation.pendulum.rest),)
        controller = simulation.controller
        loop = None if controller is None else Loop(controller, recording.columns[controller.reference])
        acquisition = acquisition_of(recording, simulation)
        return Chain(simulation.plant, acquisition, (*pendulum, *effects), loop=loop), signal, None
    experiment = experiment_of(recording, simulation)
    structure = Structure.fixed(simulation.plant.monic)
    _refuse_few(experiment.used.sum(), structure.order, recording)
    problem = replace(problem_of(simulation, structure, [recording], [experiment]), rest_free=False, fixed_gain=None)
    start = at_best_start(problem, model_of(simulation, structure, effects))
    fitted = fit(problem, start, steps=40, fixed=len(effects))
    return problem.chain(fitted.model, 0), experiment.signal, experiment
