"""Simulations along the directions in which an estimate is uncertain.

A covariance P = F Fᵀ is carried into any function g of the parameters by its differences along the columns of F:
var g = Σ_k (g(θ + ε F_k) − g(θ − ε F_k))²/(4 ε²). For small ε it is first-order propagation (Ljung 1999, System
Identification, 2nd ed., section 9.2); for ε = 1 the points are those of Julier and Uhlmann (2004), Proc. IEEE 92, 401.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.pendulum import PARAMETERS
from camid.chain.plant import TransferFunction
from camid.effects.known import declarable_effects
from camid.simulation.model import Simulation

Array = NDArray[np.float64]
Rebuild = Callable[[Array], Simulation]


def states_accuracy(simulation: Simulation) -> bool:
    """Whether a model says how accurate it is: whether an estimate made it, and not a belief."""
    named = simulation.pendulum or simulation.physical or simulation
    stated = named.standard_deviations is not None or named.covariance is not None
    return stated or any(effect.standard_deviations for effect in simulation.effects)


def has_covariance(simulation: Simulation) -> bool:
    """Whether the covariance of what describes the plant is known."""
    return (simulation.pendulum or simulation.physical or simulation).covariance is not None


def varied(simulation: Simulation, share: float) -> Iterator[tuple[Simulation, Simulation]]:
    """The simulation moved to both sides along each direction of its covariance.

    Parameters
    ----------
    simulation : Simulation
    share : float
        Of a standard deviation that it is moved by.
    """
    if has_covariance(simulation):
        values, covariance, rebuild = _plant(simulation)
        for column in _factor(covariance).T:
            yield rebuild(values + share * column), rebuild(values - share * column)
    for index, name, deviation in _effect_deviations(simulation):
        yield (
            _with_parameter(simulation, index, name, share * deviation),
            _with_parameter(simulation, index, name, -share * deviation),
        )


def _plant(simulation: Simulation) -> tuple[Array, Array, Rebuild]:
    """Numbers that describe the plant, their covariance, and the simulation with others."""
    pendulum, physical = simulation.pendulum, simulation.physical
    if pendulum is not None:
        values = np.array([getattr(pendulum, name) for name in PARAMETERS])

        def with_pendulum(numbers: Array) -> Simulation:
            moved = replace(pendulum, **dict(zip(PARAMETERS, map(float, numbers), strict=True)))  # type: ignore[arg-type]
            return replace(simulation, pendulum=moved, plant=moved.transfer_function())

        return values, np.array(pendulum.covariance), with_pendulum
    if physical is not None:

        def with_constants(numbers: Array) -> Simulation:
            moved = replace(physical, parameters=dict(zip(physical.names, map(float, numbers), strict=True)))
            return replace(simulation, physical=moved, plant=moved.transfer_function())

        return physical.values, np.array(physical.covariance), with_constants
    plant, split = simulation.plant, len(simulation.plant.numerator)

    def with_coefficients(numbers: Array) -> Simulation:
        denominator = (plant.denominator[0], *map(float, numbers[split:]))
        return replace(simulation, plant=TransferFunction(tuple(map(float, numbers[:split])), denominator))

    return np.array([*plant.numerator, *plant.denominator[1:]]), np.array(simulation.covariance), with_coefficients


def _factor(covariance: Array) -> Array:
    """F with P = F Fᵀ, shape (p, r), of the directions that are more than rounding."""
    sizes = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.where(sizes > 0.0, sizes, 1.0)
    correlations = covariance / np.outer(scale, scale)
    powers, axes = np.linalg.eigh(0.5 * (correlations + correlations.T))
    kept = powers > 1e-14 * max(float(powers[-1]), 1e-300)
    return np.asarray(sizes[:, None] * axes[:, kept] * np.sqrt(powers[kept]))


def _effect_deviations(simulation: Simulation) -> Iterator[tuple[int, str, float]]:
    """Index of an effect, name of a parameter that is a number, and its standard deviation."""
    for index, effect in enumerate(simulation.effects):
        for name, deviation in (effect.standard_deviations or {}).items():
            is_number = isinstance(effect.parameters.get(name), int | float)
            if is_number and isinstance(deviation, int | float) and 0.0 < deviation < np.inf:
                yield index, name, float(deviation)


def _with_parameter(simulation: Simulation, index: int, name: str, change: float) -> Simulation:
    """The simulation with a parameter of an effect moved, within its bounds."""
    effects, effect = [*simulation.effects], simulation.effects[index]
    moved: dict[str, Any] = dict(effect.parameters)
    kind = declarable_effects().get(effect.identifier)
    known = kind.with_keys(effect.parameters).parameters if kind else ()
    bounds = next(((p.lower, p.upper) for p in known if p.name == name), (-np.inf, np.inf))
    moved[name] = float(np.clip(moved[name] + change, *bounds))
    effects[index] = replace(effect, parameters=moved)
    return replace(simulation, effects=tuple(effects))
