"""A fit as a simulation: its plant in the form in which the plant was declared, with standard deviations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.fitting.fit import Fitted
from camid.identification.structure import Structure
from camid.simulation.model import Simulation

Array = NDArray[np.float64]


def with_plant(believed: Simulation, structure: Structure, fitted: Fitted) -> Simulation:
    """The simulation with the plant of a fit, and its accuracy where the data determine it."""
    lead, model = believed.plant.denominator[0], fitted.model
    plant = structure.plant(model.coefficients)
    if believed.pendulum is not None:
        rest = believed.pendulum.rest if model.rest is None else model.rest
        pendulum = believed.pendulum.estimated(
            plant, rest, _pendulum_covariance(fitted, structure), gain_fixed=not structure.free_numerator[0]
        )
        return replace(believed, pendulum=pendulum, plant=pendulum.transfer_function())
    count = int(np.count_nonzero(structure.free))
    covariance = np.square(lead) * fitted.covariance[:count, :count]
    finite = bool(np.all(np.isfinite(covariance)))
    return replace(
        believed,
        plant=TransferFunction(tuple(lead * b for b in plant.numerator), tuple(lead * a for a in plant.denominator)),
        standard_deviations=_in_shape(structure, np.sqrt(np.abs(np.diag(covariance)))) if finite else None,
        covariance=full_covariance(structure, covariance).tolist() if finite else None,
    )


def _pendulum_covariance(fitted: Fitted, structure: Structure) -> Array:
    """Covariance of b_0, a_1, a_2 and the angle at rest, shape (4, 4)."""
    free = [*np.flatnonzero(structure.free), *([3] if "rest" in fitted.packing.names else [])]
    rows = [*range(int(np.count_nonzero(structure.free)))]
    if "rest" in fitted.packing.names:
        rows.append(fitted.packing.names.index("rest"))
    result = np.zeros((4, 4))
    result[np.ix_(free, free)] = fitted.covariance[np.ix_(rows, rows)]
    return result


def _in_shape(structure: Structure, deviations: Array) -> dict[str, list[float]]:
    every = np.zeros(len(structure.free))
    every[structure.free] = deviations
    split = structure.degree + 1
    return {"numerator": every[:split].tolist(), "denominator": [0.0, *every[split:].tolist()]}


def full_covariance(structure: Structure, covariance: Array) -> Array:
    """Covariance of all coefficients from that of the free ones."""
    free = np.flatnonzero(structure.free)
    result = np.zeros((len(structure.free), len(structure.free)))
    result[np.ix_(free, free)] = covariance
    return result
