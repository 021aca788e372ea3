"""A linear plant of named constants: the exact path identifies coefficients, from which the constants follow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.identified_by_simulation import identify_by_simulation
from camid.fitting.identified_exactly import analysed, identify_exactly
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import STEPS, FreeDecay, LinearPlant, experiments_at, misfit
from camid.fitting.plants.named_constants import NamedConstants
from camid.fitting.problem import Problem
from camid.identification.estimate import Estimate, estimate
from camid.physical.undetermined import Undetermined

if TYPE_CHECKING:
    from camid.identification.identification import Identification

Array = NDArray[np.float64]

# Relative accuracy of constants that follow from coefficients, and error above which they do not.
TOLERANCE = 1e-12
UNREACHED = 1e-6


@dataclass(frozen=True)
class PhysicalKind(NamedConstants, LinearPlant):
    """A linear plant whose coefficients are functions of named constants."""

    @cached_property
    def undetermined(self) -> Undetermined:
        """What recordings of this kind leave open of the constants."""
        return self.physical.undetermined(self.structure.free)

    def coefficients(self, values: Array) -> Array:
        """Of the monic plant."""
        return self.physical.coefficients.monic(values)

    @cached_property
    def sensitive(self) -> Array:
        """Changes of the coefficients by relative changes of the constants."""
        return self.physical.coefficients.sensitive(self.physical.values)

    @cached_property
    def estimated(self) -> tuple[str, ...]:
        """Constants that are fitted: those that are free and move a coefficient that is determined."""
        moves = np.any(self.sensitive[self.structure.free] != 0.0, axis=0)
        return tuple(name for name in super().estimated if moves[self.physical.names.index(name)])

    def slopes(self, values: Array) -> Array:
        """Derivatives of the coefficients by the constants, shape (m + 1 + n, p)."""
        return self.physical.coefficients.derivatives(values)

    def with_coefficients(self, model: Model, coefficients: Array) -> Model:
        """The model with those constants that come nearest to coefficients."""
        free = self.structure.free
        values = self._nearest(coefficients, np.eye(int(np.count_nonzero(free))))
        return self.with_values(model, values)

    # -- how it is fitted --------------------------------------------------------------------------------------------

    @property
    def _columns(self) -> list[int]:
        return [self.physical.names.index(name) for name in self.estimated]

    def _nearest(self, coefficients: Array, weight: Array) -> Array:
        """Constants, shape (p,), whose coefficients are the nearest to given ones, (m + 1 + n,).

        ``weight``, (f, f), multiplies the relative errors of the free ones; the covariance of the coefficients gives
        the estimate of least variance (Ferguson 1996, A Course in Large Sample Theory, section 23).
        """
        from scipy.optimize import least_squares

        free, columns, start = self.structure.free, self._columns, self.physical.values
        wanted = coefficients[free]
        sizes = np.where(wanted == 0.0, 1.0, np.abs(wanted))
        units = np.where(start[columns] == 0.0, 1.0, np.abs(start[columns]))

        def error(vector: Array) -> Array:
            values = start.copy()
            values[columns] = vector * units
            found = self.physical.coefficients.monic(values)[free]
            return np.asarray(weight @ np.nan_to_num((found - wanted) / sizes, nan=1e6, posinf=1e6, neginf=-1e6))

        if not columns or len(wanted) < len(columns):
            return start
        begin = start[columns] / units
        found = least_squares(error, begin, method="lm", xtol=TOLERANCE, ftol=TOLERANCE, gtol=TOLERANCE)
        result = start.copy()
        result[columns] = found.x * units
        if self.undetermined.held and np.sqrt(2.0 * found.cost) > UNREACHED:
            # What is held may leave the others no way to the coefficients: then it moves, too.
            columns = [self.physical.names.index(name) for name in (*self.undetermined.held, *self.estimated)]
            units = np.where(start[columns] == 0.0, 1.0, np.abs(start[columns]))
            moved = least_squares(error, start[columns] / units, xtol=TOLERANCE, ftol=TOLERANCE, gtol=TOLERANCE)
            if moved.cost < found.cost:
                result = start.copy()
                result[columns] = moved.x * units
        return result

    @property
    def _one_to_one(self) -> bool:
        """Whether there are as many constants as coefficients, so that these say all about those."""
        return len(self.estimated) == int(np.count_nonzero(self.structure.free))

    def _searched_exactly(self, problem: Problem, start: Model) -> Fitted:
        """Constants that follow from the coefficients of the exact path; where they are fewer, a fit of their own."""
        if not self.estimated:
            return evaluate(problem, start)
        try:
            begin = estimate(
                problem.structure, experiments_at(problem, start), nominal=problem.structure.plant(start.coefficients)
            )
            model = problem.with_initial_states(self._explaining(start, begin))
        except (ValueError, ArithmeticError):
            model = start
        if misfit(problem, start) < misfit(problem, model):
            model = start
        found = evaluate(problem, model)
        return found if self._one_to_one and model is not start else fit(problem, model, steps=STEPS)

    def _explaining(self, model: Model, found: Estimate) -> Model:
        """The model with the constants that explain an estimate of its coefficients best."""
        coefficients = np.array([*found.plant.numerator, *found.plant.denominator[1:]])
        if len(coefficients) != len(self.structure.free):
            raise ValueError("the leading coefficient of the numerator is zero")
        free = self.structure.free
        sizes = np.where(coefficients == 0.0, 1.0, np.abs(coefficients))[free]
        weight = np.eye(len(sizes))
        covariance = found.covariance[np.ix_(free, free)] / np.outer(sizes, sizes)
        if not self._one_to_one and np.all(np.isfinite(covariance)):
            spreads, axes = np.linalg.eigh(0.5 * (covariance + covariance.T))
            weight = (axes / np.sqrt(np.maximum(spreads, 1e-12 * spreads[-1] + 1e-30))).T
        return self.with_values(model, self._nearest(coefficients, weight))

    def identified(self, problem: Problem, task: IdentificationTask) -> Identification:
        """Coefficients by the method asked for, from which the constants follow; where they are fewer, their own fit.

        Raises
        ------
        InputError
            If no constant is free.
        """
        self.refuse_nothing_free(task)
        task = replace(task, believed=replace(task.believed, plant=task.believed.plant.monic))
        if self.needs_engine(problem):
            return super().identified(problem, task)
        if not self._one_to_one:
            found = identify_by_simulation(problem, task)
            return analysed(replace(found, method=None), problem.structure, problem.experiments, task.progress)
        found = identify_exactly(problem, task)
        model = self._explaining(Model(problem.structure.coefficients(), constants=self.constants()), found.estimate)
        free, columns = self.structure.free, self._columns
        inverse = np.linalg.inv(self.physical.coefficients.derivatives(self.values_of(model))[free][:, columns])
        covariance = np.zeros((len(self.physical.names),) * 2)
        covariance[np.ix_(columns, columns)] = inverse @ found.estimate.covariance[free][:, free] @ inverse.T
        physical = self.physical.estimated(self.values_of(model), covariance, self.undetermined)
        return replace(found, simulation=replace(found.simulation, physical=physical))


@dataclass(frozen=True)
class PhysicalFreeDecay(PhysicalKind, FreeDecay):
    """The same where nothing drives it."""
