"""What every kind of plant has to say: a plant that the engine simulates from a recorded input."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from camid.chain.controller import Loop
from camid.chain.observer import Pull
from camid.chain.plant import TransferFunction
from camid.effects.actuator import InputBias
from camid.effects.base import Effect
from camid.effects.parameter import Parameter
from camid.effects.sensor import ClockSkew, Delay, FrameSkew
from camid.effects.sensor_reading import SensorOffset
from camid.effects.situation import Situation
from camid.engine.mechanics import Chain
from camid.engine.nonlinear_plant import NonlinearPlant
from camid.engine.run import run, steps_of
from camid.fitting.equivalent_input import equivalent_input, force_through_filter
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.growing_horizon import fit_growing
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.identified_by_simulation import identify_by_simulation
from camid.fitting.initial_motion import recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import BIAS, LATENCY, OFFSET, SKEW, with_constants
from camid.fitting.plants.latencies import with_latencies
from camid.fitting.problem import Problem
from camid.fitting.views import Views, added_by_sensor
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from camid.recording.recording import Recording
from camid.side_by_side import in_threads
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    from camid.identification.identification import Identification

Array = NDArray[np.float64]

# Force, as a share of the largest input, that a plant which is not linear is asked about.
SMALL_FORCE = 1e-4


@dataclass(frozen=True)
class PlantKind:
    """A kind of plant; it is made once, from the simulation, and asked wherever kinds differ.

    The defaults are those of a plant that the engine simulates from a recorded input; a new kind overrides what it
    does otherwise and is made in :func:`camid.fitting.from_simulation.kind_of`.

    Attributes
    ----------
    prescribes_order : str or None
        What of the simulation leaves no order to choose, in words; None where any order may be tried.
    why_no_other_orders : (str, str) or None
        What the comparison of orders is of, and why that is not this kind; and what to do instead. None where plants of
        other orders can be compared with this one.
    method : str or None
        How the plant is identified, whatever method is asked for; None where that has a choice.
    residual_of : str
        What recorded and simulated values are of: the ``output`` or the ``control``.
    shown_sign : float
        -1 where :meth:`equivalent_input` makes up for a force.
    simulated_columns : tuple of str
        What ``simulate`` adds to the recorded columns.
    hidden_places : frozenset of str
        Places of the chain whose faults the residual does not show.
    why_hidden : str
        Why not.
    why_coloured : str
        Why what is left of a right model has a colour; empty where it has none but that of the noise.
    one_reading : bool
        Whether the residual is that of one reading, and not of several columns that read different things.
    offset, bias : float
        What the sensor reads at the plant's zero, and what is added to the input, as they are believed.
    skew : float
        Relative rate of the camera's clock against that of the input, as it is believed.
    offset_free, bias_free, latency_free, skew_free : bool
        Whether they, and the latency of the sensor, are re-estimated.
    """

    offset: float = field(default=0.0, kw_only=True)
    offset_free: bool = field(default=False, kw_only=True)
    bias: float = field(default=0.0, kw_only=True)
    bias_free: bool = field(default=False, kw_only=True)
    latency_free: bool = field(default=False, kw_only=True)
    skew: float = field(default=0.0, kw_only=True)
    skew_free: bool = field(default=False, kw_only=True)

    prescribes_order: ClassVar[str | None] = None
    why_no_other_orders: ClassVar[tuple[str, str] | None] = None
    method: ClassVar[str | None] = "output error"
    residual_of: ClassVar[str] = "output"
    shown_sign: ClassVar[float] = 1.0
    simulated_columns: ClassVar[tuple[str, ...]] = ("simulated",)
    hidden_places: ClassVar[frozenset[str]] = frozenset()
    why_hidden: ClassVar[str] = ""
    why_coloured: ClassVar[str] = ""
    one_reading: ClassVar[bool] = True

    @property
    def phases_add_up(self) -> bool:
        """Whether an effect changes a phase that grows with the time, which no input sets right again.

        Only a very small change is then in proportion: neither screening nor first steps of a fit measure an effect.
        """
        return False

    # -- what it consists of -----------------------------------------------------------------------------------------

    def constants(self) -> dict[str, float]:
        """Nominal values of the plant's constants beside the coefficients."""
        found = {}
        if self.offset_free or self.offset != 0.0:
            found[OFFSET.name] = self.offset
        if self.bias_free:
            found[BIAS.name] = self.bias
        if self.latency_free:
            found[LATENCY.name] = 0.0
        if self.skew_free or self.skew != 0.0:
            found[SKEW.name] = self.skew
        return found

    def free_constants(self) -> tuple[Parameter, ...]:
        """Those of them that are re-estimated; ``scale`` says what each is measured by."""
        free = (self.offset_free, self.bias_free, self.latency_free, self.skew_free)
        return tuple(c for c, is_free in zip((OFFSET, BIAS, LATENCY, SKEW), free, strict=True) if is_free)

    def constant_beside(self, problem: Problem) -> bool:
        """Whether a constant is estimated that takes what friction differs by in both directions."""
        return self.offset_free or self.bias_free

    def packed(self, structure: Structure) -> NDArray[np.bool_]:
        """Which coefficients are fitted as such, shape (m + 1 + n,); others follow from constants, or stay."""
        return structure.free

    def completed(self, coefficients: Array, constants: Mapping[str, float]) -> Array:
        """Coefficients, shape (m + 1 + n,), with those set that follow from others, or from constants."""
        return coefficients

    def with_coefficients(self, model: Model, coefficients: Array) -> Model:
        """The model with other coefficients, shape (m + 1 + n,), or the nearest ones that its constants can make."""
        return replace(model, coefficients=self.completed(coefficients, model.constants))

    def coefficient_covariance(self, structure: Structure, fitted: Fitted) -> Array:
        """Covariance of all coefficients, shape (m + 1 + n, m + 1 + n), zero for those that are not free."""
        count = int(np.count_nonzero(structure.free))
        return structure.full_covariance(fitted.covariance[:count, :count])

    def estimates(self, structure: Structure, model: Model, fitted: Fitted | None) -> list[tuple[str, float, float]]:
        """Name, value and standard deviation of what describes the plant; zero deviations without a fit."""
        names = structure.names
        deviations = np.zeros(len(names))
        if fitted is not None:
            deviations = np.sqrt(np.diag(self.coefficient_covariance(structure, fitted)))
        return [*zip(names, map(float, model.coefficients), map(float, deviations), strict=True)]

    def all_fixed(self) -> Self:
        """The same with nothing of the plant to be re-estimated; unknown offsets and biases stay unknown."""
        return self

    def with_unknown(self, experiments: Sequence[Experiment]) -> Self:
        """The same with those constants free that are unknown of the experiments."""
        offset, bias = (any(e.estimate_offset for e in experiments), any(e.estimate_bias for e in experiments))
        latency, skew = any(e.estimate_latency for e in experiments), any(e.estimate_skew for e in experiments)
        return replace(self, offset_free=offset, bias_free=bias, latency_free=latency, skew_free=skew)

    # -- how it is simulated -----------------------------------------------------------------------------------------

    def forces(self, model: Model) -> tuple[Effect, ...]:
        """What turns the linear chain into this plant, as the engine takes it."""
        found: tuple[Effect, ...] = ()
        if BIAS.name in model.constants:
            found += (InputBias(bias=model.constants[BIAS.name]),)
        if OFFSET.name in model.constants:
            found += (SensorOffset(offset=model.constants[OFFSET.name]),)
        if LATENCY.name in model.constants:
            found += (Delay(delay=model.constants[LATENCY.name]),)
        if SKEW.name in model.constants:
            found += (FrameSkew(skew=model.constants[SKEW.name]),)
        return found

    def nonlinear(self, model: Model, seen: int | None = None) -> NonlinearPlant | None:
        """The equations of a model, as a column of the sensor sees them; None for a linear plant with forces."""
        return None

    def rest_of(self, model: Model) -> Callable[[float], dict[str, float] | None] | None:
        """State of the plant's equations at rest, by name, at an output; None where there are none."""
        return None

    def prepared(self, problem: Problem) -> Self:
        """The same with what has to be known of the recordings before anything is fitted."""
        return self

    def loop(self, index: int) -> Loop | None:
        """The controller that makes the input of a recording, if one does."""
        return None

    def pull(self, experiment: Experiment, model: Model, effects: Sequence[Effect]) -> Pull | None:
        """What pulls the motion of a model with all effects towards a recording, if an observer does."""
        return None

    def state_before_record(self, experiment: Experiment) -> bool:
        """Whether an initial state is that before the first frame's exposure, and not that at the first sample."""
        return experiment.free_motion_before_record

    def simulated_exactly(
        self, simulation: Simulation, recording: Recording, held_out: NDArray[np.bool_] | None = None
    ) -> Array | None:
        """Output, shape (N,), of the plant without effects where no integrator is needed; None where one is.

        Rows in ``held_out``, shape (N,), do not take part in the fit of an unknown initial state.
        """
        return None

    def output_and_control(self, chain: Chain, signal: Array, time: Array) -> tuple[Array, Array | None]:
        """Samples of the sensor and, in a closed loop, what the controller puts out; shapes (N,)."""
        return run(chain, signal, time), None

    # -- what a recording shows of it --------------------------------------------------------------------------------

    def compared(self, experiments: list[Experiment]) -> list[Experiment]:
        """Experiments whose outputs are what is compared."""
        return experiments

    def start_of(self, rows: int) -> Self:
        """The same for recordings that are cut off after this many rows."""
        return self

    def at_plant(self, positions: Array, model: Model) -> Array:
        """Recorded positions as the plant's forces count them."""
        return positions - model.constants.get(OFFSET.name, 0.0)

    def recorded_positions(self, problem: Problem) -> Sequence[Array]:
        """Recorded positions of each recording, shapes (N,)."""
        return [e.output for e in problem.experiments]

    def position_seen(self, problem: Problem, model: Model, index: int, position: Array) -> Array:
        """What represents the position in the image, shape (N,): the sensor's reading of ``position``."""
        return problem.simulate_one(model, index)

    def unseen(self, effect: type[Effect]) -> str | None:
        """Why recordings of this kind cannot show an effect; None if they can."""
        if self.offset_free and effect is SensorOffset:
            return "the simulation does not say where the sensor's zero is, so that is estimated with the plant"
        if self.bias_free and effect is InputBias:
            return "the simulation says nothing of it, so it is estimated with the plant"
        if self.latency_free and effect is Delay:
            return "the simulation leaves the latency open, so it is estimated with the plant"
        if SKEW.name in self.constants() and effect is ClockSkew:
            return "the simulation says what the skew is, or that it is estimated with the plant"
        return None

    def unseen_beside(self, effect: type[Effect], model: Model) -> str | None:
        """The same beside the effects of a model: behind an actuator that bends its input a constant is another one."""
        bent = any(e.place == "actuator" and not e.linear_dynamics and not e.is_constant for e in model.effects)
        return None if effect is InputBias and self.bias_free and bent else self.unseen(effect)

    def situations(self, problem: Problem, model: Model, index: int) -> Views:
        """What first guesses need of one recording."""
        experiment = problem.experiments[index]
        recorded, simulated = experiment.output, problem.simulate_one(model, index)
        residual = np.where(experiment.used, recorded - simulated, 0.0)
        acquisition = experiment.acquisition
        for effect in (*self.forces(model), *model.effects):
            acquisition = effect.declare(acquisition)

        def seen(recorded: Array, simulated: Array) -> Situation:
            return Situation(
                problem.times[index],
                experiment.signal,
                recorded,
                simulated,
                np.gradient(simulated, acquisition.period),
                residual,
                problem.structure.plant(model.coefficients),
                acquisition,
                experiment.used,
                self.rest_of(model),
                others=problem.signals_beside(index),
            )

        reading, offset = seen(recorded, simulated), model.constants.get(OFFSET.name, 0.0)
        added = added_by_sensor(problem, model, index, simulated - offset)
        if not self.constants() and added is None:
            return Views(reading, reading, reading)
        from_zero = reading if offset == 0.0 else seen(recorded - offset, simulated - offset)
        at_plant = [self.at_plant(y if added is None else y - added, model) for y in (recorded, simulated)]
        return Views(reading, from_zero, seen(at_plant[0], at_plant[1]))

    def force_responses(
        self, problem: Problem, model: Model, index: int, forces: list[Array], hold: str
    ) -> list[Array]:
        """What forces at the plant's input, each of shape (N,) and held as ``hold`` says, change of what is compared.

        By differences with a small force, so that the plant answers as it is.
        """
        chain = problem.chain(model, index)
        signal, time = problem.experiments[index].signal, problem.times[index]
        chain = replace(chain, steps=steps_of(chain, signal, time, finest=False))
        small = SMALL_FORCE * problem.situation(model, index).largest("signal")
        undisturbed = run(chain, signal, time)

        def respond(force: Array) -> Array:
            size = small / (float(np.max(np.abs(force), initial=0.0)) or 1.0)
            disturbed = run(replace(chain, known_force=(size * force, hold)), signal, time)
            return np.nan_to_num((disturbed - undisturbed) / size)

        return in_threads(respond, forces)

    def equivalent_input(self, problem: Problem, model: Model, residual: Array) -> Array:
        """Input that would have caused the residual of a recording, shape (N,)."""
        return equivalent_input(self.seen_plant(problem, model), problem.chain(model, 0).declared(), residual)

    def force_seen(self, problem: Problem, model: Model, force: Array) -> Array:
        """A force at the plant's input, shape (N,), as :meth:`equivalent_input` shows it."""
        return force_through_filter(self.seen_plant(problem, model), problem.chain(model, 0).declared(), force)

    def seen_plant(self, problem: Problem, model: Model) -> TransferFunction:
        """From the input to what the sensor sees, for small motions."""
        return problem.structure.plant(model.coefficients)

    def position_errors(
        self, problem: Problem, models: tuple[Model, Model], rows: Sequence[NDArray[np.bool_]]
    ) -> tuple[float, float] | None:
        """Normalised errors of the position with two models on some rows; None where the residual is the position's."""
        return None

    # -- how it is fitted --------------------------------------------------------------------------------------------

    def refit(self, problem: Problem, start: Model) -> Fitted:
        """The nominal structure with its coefficients, its effects and the initial states re-estimated.

        It never leaves more than the start does: a search may end in another minimum than the one that the given model
        lies in, and then least squares from there take its place.
        """
        found, given = self._searched(problem, start), evaluate(problem, start)
        if np.isfinite(found.cost) and not given.cost < found.cost:
            return found
        return min((fit(problem, start), given), key=lambda fitted: fitted.cost)

    def _searched(self, problem: Problem, start: Model) -> Fitted:
        """What the search for the best coefficients, effects and initial states finds; for :meth:`refit` alone."""
        return fit_growing(problem, self.with_best_latency(problem, start))

    def with_best_latency(self, problem: Problem, start: Model) -> Model:
        """The model with that of a grid of latencies with which it follows the recordings best, where that is open."""
        begins = with_latencies(problem, start)
        if len(begins) == 1:
            return start
        settled = [evaluate(problem, problem.with_initial_states(begin)) for begin in begins]
        return min(settled, key=lambda fitted: fitted.cost).model

    def with_initial_states(self, problem: Problem, model: Model) -> Model:
        """The model with the initial states that a fit starts from."""
        return recorded_start(problem, model)

    def finds_initial_states(self, model: Model) -> bool:
        """Whether :meth:`with_initial_states` finds those that suit the model best, and not only near them."""
        return False

    def starts_from_regression(self, problem: Problem, model: Model) -> list[Model]:
        """Models that the recorded motion itself suggests, without any simulation."""
        return []

    def models_about(self, problem: Problem, start: Model) -> list[Model]:
        """Models about a given one that follow the recordings best, of a plant that is not made from coefficients."""
        return []

    def identified(self, problem: Problem, task: IdentificationTask) -> Identification:
        """The plant identified."""
        return identify_by_simulation(problem, task)

    def remarks(self, found: Simulation) -> tuple[str, ...]:
        """What a recording of this kind leaves open of the plant that was found, a sentence each."""
        return ()

    # -- how it is written -------------------------------------------------------------------------------------------

    def written_back(self, believed: Simulation, structure: Structure, fitted: Fitted) -> Simulation:
        """The simulation with the plant of a fit, and its accuracy where the data determine it."""
        lead, model = believed.plant.denominator[0], fitted.model
        plant = structure.plant(model.coefficients)
        covariance = np.square(lead) * self.coefficient_covariance(structure, fitted)
        finite = bool(np.all(np.isfinite(covariance)))
        deviations, split = np.sqrt(np.abs(np.diag(covariance))), structure.degree + 1
        scaled = TransferFunction(*(tuple(lead * c for c in row) for row in (plant.numerator, plant.denominator)))
        stated = {"numerator": deviations[:split].tolist(), "denominator": [0.0, *deviations[split:].tolist()]}
        return replace(
            with_constants(believed, fitted, self.free_constants()),
            plant=scaled,
            standard_deviations=stated if finite else None,
            covariance=covariance.tolist() if finite else None,
        )
