"""A plant of named constants, as a simulation declares it and an estimate returns it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.physical.equations import Equations, sensitive_to, transfer_function_of
from camid.physical.expressions import parsed, symbols
from camid.physical.linear_form import Coefficients, LinearForm, coefficients_of
from camid.physical.undetermined import Undetermined, undetermined

Array = NDArray[np.float64]

# Step of the differences that carry an uncertainty into a combination, as a share of a constant.
DIFFERENCE = 1e-6


@dataclass(frozen=True)
class PhysicalPlant:
    """Named constants, and the plant that they make.

    Attributes
    ----------
    parameters : dict of str to float
        Values, in the order in which they were written.
    form : LinearForm or Equations
        How the plant depends on them.
    fixed : tuple of str
        Constants that keep their values.
    units : dict of str to str
        Of the constants, for people.
    standard_deviations : dict of str to float or None
        Of those that were estimated and determined.
    covariance : list of list of float or None
        Of all constants in their order, zero for those that were not estimated.
    left_open : Undetermined or None
        What the recordings of an estimate left open.
    """

    parameters: Mapping[str, float]
    form: LinearForm | Equations
    fixed: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    standard_deviations: Mapping[str, float] | None = None
    covariance: list[list[float]] | None = None
    left_open: Undetermined | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of the constants, in the order of :attr:`values`."""
        return tuple(self.parameters)

    @property
    def values(self) -> Array:
        """Of the constants, shape (p,)."""
        return np.array([self.parameters[name] for name in self.parameters], dtype=float)

    @property
    def free(self) -> tuple[str, ...]:
        """Constants that may be re-estimated."""
        return tuple(name for name in self.parameters if name not in self.fixed)

    @property
    def equations(self) -> Equations | None:
        """The nonlinear equations, where it has some."""
        return self.form if isinstance(self.form, Equations) else None

    @property
    def coefficients(self) -> Coefficients:
        """How the coefficients of the monic linear plant follow from the constants."""
        assert not isinstance(self.form, Equations)
        return coefficients_of(self.form)

    def transfer_function(self) -> TransferFunction:
        """The plant as it is written, nonlinear equations about their start; ValueError where there is none."""
        if self.equations is not None:
            return transfer_function_of(self.equations, self.values)
        return self.coefficients.written(self.values)

    def freedom(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which coefficients of the monic plant depend on a constant that is free."""
        columns = [self.names.index(name) for name in self.free]
        if self.equations is not None:
            varies = np.any(sensitive_to(self.equations, self.values)[:, columns] != 0.0, axis=1)
            split = len(self.transfer_function().numerator)
        else:
            varies = np.any(self.coefficients.sensitive(self.values)[:, columns] != 0.0, axis=1)
            split = self.coefficients.degree + 1
        return varies[:split], np.concatenate([[False], varies[split:]])

    def undetermined(self, rows: NDArray[np.bool_]) -> Undetermined:
        """What the coefficients in ``rows``, shape (m + 1 + n,), leave open of the free constants."""
        return undetermined(self.coefficients, self.names, self.values, self.free, rows)

    def coefficient_rows(self) -> Iterator[tuple[str, float, float | None, str]]:
        """Name, value, standard deviation (zero where it is fixed, None where it is not known), and unit of each."""
        for name, value in self.parameters.items():
            deviation = (self.standard_deviations or {}).get(name, 0.0 if name in self.fixed else None)
            yield name.replace("_", " "), float(value), deviation, self.units.get(name, "")

    def combination(self, text: str) -> tuple[float, float | None]:
        """Value of an expression of the constants, and its standard deviation where their covariance is known."""
        arguments = symbols(self.names)
        expression = parsed(text, self.names)

        def value(constants: Array) -> float:
            return float(expression.subs(dict(zip(arguments, map(float, constants), strict=True))))

        centre = value(self.values)
        if self.covariance is None:
            return centre, None
        slopes = np.zeros(len(self.values))
        for i, constant in enumerate(self.values):
            step = DIFFERENCE * (abs(constant) or 1.0)
            moved = self.values
            moved[i] += step
            slopes[i] = (value(moved) - centre) / step
        return centre, float(np.sqrt(max(slopes @ np.array(self.covariance) @ slopes, 0.0)))

    def estimated(self, values: Array, covariance: Array, left_open: Undetermined) -> PhysicalPlant:
        """The same plant with estimated constants.

        Parameters
        ----------
        values : ndarray, shape (p,)
        covariance : ndarray, shape (p, p)
            Zero for constants that were not estimated; given those that are held.
        left_open : Undetermined
            No standard deviation is stated for constants that are not determined each.
        """
        deviations = {
            name: float(np.sqrt(covariance[i, i]))
            for i, name in enumerate(self.names)
            if name not in left_open.open and 0.0 < covariance[i, i] < np.inf
        }
        known = bool(np.all(np.isfinite(covariance)))
        return replace(
            self,
            parameters=dict(zip(self.names, map(float, values), strict=True)),
            standard_deviations=deviations or None,
            covariance=covariance.tolist() if known else None,
            left_open=left_open,
        )

    def combination_rows(self) -> Iterator[tuple[str, float, float | None]]:
        """Expression, value and standard deviation of what is determined where constants are not."""
        for text in () if self.left_open is None else self.left_open.combinations:
            yield text, *self.combination(text)

    def to_mapping(self) -> dict[str, Any]:
        """Part of a simulation file: the content of ``plant``."""
        content: dict[str, Any] = {"parameters": {name: float(value) for name, value in self.parameters.items()}}
        if self.units:
            content["units"] = dict(self.units)
        content |= self.form.to_mapping()
        if self.fixed:
            content["fixed"] = list(self.fixed)
        plant: dict[str, Any] = {"physical": content}
        if self.standard_deviations:
            plant["standard_deviations"] = {k: float(v) for k, v in self.standard_deviations.items()}
        if self.covariance is not None:
            plant["covariance"] = self.covariance
        return plant
