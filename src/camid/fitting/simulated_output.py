"""Output of a simulation for the input of a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import Effect
from camid.effects.declared import effects_of
from camid.engine.mechanics import Chain
from camid.errors import InputError
from camid.fitting.exact_output import (
    experiment_to_fit,
    from_first_known,
    refuse_too_short_for_initial_state,
    without_held_out,
)
from camid.fitting.fit import fit
from camid.fitting.from_simulation import kind_of, model_of, problem_of
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.kind import PlantKind
from camid.identification.experiment import Experiment
from camid.identification.from_recordings import acquisition_of, readings_of
from camid.identification.structure import Structure
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Largest number of evaluations in a fit of the initial state.
STEPS = 40


def simulated_output(
    simulation: Simulation, recording: Recording, held_out: NDArray[np.bool_] | None = None
) -> tuple[Array, Array | None]:
    """Samples of the sensor and, in a closed loop, what the controller puts out; shapes (N,).

    The output is the expected one: effects that change the noise alone leave it as it is. An initial state that is to
    be estimated is fitted to the recorded output, but not to the rows in ``held_out``, shape (N,).

    Raises
    ------
    InputError
        If the simulation cannot be run, or its initial state not be fitted.
    """
    refuse_unknown_clock(simulation)
    kind = kind_of(simulation, [recording])
    exact = None if simulation.effects else kind.simulated_exactly(simulation, recording, held_out)
    return _by_engine(kind, simulation, recording, held_out) if exact is None else (exact, None)


def refuse_unknown_clock(simulation: Simulation) -> None:
    """Refuse a latency or a skew that is still to be estimated.

    Raises
    ------
    InputError
        That says so.
    """
    for name, value in (("latency", simulation.latency), ("skew", simulation.skew)):
        if value == "estimate":
            column = simulation.reading.frame_time
            since = "" if column is None else f", counted from the times in sensor.time ('{column}')"
            raise InputError(
                f"the {name} is not known yet",
                where=f"{simulation.source}, sensor.{name}",
                hint="camid identify and camid diagnose estimate it: take the model that they write; or write a number"
                + (since if name == "latency" else ""),
            )


def simulated_readings(
    simulation: Simulation, recording: Recording, held_out: NDArray[np.bool_] | None = None
) -> dict[str, Array]:
    """Samples of several columns of a sensor, by their names; shapes (N,); see :func:`simulated_output`.

    Raises
    ------
    InputError
        If the simulation cannot be run, or its initial state not be fitted.
    """
    refuse_unknown_clock(simulation)
    effects = tuple(e for e in effects_of(simulation) if not e.noise_like)
    parts = readings_of(recording, simulation)
    experiments = [
        replace(
            without_held_out(e, held_out, part),
            same_run_as=None if i == 0 else 0,
            estimate_initial_state=e.estimate_initial_state and i == 0,
        )
        for i, (part, e) in enumerate(parts)
    ]
    structure = Structure.fixed(simulation.plant.monic)
    problem = problem_of(simulation, structure, [part for part, _ in parts], experiments).all_fixed()
    try:
        start = problem.with_initial_states(model_of(problem, effects))
        if simulation.estimates_initial_state:
            start = fit(problem, start, steps=STEPS, fixed=len(effects)).model
        outputs = [output / e.weight for output, e in zip(problem.simulate(start), experiments, strict=True)]
    except (ValueError, ArithmeticError) as error:
        where = simulation.effects[0].where if simulation.effects else simulation.source
        raise InputError(str(error), where=where, hint="check the values of plant and effects") from None
    return dict(zip(simulation.output_columns, outputs, strict=True))


def _by_engine(
    kind: PlantKind, simulation: Simulation, recording: Recording, held_out: NDArray[np.bool_] | None
) -> tuple[Array, Array | None]:
    try:
        effects = tuple(e for e in effects_of(simulation) if not e.noise_like)
        if simulation.is_fitted_to_output:
            chain, experiment = _with_fitted_state(simulation, recording, effects, held_out)
            output, control = kind.output_and_control(chain, experiment.signal, recording.time)
            return (from_first_known(output, experiment) if control is None else output), control
        chain, signal = _at_rest(kind, simulation, recording, effects)
        return kind.output_and_control(chain, signal, recording.time)
    except InputError:
        raise
    except (ValueError, ArithmeticError) as error:
        where = simulation.effects[0].where if simulation.effects else simulation.source
        raise InputError(str(error), where=where, hint="check the values of plant and effects") from None


def _at_rest(
    kind: PlantKind, simulation: Simulation, recording: Recording, effects: tuple[Effect, ...]
) -> tuple[Chain, Array]:
    """The chain at rest before the first sample, and its input."""
    free = simulation.input_column is None
    signal = np.zeros(len(recording)) if free else recording.columns[str(simulation.input_column)]
    model = Model(np.zeros(0), constants=kind.constants())
    chain = Chain(
        simulation.plant,
        acquisition_of(recording, simulation),
        (*kind.forces(model), *effects),
        loop=kind.loop(0),
        equations=kind.nonlinear(model),
        input_log=recording.logs.get(str(simulation.input_column)),
    )
    return chain, signal


def _with_fitted_state(
    simulation: Simulation,
    recording: Recording,
    effects: tuple[Effect, ...],
    held_out: NDArray[np.bool_] | None,
) -> tuple[Chain, Experiment]:
    """The chain with the initial state that fits the recorded output best, and what that was fitted to."""
    experiment = experiment_to_fit(recording, simulation, held_out)
    structure = Structure.fixed(simulation.plant.monic)
    refuse_too_short_for_initial_state(experiment, structure, recording)
    problem = problem_of(simulation, structure, [recording], [experiment]).all_fixed()
    start = problem.with_initial_states(model_of(problem, effects))
    fitted = fit(problem, start, steps=STEPS, fixed=len(effects))
    return problem.chain(fitted.model, 0), experiment
