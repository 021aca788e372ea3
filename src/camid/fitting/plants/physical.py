"""A linear plant of named constants: they are what is fitted, and the coefficients follow from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from camid.effects.parameter import Parameter
from camid.errors import InputError
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.identified_by_simulation import identify_by_simulation
from camid.fitting.identified_exactly import analysed, identify_exactly
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import STEPS, FreeDecay, LinearPlant, misfit
from camid.fitting.problem import Problem
from camid.identification.estimate import Estimate, estimate
from camid.identification.structure import Structure
from camid.physical.plant import PhysicalPlant
from camid.physical.undetermined import Undetermined
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    from camid.identification.identification import Identification

Array = NDArray[np.float64]

# What the name of a constant begins with among the numbers that are fitted beside coefficients.
PREFIX = "constant "
# Relative accuracy of constants that follow from coefficients.
TOLERANCE = 1e-12


@dataclass(frozen=True)
class PhysicalKind(LinearPlant):
    """A plant whose coefficients are functions of named constants.

    Attributes
    ----------
    physical : PhysicalPlant
        As it is believed.
    structure : Structure
        Which coefficients depend on a constant that is free, and are determined by a recording of this kind.
    nothing_free : bool
        Whether all constants keep their values.
    """

    physical: PhysicalPlant = field(kw_only=True)
    structure: Structure = field(kw_only=True)
    nothing_free: bool = field(default=False, kw_only=True)

    prescribes_order: ClassVar[str | None] = "a plant of named constants"
    why_no_other_orders: ClassVar[tuple[str, str] | None] = (
        "plants of free coefficients, and this one has named constants",
        "leave the simulation out, or write a transfer_function in place of physical",
    )

    # -- what it consists of -----------------------------------------------------------------------------------------

    @cached_property
    def undetermined(self) -> Undetermined:
        """What recordings of this kind leave open of the constants."""
        return self.physical.undetermined(self.structure.free)

    @cached_property
    def estimated(self) -> tuple[str, ...]:
        """Constants that are fitted: those that are free and move a coefficient that is determined."""
        if self.nothing_free:
            return ()
        moves = np.any(self.physical.coefficients.sensitive(self.physical.values)[self.structure.free] != 0.0, axis=0)
        names = self.physical.names
        free, held = self.physical.free, self.undetermined.held
        return tuple(n for i, n in enumerate(names) if n in free and n not in held and moves[i])

    def constants(self) -> dict[str, float]:
        """Values of the named constants, and those of every plant."""
        return {**super().constants(), **{PREFIX + n: float(v) for n, v in self.physical.parameters.items()}}

    def free_constants(self) -> tuple[Parameter, ...]:
        """Those that are fitted; what makes a pole is not negative where it is believed not to be."""
        return (*super().free_constants(), *map(self._parameter, self.estimated))

    def _parameter(self, name: str) -> Parameter:
        value, column = self.physical.parameters[name], self.physical.names.index(name)
        sensitive = self.physical.coefficients.sensitive(self.physical.values)[:, column]
        in_poles = bool(np.any(sensitive[self.structure.degree + 1 :] != 0.0))
        lower = 0.0 if value >= 0.0 and in_poles and self.structure.order <= 2 else -np.inf
        size = 0.0
        if value == 0.0:
            # By how much it changes a coefficient by what this is; coefficients that are zero themselves say nothing.
            known = np.abs(self.structure.coefficients())
            rates = np.abs(sensitive)
            sizes = (known / np.where(rates > 0.0, rates, np.inf))[(rates > 0.0) & (known > 0.0)]
            size = float(np.min(sizes, initial=np.inf)) if len(sizes) else 0.0
        return Parameter(PREFIX + name, "", "constant of the plant", lower, size=size if np.isfinite(size) else 0.0)

    def packed(self, structure: Structure) -> NDArray[np.bool_]:
        """None: all follow from the constants."""
        return np.zeros(len(structure.free), bool)

    def completed(self, coefficients: Array, constants: Mapping[str, float]) -> Array:
        """Those that follow from the constants."""
        return self.physical.coefficients.monic(np.array([constants[PREFIX + name] for name in self.physical.names]))

    def with_coefficients(self, model: Model, coefficients: Array) -> Model:
        """The model with those constants that come nearest to coefficients."""
        free = self.structure.free
        values = self._nearest(coefficients, np.eye(int(np.count_nonzero(free))))
        return self._with_values(model, values)

    def all_fixed(self) -> Self:
        """The same with all constants as they are."""
        return replace(self, nothing_free=True)

    def _with_values(self, model: Model, values: Array) -> Model:
        constants = {**model.constants, **self._named(values)}
        return replace(model, coefficients=self.completed(model.coefficients, constants), constants=constants)

    def _named(self, values: Array) -> dict[str, float]:
        return {PREFIX + n: float(v) for n, v in zip(self.physical.names, values, strict=True)}

    def _values(self, model: Model) -> Array:
        return np.array([model.constants[PREFIX + name] for name in self.physical.names])

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

        begin = start[columns] / units
        if not columns or len(wanted) < len(columns):
            return start
        found = least_squares(error, begin, method="lm", xtol=TOLERANCE, ftol=TOLERANCE, gtol=TOLERANCE)
        result = start.copy()
        result[columns] = found.x * units
        return result

    @property
    def _one_to_one(self) -> bool:
        """Whether there are as many constants as coefficients, so that these say all about those."""
        return len(self.estimated) == int(np.count_nonzero(self.structure.free))

    def _searched(self, problem: Problem, start: Model) -> Fitted:
        """Constants that follow from the coefficients of the exact path; where they are fewer, a fit of their own."""
        if start.effects:
            return self._refit_with_effects(problem, start)
        if not self.estimated:
            return evaluate(problem, start)
        try:
            begin = estimate(
                problem.structure, problem.experiments, nominal=problem.structure.plant(start.coefficients)
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
        return self._with_values(model, self._nearest(coefficients, weight))

    # -- what becomes of a fit ---------------------------------------------------------------------------------------

    def _covariance(self, fitted: Fitted) -> Array:
        """Covariance of all constants, zero for those that were not fitted."""
        names, values = fitted.packing.names, self.physical.names
        rows = [names.index(PREFIX + name) for name in self.estimated if PREFIX + name in names]
        columns = [values.index(name) for name in self.estimated if PREFIX + name in names]
        result = np.zeros((len(values), len(values)))
        result[np.ix_(columns, columns)] = fitted.covariance[np.ix_(rows, rows)]
        return result

    def coefficient_covariance(self, structure: Structure, fitted: Fitted) -> Array:
        """Covariance of all coefficients, to first order in that of the constants."""
        slopes = self.physical.coefficients.derivatives(self._values(fitted.model))
        covariance = self._covariance(fitted)
        if not np.all(np.isfinite(covariance)):
            unknown = np.any(slopes[:, ~np.isfinite(np.diag(covariance))] != 0.0, axis=1)
            known = np.nan_to_num(covariance, posinf=0.0, neginf=0.0)
            return np.asarray(np.where(np.outer(unknown, unknown), np.inf, slopes @ known @ slopes.T))
        return np.asarray(slopes @ covariance @ slopes.T)

    def estimates(self, structure: Structure, model: Model, fitted: Fitted | None) -> list[tuple[str, float, float]]:
        """The named constants; undetermined ones have no finite deviation."""
        values, deviations = self._values(model), np.zeros(len(self.physical.names))
        if fitted is not None:
            deviations = np.sqrt(np.diag(self._covariance(fitted)))
            deviations[[self.physical.names.index(name) for name in self.undetermined.open]] = np.inf
        return [*zip(self.physical.names, map(float, values), map(float, deviations), strict=True)]

    def written_back(self, believed: Simulation, structure: Structure, fitted: Fitted) -> Simulation:
        """The simulation with the constants of a fit, their accuracy, and the coefficients of the monic plant."""
        simulation = super().written_back(replace(believed, plant=believed.plant.monic), structure, fitted)
        found = self.physical.estimated(self._values(fitted.model), self._covariance(fitted), self.undetermined)
        return replace(simulation, physical=found)

    def identified(self, problem: Problem, task: IdentificationTask) -> Identification:
        """Coefficients by the method asked for, from which the constants follow; where they are fewer, their own fit.

        Raises
        ------
        InputError
            If no constant is free.
        """
        if not self.estimated:
            raise InputError("no constant is free", where=task.believed.source, hint="take one out of fixed")
        task = replace(task, believed=replace(task.believed, plant=task.believed.plant.monic))
        if not self._one_to_one:
            found = identify_by_simulation(problem, task)
            return analysed(replace(found, method=None), problem.structure, problem.experiments, task.progress)
        found = identify_exactly(problem, task)
        model = self._explaining(Model(problem.structure.coefficients(), constants=self.constants()), found.estimate)
        free, columns = self.structure.free, self._columns
        inverse = np.linalg.inv(self.physical.coefficients.derivatives(self._values(model))[free][:, columns])
        covariance = np.zeros((len(self.physical.names),) * 2)
        covariance[np.ix_(columns, columns)] = inverse @ found.estimate.covariance[free][:, free] @ inverse.T
        physical = self.physical.estimated(self._values(model), covariance, self.undetermined)
        return replace(found, simulation=replace(found.simulation, physical=physical))

    def remarks(self) -> tuple[str, ...]:
        """Which constants are not determined each, and what is done about it."""
        said = self.undetermined.sentence(self.physical.parameters)
        return () if said is None else (said,)


@dataclass(frozen=True)
class PhysicalFreeDecay(PhysicalKind, FreeDecay):
    """The same where nothing drives it."""
