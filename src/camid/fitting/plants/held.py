"""A plant of any other kind that is not left to itself: a controller or an observer holds it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import Effect
from camid.effects.parameter import Parameter
from camid.engine.nonlinear_plant import NonlinearPlant
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.growing_horizon import STEPS
from camid.fitting.initial_motion import recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.kind import PlantKind
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.records import Records
from camid.identification.srivc import least_squares_state_variable_filter
from camid.identification.starts import cut_offs
from camid.identification.structure import Structure
from camid.simulation.model import Simulation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HeldPlant(PlantKind):
    """A plant of any other kind near its recording, which what holds it brings about.

    Attributes
    ----------
    plant : PlantKind
        What is held.
    """

    plant: PlantKind

    @property
    def phases_add_up(self) -> bool:
        """As those of what is held."""
        return self.plant.phases_add_up

    def constants(self) -> dict[str, float]:
        """Those of what is held."""
        return self.plant.constants()

    def free_constants(self) -> tuple[Parameter, ...]:
        """Those of what is held."""
        return self.plant.free_constants()

    def packed(self, structure: Structure) -> NDArray[np.bool_]:
        """Those of what is held."""
        return self.plant.packed(structure)

    def completed(self, coefficients: Array, constants: Mapping[str, float]) -> Array:
        """As what is held completes them."""
        return self.plant.completed(coefficients, constants)

    def with_coefficients(self, model: Model, coefficients: Array) -> Model:
        """As what is held takes them."""
        return self.plant.with_coefficients(model, coefficients)

    def coefficient_covariance(self, structure: Structure, fitted: Fitted) -> Array:
        """That of what is held."""
        return self.plant.coefficient_covariance(structure, fitted)

    def estimates(self, structure: Structure, model: Model, fitted: Fitted | None) -> list[tuple[str, float, float]]:
        """Those of what is held."""
        return self.plant.estimates(structure, model, fitted)

    def remarks(self, found: Simulation) -> tuple[str, ...]:
        """Those of what is held."""
        return self.plant.remarks(found)

    def all_fixed(self) -> Self:
        """The same with nothing to be re-estimated."""
        return replace(self, plant=self.plant.all_fixed())

    def forces(self, model: Model) -> tuple[Effect, ...]:
        """Those of what is held."""
        return self.plant.forces(model)

    def nonlinear(self, model: Model, seen: int | None = None) -> NonlinearPlant | None:
        """Those of what is held."""
        return self.plant.nonlinear(model, seen)

    def prepared(self, problem: Problem) -> Self:
        """The same with what is held prepared."""
        return replace(self, plant=self.plant.prepared(problem))

    def state_before_record(self, experiment: Experiment) -> bool:
        """What holds it starts with the record."""
        return False

    def at_plant(self, positions: Array, model: Model) -> Array:
        """As what is held counts them."""
        return self.plant.at_plant(positions, model)

    def starts_from_regression(self, problem: Problem, model: Model) -> list[Model]:
        """From what the recorded control does of the recorded position, as if there were no loop.

        The noise that the controller feeds back biases them a little (Söderström & Stoica 1989, System Identification,
        chapter 10); but no control that switches at other times than the recorded one hides where they lie.
        """
        positions = self.recorded_positions(problem)
        opened = [replace(e, output=p) for e, p in zip(problem.experiments, positions, strict=True)]
        found = self.plant.starts_from_regression(replace(problem, experiments=opened, kind=self.plant), model)
        records = Records.of(opened)
        for cut_off in cut_offs(opened):
            predictor = Predictor(problem.structure, opened, 1.0 / cut_off, records)
            coefficients = predictor.to_physical(least_squares_state_variable_filter(predictor, cut_off))
            if np.all(np.isfinite(coefficients)):
                found.append(self.with_coefficients(model, coefficients))
        return found

    def _searched(self, problem: Problem, start: Model) -> Fitted:
        """Output error over the whole record, from the start and from the best of what a regression suggests.

        What holds the plant keeps the simulation near the recording; but where a controller saturates, its control
        switches, and the sum of squares of a control that switches at the wrong times has many minima.
        """
        start = start if start.initial else recorded_start(problem, start)
        found = fit(problem, start, steps=STEPS)
        if start.effects:
            return found
        best: Fitted | None = None
        for model in (*self.plant.models_about(problem, start), *self.starts_from_regression(problem, start)):
            try:
                tried = evaluate(problem, recorded_start(problem, model))
            except (ValueError, ArithmeticError, np.linalg.LinAlgError):  # constants that make no such plant
                continue
            if best is None or tried.cost < best.cost:
                best = tried
        if best is None or (best.model.constants, *best.model.coefficients) == (start.constants, *start.coefficients):
            return found
        return min((found, fit(problem, best.model, steps=STEPS)), key=lambda each: each.cost)

    def written_back(self, believed: Simulation, structure: Structure, fitted: Fitted) -> Simulation:
        """As that of what is held."""
        return self.plant.written_back(believed, structure, fitted)
