"""Plants of named constants: they are what is fitted, and coefficients follow from them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from camid.effects.parameter import Parameter
from camid.errors import InputError
from camid.fitting.fit import Fitted
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.kind import PlantKind
from camid.identification.structure import Structure
from camid.physical.plant import PhysicalPlant
from camid.physical.undetermined import Undetermined
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# What the name of a constant begins with among the numbers that are fitted beside coefficients.
PREFIX = "constant "
# Relative change of a constant for the slope of a coefficient.
DIFFERENCE = 1e-6


@dataclass(frozen=True)
class NamedConstants(PlantKind, ABC):
    """A plant whose behaviour follows from named constants.

    Attributes
    ----------
    physical : PhysicalPlant
        As it is believed.
    structure : Structure
        Of the linear plant, or of small motions: which coefficients depend on a constant that is free, and are
        determined by a recording of this kind.
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

    @property
    @abstractmethod
    def undetermined(self) -> Undetermined:
        """What recordings of this kind leave open of the constants."""

    @abstractmethod
    def coefficients(self, values: Array) -> Array:
        """[b_0 … b_m, a_1 … a_n] of the (linearised) plant for values of all constants, shape (p,)."""

    @property
    @abstractmethod
    def sensitive(self) -> Array:
        """Changes of the coefficients by relative changes of the constants, shape (m + 1 + n, p)."""

    @cached_property
    def estimated(self) -> tuple[str, ...]:
        """Constants that are fitted."""
        return () if self.nothing_free else tuple(n for n in self.physical.free if n not in self.undetermined.held)

    def constants(self) -> dict[str, float]:
        """Values of the named constants, and those of every plant."""
        return {**super().constants(), **{PREFIX + n: float(v) for n, v in self.physical.parameters.items()}}

    def free_constants(self) -> tuple[Parameter, ...]:
        """Those that are fitted; what makes a pole is not negative where it is believed not to be."""
        return (*super().free_constants(), *map(self._parameter, self.estimated))

    def _parameter(self, name: str) -> Parameter:
        value, column = self.physical.parameters[name], self.physical.names.index(name)
        sensitive = self.sensitive[:, column]
        in_poles = bool(np.any(sensitive[self.structure.degree + 1 :] != 0.0))
        lower = 0.0 if value >= 0.0 and in_poles else -np.inf
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
        return self.coefficients(np.array([constants[PREFIX + name] for name in self.physical.names]))

    def all_fixed(self) -> Self:
        """The same with all constants as they are."""
        return replace(self, nothing_free=True)

    def with_values(self, model: Model, values: Array) -> Model:
        """The model with other constants, shape (p,)."""
        constants = {**model.constants, **self._named(values)}
        return replace(model, coefficients=self.completed(model.coefficients, constants), constants=constants)

    def _named(self, values: Array) -> dict[str, float]:
        return {PREFIX + n: float(v) for n, v in zip(self.physical.names, values, strict=True)}

    def values_of(self, model: Model) -> Array:
        """All named constants of a model, shape (p,)."""
        return np.array([model.constants[PREFIX + name] for name in self.physical.names])

    # -- what becomes of a fit ---------------------------------------------------------------------------------------

    def _covariance(self, fitted: Fitted) -> Array:
        """Covariance of all constants, zero for those that were not fitted."""
        names, values = fitted.packing.names, self.physical.names
        rows = [names.index(PREFIX + name) for name in self.estimated if PREFIX + name in names]
        columns = [values.index(name) for name in self.estimated if PREFIX + name in names]
        result = np.zeros((len(values), len(values)))
        result[np.ix_(columns, columns)] = fitted.covariance[np.ix_(rows, rows)]
        return result

    def slopes(self, values: Array) -> Array:
        """Derivatives of the coefficients by the constants, shape (m + 1 + n, p)."""
        centre, columns = self.coefficients(values), []
        for i, value in enumerate(values):
            moved = values.copy()
            moved[i] += DIFFERENCE * (abs(value) or 1.0)
            columns.append((self.coefficients(moved) - centre) / (moved[i] - value))
        return np.column_stack(columns)

    def coefficient_covariance(self, structure: Structure, fitted: Fitted) -> Array:
        """Covariance of all coefficients, to first order in that of the constants."""
        slopes = self.slopes(self.values_of(fitted.model))
        covariance = self._covariance(fitted)
        if not np.all(np.isfinite(covariance)):
            unknown = np.any(slopes[:, ~np.isfinite(np.diag(covariance))] != 0.0, axis=1)
            known = np.nan_to_num(covariance, posinf=0.0, neginf=0.0)
            return np.asarray(np.where(np.outer(unknown, unknown), np.inf, slopes @ known @ slopes.T))
        return np.asarray(slopes @ covariance @ slopes.T)

    def estimates(self, structure: Structure, model: Model, fitted: Fitted | None) -> list[tuple[str, float, float]]:
        """The named constants; undetermined ones have no finite deviation."""
        values, deviations = self.values_of(model), np.zeros(len(self.physical.names))
        if fitted is not None:
            deviations = np.sqrt(np.diag(self._covariance(fitted)))
            deviations[[self.physical.names.index(name) for name in self.undetermined.open]] = np.inf
        return [*zip(self.physical.names, map(float, values), map(float, deviations), strict=True)]

    def written_back(self, believed: Simulation, structure: Structure, fitted: Fitted) -> Simulation:
        """The simulation with the constants of a fit, their accuracy, and the coefficients of the monic plant."""
        simulation = super().written_back(replace(believed, plant=believed.plant.monic), structure, fitted)
        found = self.physical.estimated(self.values_of(fitted.model), self._covariance(fitted), self.undetermined)
        return replace(simulation, physical=found)

    def remarks(self, found: Simulation) -> tuple[str, ...]:
        """Which constants are not determined each, and what is done about it."""
        said = self.undetermined.sentence((found.physical or self.physical).parameters)
        return () if said is None else (said,)

    def refuse_nothing_free(self, task: IdentificationTask) -> None:
        """Refuse to identify where all constants are fixed.

        Raises
        ------
        InputError
            That says so.
        """
        if not self.estimated and not (self.latency_free or self.skew_free):
            raise InputError("no constant is free", where=task.believed.source, hint="take one out of fixed")
