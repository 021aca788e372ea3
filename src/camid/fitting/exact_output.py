"""Output of a linear chain without effects, by the exact path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.exact import sample
from camid.errors import InputError
from camid.identification.experiment import Experiment
from camid.identification.from_recordings import acquisition_of, experiment_of
from camid.identification.predictor import Predictor
from camid.identification.structure import Structure
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

Array = NDArray[np.float64]


def exact_output(simulation: Simulation, recording: Recording, held_out: NDArray[np.bool_] | None = None) -> Array:
    """Samples of the sensor, shape (N,), with the initial state fitted where the simulation asks for that.

    Rows in ``held_out``, shape (N,), do not take part in that fit.

    Raises
    ------
    InputError
        If there are fewer samples than initial states.
    """
    if not simulation.is_fitted_to_output or simulation.plant.order == 0:
        acquisition = acquisition_of(recording, simulation)
        signal = (
            np.zeros(len(recording)) if simulation.input_column is None else recording.columns[simulation.input_column]
        )
        return sample(simulation.plant, signal, acquisition) + simulation.known_offset
    monic = simulation.plant.monic
    structure = Structure.fixed(monic)
    experiment = experiment_to_fit(recording, simulation, held_out)
    refuse_too_short_for_initial_state(experiment, structure, recording)
    predictor = Predictor.around(structure, [experiment], np.array(monic.denominator))
    simulated = predictor.simulate(predictor.with_fitted_initial_states(structure.coefficients()))[0]
    return from_first_known(simulated, predictor.experiments[0])


def experiment_to_fit(
    recording: Recording, simulation: Simulation, held_out: NDArray[np.bool_] | None = None
) -> Experiment:
    """A recording as a simulation run is fitted to it: with those constants unknown that are declared so.

    Rows in ``held_out``, shape (N,), are not fitted; InputError if there are no others.
    """
    offset, bias = simulation.offset == "estimate", simulation.bias == "estimate"
    found = replace(experiment_of(recording, simulation), estimate_offset=offset, estimate_bias=bias)
    return without_held_out(found, held_out, recording)


def without_held_out(experiment: Experiment, held_out: NDArray[np.bool_] | None, recording: Recording) -> Experiment:
    """The experiment without the rows in ``held_out``, shape (N,); InputError if no other is used."""
    if held_out is None:
        return experiment
    if not np.any(experiment.used & ~held_out):
        raise InputError(
            "all rows are held out, and none is left to fit the initial state to",
            where=recording.source,
            hint="hold out fewer",
        )
    return replace(experiment, used=experiment.used & ~held_out)


def refuse_too_short_for_initial_state(experiment: Experiment, structure: Structure, recording: Recording) -> None:
    """Refuse a recording that does not determine its initial states."""
    rows, states = experiment.used.sum(), structure.order
    if rows <= states:
        raise InputError(
            f"{rows} samples are fewer than needed for {states} initial states",
            where=recording.source,
            hint="record longer, or set initial_state: zero",
        )


def from_first_known(simulated: Array, experiment: Experiment) -> Array:
    """Frames exposed before the record saw an input that was not recorded: the first known value takes its place."""
    if experiment.estimate_initial_state and not experiment.free_motion_before_record:
        first = min(experiment.acquisition.window()[0], len(simulated) - 1)
        simulated[:first] = simulated[first]
    return simulated
