"""What every kind of plant in a simulation file is refused for."""

from __future__ import annotations

import numpy as np

from camid.chain.observer import acceleration_of
from camid.chain.plant import TransferFunction
from camid.errors import InputError
from camid.simulation.yaml_file import Where

# Rate of an observer that holds a plant, as a multiple of its fastest pole in the right half plane.
OF_FASTEST = 1.5


def refuse_unstable(plant: TransferFunction, where: str) -> None:
    """Refuse poles in the right half plane of a plant without a controller; integrators and undamped modes are none.

    Raises
    ------
    InputError
        That names them.
    """
    unstable = plant.unstable_poles()
    if unstable.size:
        shown = ", ".join(f"{p.real:.4g}{p.imag:+.4g}j" if p.imag else f"{p.real:.4g}" for p in unstable)
        hint = "check the signs; where a controller holds the plant, declare it"
        if acceleration_of(plant) is not None:
            rate = OF_FASTEST * float(np.max(unstable.real))
            hint += f", or pull the simulation towards the recording: observer: {{rate: {rate:.2g}}}"
        raise InputError(f"the transfer function is unstable: poles at {shown} rad/s", where=where, hint=hint)


def refuse_table(table: list[list[float]], size: int, rows: str, where: Where) -> None:
    """Refuse a covariance that is not a table of this size; ``rows`` says what its rows are of.

    Raises
    ------
    InputError
        That says so.
    """
    if [len(row) for row in table] != [size] * size:
        raise InputError(
            f"this is not a table of {size} by {size} numbers", where=where("plant", "covariance"), hint=rows
        )
