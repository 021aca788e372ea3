"""A linear plant driven by a recorded input, or without one: the exact path of identification holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from camid.chain.exact import sample
from camid.fitting.exact_output import exact_output
from camid.fitting.first_rows import FirstRows
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.growing_horizon import fit_growing
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.identified_by_simulation import identify_by_simulation
from camid.fitting.identified_exactly import analysed, identify_exactly
from camid.fitting.initial_motion import companion_state, recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import BIAS, LATENCY, OFFSET, SKEW
from camid.fitting.plants.kind import PlantKind
from camid.fitting.plants.latencies import with_latencies
from camid.fitting.problem import Problem
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    from camid.identification.identification import Identification

Array = NDArray[np.float64]

# Largest number of evaluations of a fit with declared effects.
STEPS = 60


@dataclass(frozen=True)
class LinearPlant(PlantKind):
    """A transfer function that a recorded input drives."""

    method: ClassVar[str | None] = None

    def simulated_exactly(
        self, simulation: Simulation, recording: Recording, held_out: NDArray[np.bool_] | None = None
    ) -> Array | None:
        """The exact path, without integrator, which knows no skew and no input with times of its own."""
        return None if self.skew != 0.0 or recording.logs else exact_output(simulation, recording, held_out)

    def force_responses(
        self, problem: Problem, model: Model, index: int, forces: list[Array], hold: str
    ) -> list[Array]:
        """What the sensor measures of them, exactly."""
        plant = problem.structure.plant(model.coefficients)
        acquisition = replace(problem.chain(model, index).declared(), hold=hold)
        return [sample(plant, force, acquisition) for force in forces]

    def needs_engine(self, problem: Problem) -> bool:
        """Whether the exact path only starts a fit: it takes frames and input for samples of one clock."""
        logged = any(e.input_log is not None for e in problem.experiments)
        return self.latency_free or SKEW.name in self.constants() or logged

    def _searched(self, problem: Problem, start: Model) -> Fitted:
        """The exact path of identification; where effects are declared, output error with them."""
        if start.effects:
            return self._refit_with_effects(problem, start)
        if self.needs_engine(problem):
            return self._searched_by_engine(problem, start)
        return self._searched_exactly(problem, start)

    def _searched_by_engine(self, problem: Problem, start: Model) -> Fitted:
        """The exact path, which knows no skew, with latencies of a grid; from the best of them output error."""
        found = []
        for begin in with_latencies(problem, start):
            try:
                found.append(self._searched_exactly(problem, begin))
            except (ValueError, ArithmeticError):
                continue
        best = min(found, key=lambda fitted: fitted.cost).model if found else start
        return fit(problem, best, steps=STEPS)

    def _searched_exactly(self, problem: Problem, start: Model) -> Fitted:
        """The exact path of identification, with the latency of the start."""
        structure = problem.structure
        if not np.any(structure.free):
            return evaluate(problem, start)
        experiments = experiments_at(problem, start)
        try:
            result = estimate(structure, experiments, nominal=structure.plant(start.coefficients))
        except ValueError:  # in a part of a recording the output may rest on one step of a coarse lattice
            return evaluate(problem, start)
        coefficients = np.array([*result.plant.numerator, *result.plant.denominator[1:]])
        if len(coefficients) != len(structure.free):  # a leading coefficient of the numerator that came out as zero
            coefficients = start.coefficients
        return evaluate(problem, problem.with_initial_states(Model(coefficients, constants=start.constants)))

    def _refit_with_effects(self, problem: Problem, start: Model) -> Fitted:
        return fit(problem, start, steps=STEPS)

    def with_initial_states(self, problem: Problem, model: Model) -> Model:
        """The model with the initial states and unknown constants that fit its linear part best."""
        structure = problem.structure
        denominator = np.concatenate([[1.0], model.coefficients[structure.degree + 1 :]])
        predictor = Predictor.around(structure, experiments_at(problem, model), denominator)
        first = FirstRows.of(problem, model)
        beside = None
        if first is not None:
            beside = Predictor.around(structure, experiments_at(first.alone, model), denominator), first.weight_beside
        parameters = predictor.with_fitted_initial_states(model.coefficients, beside)
        polynomials = predictor.split(parameters)[2]
        initial = tuple(None if p is None else companion_state(structure, model.coefficients, p) for p in polynomials)
        found = replace(model, initial=initial, constants=self._fitted_constants(problem, model, predictor, parameters))
        if not model.effects:
            return found
        # Effects may have bent the motion so far from the linear one that its best state is none; the recording shows
        # it.
        return min((found, recorded_start(problem, model)), key=lambda start: misfit(problem, start))

    def finds_initial_states(self, model: Model) -> bool:
        """Without effects, by linear least squares."""
        return not model.effects

    def _fitted_constants(
        self, problem: Problem, model: Model, predictor: Predictor, parameters: Array
    ) -> dict[str, float]:
        """The plant's constants, offset and bias as a fit found them where they are unknown."""
        bias, offset = predictor.bias_and_offset(parameters)
        found = {**self.constants(), **model.constants}
        if self.offset_free:
            found[OFFSET.name] = problem.experiments[0].offset + offset
        if self.bias_free:
            found[BIAS.name] = bias
        return found

    def identified(self, problem: Problem, task: IdentificationTask) -> Identification:
        """By the method asked for, with the tests of the residual; with a latency that is unknown by output error."""
        if not self.needs_engine(problem):
            return identify_exactly(problem, task)
        found = identify_by_simulation(problem, task)
        logged = any(e.input_log is not None for e in problem.experiments)
        if logged or found.simulation.known_skew != 0.0:  # the tests of the residual take both clocks for one
            return replace(found, method="output error")
        latency = found.simulation.known_latency
        experiments = _delayed(problem.experiments, latency)
        found = replace(found, acquisition=experiments[0].acquisition, method="output error")
        return analysed(found, problem.structure, experiments, task.progress)


@dataclass(frozen=True)
class FreeDecay(LinearPlant):
    """A transfer function that nothing drives: it swings on from its initial state."""

    @property
    def phases_add_up(self) -> bool:
        """No input sets a phase right again."""
        return True

    def _refit_with_effects(self, problem: Problem, start: Model) -> Fitted:
        return fit_growing(problem, start)


def misfit(problem: Problem, model: Model) -> float:
    """Sum of squared residuals; infinite where the simulation fails."""
    try:
        residual = problem.output - problem.simulate_fitted(model)
    except (ValueError, ArithmeticError):
        return np.inf
    return float(np.nan_to_num(residual @ residual, nan=np.inf, posinf=np.inf))


def experiments_at(problem: Problem, model: Model) -> list[Experiment]:
    """The experiments with the latency that a model gives the sensor, where that is unknown."""
    latency = model.constants.get(LATENCY.name)
    return problem.experiments if latency is None else _delayed(problem.experiments, latency)


def _delayed(experiments: Sequence[Experiment], latency: float) -> list[Experiment]:
    return [replace(e, acquisition=replace(e.acquisition, latency=latency)) for e in experiments]
