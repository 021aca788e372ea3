"""What an experiment is to tell apart: simulations that run with any input, and what is known of them already."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import time_scale
from camid.diagnosis.remaining_hypotheses import stable_names
from camid.effects.base import Effect
from camid.effects.declared import effects_of
from camid.engine.mechanics import companion_block
from camid.errors import InputError
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.unknown_constants import with_unknown_constants
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Rows of the recording that a problem is made with, before it gets those of an experiment.
TEMPLATE_ROWS = 8
# Steps of the integrator in a frame that a row of a simulation stands for where costs are counted in rows.
STEPS_OF_A_ROW = 3.0
# The question of simulations that are held against each other.
GIVEN = "given"


@dataclass(frozen=True)
class Played:
    """An experiment.

    Attributes
    ----------
    signal : ndarray, shape (N,)
        Input, as the simulation takes it.
    period : float
        Seconds.
    exposure : float or None
        Seconds; None: as the simulation declares.
    position : float or None
        From which the rig is released at rest, in units of the output from the plant's zero; None: where it rests.
    """

    signal: Array
    period: float
    exposure: float | None = None
    position: float | None = None


@dataclass(frozen=True)
class Hypothesis:
    """A simulation that may be right.

    Attributes
    ----------
    identifier : str
        Empty for the simulation without the effect in question.
    weight : float
        Before the experiment.
    question : str
        Effect of the diagnosis that it is a name for: only names for the same one exclude each other.
    simulation : Simulation
    problem : Problem
        Of a few rows without motion; :meth:`at` has those of an experiment.
    model : Model
    known : dict of str to int
        Places of the parameters in ``information``.
    information : ndarray, shape (p, p)
        Fisher information that earlier recordings hold.
    criterion, misfit : float
        By how much its criterion and its sum of squares (in variances of the noise) exceed those of the likeliest.
    variant : bool
        Whether it is a name with other values than those that fit the earlier recordings best; they are then known
        around these values: ``information`` is of them, and
    slope : ndarray, shape (p,), optional
        half of the derivative of the sum of squares,
    beyond : float
        by how much that exceeds the name's own,
    held : frozenset of str
        parameters that keep their values.
    """

    identifier: str
    weight: float
    question: str
    simulation: Simulation
    problem: Problem
    model: Model
    known: dict[str, int]
    information: Array
    criterion: float = 0.0
    misfit: float = 0.0
    variant: bool = False
    slope: Array | None = None
    beyond: float = 0.0
    held: frozenset[str] = frozenset()

    @property
    def effect(self) -> Effect | None:
        """The effect of its name, with its parameters; None where it has none."""
        return next((e for e in self.model.effects if e.identifier == self.identifier), None)

    @property
    def rival_only(self) -> bool:
        """Whether it is no name of the diagnosis, and only held against those."""
        return bool(self.identifier) and self.weight <= 0.0

    @property
    def is_name(self) -> bool:
        """Whether it may be right, and has its own values."""
        return bool(self.identifier) and not self.variant and not self.rival_only

    @property
    def count(self) -> int:
        """How many parameters are fitted."""
        return len(self.known) or len(Packing.of(self.problem, self.model).names)

    @property
    def structure(self) -> tuple[object, ...]:
        """All that says which law it is, without the values of what is fitted."""
        problem, model = self.problem, self.model
        free = problem.structure.free
        fixed = [float(c) for c, is_free in zip(model.coefficients, free, strict=False) if not is_free]
        names = stable_names(Packing.of(problem, model).names, model.effects)
        choices = [
            (e.identifier, *(e.values[p.name] for p in e.parameters if p.choices or p.sequence or p.is_name))
            for e in model.effects
        ]
        return type(problem.kind), tuple(names), tuple(fixed), str(choices), str(problem.acquisition)

    def at(self, played: Played) -> tuple[Problem, Model]:
        """What is fitted of an experiment, all of its rows, and the model that it starts from."""
        rows = len(played.signal)
        believed = self.simulation
        exposed = believed if played.exposure is None else replace(believed, exposure=played.exposure)
        acquisition = exposed.acquisition(played.period)
        time = played.period * np.arange(rows, dtype=np.float64)
        used = np.ones(rows, bool)
        model = self.model
        if played.position is not None:
            used[: acquisition.window()[0]] = False
            model = replace(model, initial=(self._released(played.position),))
        experiment = replace(
            self.problem.experiments[0],
            signal=played.signal + self.added,
            output=np.zeros(rows),
            used=used,
            acquisition=acquisition,
            estimate_initial_state=played.position is not None,
            input_log=None,  # what is played changes with the frames
        )
        # What a simulation leaves open of the clocks is as it was found.
        model = replace(model, constants={**self.problem.kind.constants(), **model.constants})
        return replace(self.problem, experiments=[experiment], times=[time]), model

    def effort(self, played: Played) -> float:
        """Rows that the simulation of one row costs, in those of a plant with friction."""
        problem, model = self.at(played)
        (steps,) = problem.pinned(model, finest=False).steps or (1,)
        return max(steps / STEPS_OF_A_ROW, 1.0)

    @property
    def added(self) -> float:
        """A bias of the input that is declared and not estimated."""
        return 0.0 if self.problem.kind.bias_free else self.simulation.known_bias

    def _released(self, position: float) -> Array:
        """Companion state of a plant of second order at rest at a position."""
        plant = self.problem.structure.plant(self.model.coefficients)
        unit = time_scale(plant.monic.denominator)
        matrix, row, _ = companion_block(plant, unit)
        return np.asarray(np.linalg.solve(np.vstack([row, row @ matrix / unit]), np.array([position, 0.0])))

    def prior(self, packing: Packing) -> Array:
        """Information of earlier recordings on packed parameters in their own units, shape (p, p)."""
        names = stable_names(packing.names, packing.template.effects)
        found, rows = self._places(names)
        result = np.zeros((len(names), len(names)))
        if found:
            result[np.ix_(found, found)] = self.information[np.ix_(rows, rows)]
        return result

    def pull(self, packing: Packing) -> Array:
        """Half of the derivative of the earlier recordings' sum of squares by the same parameters, shape (p,)."""
        names = stable_names(packing.names, packing.template.effects)
        found, rows = self._places(names)
        result = np.zeros(len(names))
        if self.slope is not None and found:
            result[found] = self.slope[rows]
        return result

    def free(self, packing: Packing) -> NDArray[np.bool_]:
        """Which packed parameters may be fitted, shape (p,)."""
        return np.array([n not in self.held for n in stable_names(packing.names, packing.template.effects)], bool)

    def _places(self, names: list[str]) -> tuple[list[int], list[int]]:
        """Parameters that earlier recordings know and that are free: their places among names, and in what is known."""
        found = [i for i, name in enumerate(names) if name in self.known and name not in self.held]
        return found, [self.known[names[i]] for i in found]


