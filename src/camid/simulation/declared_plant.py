"""The plant of a simulation file: a transfer function, a pendulum or named constants, with its accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from camid.chain.pendulum import PARAMETERS, Pendulum
from camid.chain.plant import TransferFunction
from camid.errors import InputError
from camid.simulation.declared_physical import declared_physical
from camid.simulation.model import default_freedom
from camid.simulation.refused_plant import refuse_table
from camid.simulation.yaml_file import Where

if TYPE_CHECKING:
    from camid.simulation.plant_schema import PendulumPart, PhysicalPart, TransferFunctionPart

POLYNOMIALS = ("numerator", "denominator")


def declared_plant(
    written: TransferFunctionPart | PendulumPart | PhysicalPart, where: Where, columns: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """What a file says about the plant, as arguments of :class:`camid.simulation.model.Simulation`.

    Parameters
    ----------
    written : TransferFunctionPart, PendulumPart or PhysicalPart
        The key ``plant``.
    where : callable
        Gives file, line and key of a path of keys.
    columns : mapping of str to str, optional
        Several columns of the sensor and what they read, as expressions.

    Raises
    ------
    InputError
        If the plant is improper, or accuracies have another shape than it.
    """
    from camid.simulation.plant_schema import PendulumPart, PhysicalPart

    if columns is not None and (not isinstance(written, PhysicalPart) or written.physical.equations is None):
        raise InputError(
            "several columns read states of a plant of equations, and this plant has none",
            where=where("sensor", "columns"),
            hint="write plant: {physical: {equations: …}}, or name one column",
        )
    if isinstance(written, PendulumPart):
        return _pendulum(written, where)
    if isinstance(written, PhysicalPart):
        return declared_physical(written, where, columns or {})
    return _transfer_function(written, where)


def _pendulum(written: PendulumPart, where: Where) -> dict[str, Any]:
    if written.pendulum.gain == 0.0:
        raise InputError("gain = 0: no input moves it", where=where("plant", "pendulum", "gain"), hint="give it")
    if written.covariance is not None:
        rows = f"it has one row for each of {', '.join(PARAMETERS)}"
        refuse_table(written.covariance, len(PARAMETERS), rows, where)
    deviations = written.standard_deviations
    pendulum = Pendulum(
        **written.pendulum.model_dump(),
        free={} if written.free is None else written.free.model_dump(exclude_unset=True),
        standard_deviations=None if deviations is None else deviations.model_dump(exclude_unset=True) or None,
        covariance=written.covariance,
    )
    free_numerator, free_denominator = pendulum.freedom()
    return {
        "plant": pendulum.transfer_function(),
        "pendulum": pendulum,
        "free_numerator": free_numerator,
        "free_denominator": free_denominator,
    }


def _transfer_function(written: TransferFunctionPart, where: Where) -> dict[str, Any]:
    plant = _proper_plant(written, where)
    raw = written.transfer_function
    leading_zeros = len(raw.numerator) - len(plant.numerator)
    free_numerator, free_denominator = default_freedom(plant)
    if written.free is not None:
        _check_shape(written, "free", where)
        free_numerator = np.array(written.free.numerator, bool)[leading_zeros:]
        free_denominator = np.array(written.free.denominator, bool)
        free_denominator[0] = False
    deviations = None
    if written.standard_deviations is not None:
        _check_shape(written, "standard_deviations", where)
        deviations = written.standard_deviations.model_dump()
        deviations["numerator"] = deviations["numerator"][leading_zeros:]
    covariance = written.covariance
    if covariance is not None:
        rows = "it has one row per coefficient, except the leading one of the denominator"
        refuse_table(covariance, len(raw.numerator) + len(raw.denominator) - 1, rows, where)
        covariance = [row[leading_zeros:] for row in covariance[leading_zeros:]]
    return {
        "plant": plant,
        "free_numerator": free_numerator,
        "free_denominator": free_denominator,
        "standard_deviations": deviations,
        "covariance": covariance,
    }


def _proper_plant(written: TransferFunctionPart, where: Where) -> TransferFunction:
    coefficients = written.transfer_function
    if coefficients.denominator[0] == 0.0:
        raise InputError(
            "the first coefficient is zero", where=where("plant", "transfer_function", "denominator"), hint="remove it"
        )
    # Whoever states what is free or how sure it is, of every coefficient, means the zero.
    stated = written.free or written.standard_deviations or written.covariance
    if coefficients.numerator[0] == 0.0 and any(coefficients.numerator) and stated is None:
        following = coefficients.numerator[1]
        comma = following > 0.0 and following == int(following)
        raise InputError(
            "the first coefficient is zero",
            where=where("plant", "transfer_function", "numerator"),
            hint="remove it" + (f"; or is 0.{int(following)} meant, with a point?" if comma else ""),
        )
    try:
        plant = TransferFunction(tuple(coefficients.numerator), tuple(coefficients.denominator))
        _ = plant.monic  # refuses a leading coefficient so small that the others overflow
    except ValueError as error:
        raise InputError(
            str(error), where=where("plant", "transfer_function"), hint="coefficients are in descending powers of s"
        ) from None
    return plant


def _check_shape(written: TransferFunctionPart, key: str, where: Where) -> None:
    for name in POLYNOMIALS:
        count = len(getattr(written.transfer_function, name))
        if len(getattr(getattr(written, key), name)) != count:
            raise InputError(
                f"'{name}' does not have the {count} entries of the transfer function",
                where=where("plant", key),
                hint="give one value per coefficient",
            )
