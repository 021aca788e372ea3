"""Systems of python-control as the plant of a simulation."""

from __future__ import annotations

import sys
from typing import Any

from camid.chain.plant import TransferFunction
from camid.errors import InputError


def is_control_system(value: Any) -> bool:
    """Whether this is a system of python-control (which is not loaded here: who has such a system has loaded it)."""
    library = sys.modules.get("control")
    names = ("InputOutputSystem", "FrequencyResponseData", "TransferFunction", "StateSpace")
    kinds = tuple(getattr(library, name) for name in names if hasattr(library, name))
    return isinstance(value, (TransferFunction, *kinds))


def continuous_plant(system: Any, where: str) -> TransferFunction:
    """Plant of a python-control system; InputError if it is not continuous, proper, and of one input and output."""
    if isinstance(system, TransferFunction):
        return system
    kinds = tuple(
        getattr(sys.modules.get("control"), name, TransferFunction) for name in ("TransferFunction", "StateSpace")
    )
    if not isinstance(system, kinds):
        raise InputError(
            f"a {type(system).__name__} is not a plant",
            where=where,
            hint="give a continuous-time control.TransferFunction or control.StateSpace",
        )
    try:
        return TransferFunction.from_control(system)
    except ValueError as error:
        raise InputError(str(error), where=where) from None
