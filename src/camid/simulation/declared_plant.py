"""The plant of a simulation file: a transfer function or a pendulum, with what is known of its accuracy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.pendulum import PARAMETERS, Pendulum
from camid.chain.plant import TransferFunction
from camid.errors import InputError, nearest_match

Array = NDArray[np.float64]
Where = Callable[..., str]


def read_plant(written: Mapping[str, Any], where: Where) -> dict[str, Any]:
    """What a file says of the plant, as arguments of :class:`camid.simulation.model.Simulation`.

    Parameters
    ----------
    written : mapping
        Content of the key ``plant``, valid by the schema.
    where : callable
        File and line of a path of keys.

    Raises
    ------
    InputError
        If there is no plant or two, it is improper or unstable, or accuracies have another shape than it.
    """
    kinds = [kind for kind in ("transfer_function", "pendulum") if kind in written]
    if not kinds:
        raise InputError("the key 'transfer_function' is missing", where=where("plant"), hint="add it, or a pendulum")
    if len(kinds) == 2:
        raise InputError("a transfer function and a pendulum", where=where("plant"), hint="keep one")
    return _pendulum(written, where) if kinds == ["pendulum"] else _transfer_function(written, where)


def _pendulum(written: Mapping[str, Any], where: Where) -> dict[str, Any]:
    values = {str(k): float(v) for k, v in written["pendulum"].items()}
    if values.get("gain", 1.0) == 0.0:
        raise InputError("gain = 0: no input moves it", where=where("plant", "pendulum", "gain"), hint="give it")
    tables: dict[str, dict[str, Any]] = {}
    for key, kind in (("free", bool), ("standard_deviations", float)):
        given = written.get(key, {})
        for name, value in given.items():
            if name not in PARAMETERS:
                raise InputError(
                    f"unknown key '{name}'", where=where("plant", key), hint=nearest_match(name, PARAMETERS)
                )
            if isinstance(value, list | tuple):
                raise InputError(
                    f"'{name}' is a list", where=where("plant", key), hint="a pendulum's parameters are single numbers"
                )
            tables.setdefault(key, {})[str(name)] = kind(value)
    covariance = written.get("covariance")
    if covariance is not None and [len(row) for row in covariance] != [len(PARAMETERS)] * len(PARAMETERS):
        raise InputError(
            f"this is no table of {len(PARAMETERS)} by {len(PARAMETERS)} numbers",
            where=where("plant", "covariance"),
            hint=f"it has a row for each of {', '.join(PARAMETERS)}",
        )
    pendulum = Pendulum(
        **values,
        free=tables.get("free", {}),
        standard_deviations=tables.get("standard_deviations"),
        covariance=None if covariance is None else [[float(v) for v in row] for row in covariance],
    )
    free_numerator, free_denominator = pendulum.freedom()
    return {
        "plant": pendulum.transfer_function(),
        "pendulum": pendulum,
        "free_numerator": free_numerator,
        "free_denominator": free_denominator,
    }


def _transfer_function(written: Mapping[str, Any], where: Where) -> dict[str, Any]:
    from camid.simulation.model import default_freedom

    raw = {k: np.array([float(c) for c in written["transfer_function"][k]]) for k in ("numerator", "denominator")}
    if raw["denominator"][0] == 0.0:
        raise InputError(
            "the first coefficient is zero", where=where("plant", "transfer_function", "denominator"), hint="remove it"
        )
    try:
        plant = TransferFunction(tuple(raw["numerator"]), tuple(raw["denominator"]))
        _ = plant.monic  # refuses a leading coefficient so small that the others overflow
    except ValueError as error:
        raise InputError(
            str(error), where=where("plant", "transfer_function"), hint="coefficients stand in descending powers of s"
        ) from None
    unstable = plant.unstable_poles()
    if unstable.size:
        shown = ", ".join(f"{p.real:.4g}{p.imag:+.4g}j" if p.imag else f"{p.real:.4g}" for p in unstable)
        raise InputError(
            f"the transfer function is unstable: poles at {shown} rad/s",
            where=where("plant", "transfer_function", "denominator"),
            hint="all poles need a real part of at most zero; check the signs",
        )
    leading_zeros = len(raw["numerator"]) - len(plant.numerator)
    free_numerator, free_denominator = default_freedom(plant)
    if "free" in written:
        given = written["free"]
        _check_shape(given, raw, where("plant", "free"))
        free_numerator = np.array(given["numerator"], bool)[leading_zeros:]
        free_denominator = np.array(given["denominator"], bool)
        free_denominator[0] = False
    deviations = written.get("standard_deviations")
    if deviations is not None:
        _check_shape(deviations, raw, where("plant", "standard_deviations"))
        deviations = {k: [float(v) for v in deviations[k]] for k in ("numerator", "denominator")}
        deviations["numerator"] = deviations["numerator"][leading_zeros:]
    covariance = written.get("covariance")
    if covariance is not None:
        size = sum(len(c) for c in raw.values()) - 1
        if [len(row) for row in covariance] != [size] * size:
            raise InputError(
                f"this is no table of {size} by {size} numbers",
                where=where("plant", "covariance"),
                hint="it has a row a coefficient, but for the leading one of the denominator",
            )
        covariance = [[float(v) for v in row[leading_zeros:]] for row in covariance[leading_zeros:]]
    return {
        "plant": plant,
        "free_numerator": free_numerator,
        "free_denominator": free_denominator,
        "standard_deviations": deviations,
        "covariance": covariance,
    }


def _check_shape(given: Mapping[str, Any], raw: Mapping[str, Array], where: str) -> None:
    for key in given:
        if key not in raw:
            raise InputError(f"unknown key '{key}'", where=where, hint=nearest_match(key, raw))
    for key, coefficients in raw.items():
        if key not in given:
            raise InputError(f"the key '{key}' is missing", where=where, hint="give one value a coefficient")
        if not isinstance(given[key], list | tuple) or len(given[key]) != len(coefficients):
            raise InputError(
                f"'{key}' has not the {len(coefficients)} entries of the transfer function",
                where=where,
                hint="give one value a coefficient",
            )