def hypothesis_of(
    simulation: Simulation,
    identifier: str,
    period: float,
    *,
    weight: float = 1.0,
    question: str = "",
    parameters: list[str] | None = None,
    information: Array | None = None,
    criterion: float = 0.0,
    misfit: float = 0.0,
) -> Hypothesis:
    """A hypothesis from its simulation.

    Raises
    ------
    InputError
        If no input can be designed: for a closed loop, a plant that an observer pulls, one that nothing drives, or one
        that several columns see.
    """
    if simulation.controller is not None:
        raise InputError(
            "a closed loop is not designed for",
            where=simulation.source,
            hint="open the loop: an experiment is an input of the plant",
        )
    if simulation.observer is not None:
        raise InputError(
            "an input is designed for a plant that it drives, and this one follows a recording alone",
            where=simulation.source,
            hint="without the controller that held it in the recording it runs away; play other references to that one",
        )
    if simulation.input_column is None:
        raise InputError(
            "nothing drives this plant, so no input can be designed",
            where=simulation.source,
            hint="release it from other positions",
        )
    if simulation.output_columns:
        raise InputError(
            "several columns of a sensor are not designed for",
            where=simulation.source,
            hint="name the one that tells most",
        )
    # What depends on the time of one recording is not there in the next; but a diagnosis holds the name in question
    # against both recordings with the same values.
    effects = tuple(
        e for e in effects_of(simulation) if not e.noise_like and (e.identifier == identifier or not e.of_one_recording)
    )
    simulation = replace(simulation, initial_state="zero", remainder=None)
    problem = _template(simulation, period)
    model = replace(model_of(problem, effects), initial=(None,))
    names = parameters or []
    return Hypothesis(
        identifier,
        weight,
        question,
        simulation,
        problem,
        model,
        {name: i for i, name in enumerate(names)},
        np.zeros((len(names), len(names))) if information is None else np.asarray(information, float),
        criterion,
        misfit,
    )


def _template(simulation: Simulation, period: float) -> Problem:
    """The problem of a few rows: what was estimated of the sensor and the input is estimated again."""
    signal = np.resize([1.0, -1.0], TEMPLATE_ROWS)
    time = period * np.arange(TEMPLATE_ROWS, dtype=np.float64)
    columns = {str(simulation.input_column): signal, simulation.output_column: np.linspace(0.0, 1.0, TEMPLATE_ROWS)}
    recording = Recording(time, columns, period, "the next experiment")
    experiment = Experiment(
        signal,
        columns[simulation.output_column],
        simulation.acquisition(period),
        np.ones(TEMPLATE_ROWS, bool),
        offset=simulation.known_offset,
        estimate_latency=simulation.latency == "estimate" or simulation.latency_deviation is not None,
        estimate_skew=simulation.skew == "estimate" or simulation.skew_deviation is not None,
    )
    (unknown,) = with_unknown_constants([experiment], simulation)
    experiment = replace(
        unknown,
        estimate_offset=unknown.estimate_offset or simulation.offset_deviation is not None,
        estimate_bias=unknown.estimate_bias or simulation.bias_deviation is not None,
    )
    problem = problem_of(simulation, structure_of(simulation), [recording], [experiment])
    return replace(problem, kind=replace(problem.kind, bias=simulation.known_bias))
