"""The integrator, compiled once for all runs as long as its sources stay the same."""

import hashlib
from collections.abc import Callable
from pathlib import Path

from numba import njit

from .actuator import Array
from .integrator import integrate as compute

Integrator = Callable[..., tuple[Array, Array]]


def _stored() -> Integrator:
    """Return the integrator, compiled once for these sources: numba by itself looks at one file of them only."""
    folder = Path(__file__).parent
    names = ("quantities.py", "actuator.py", "forces.py", "integrator.py")
    digest = hashlib.sha256(__name__.encode() + b"".join((folder / name).read_bytes() for name in names)).digest()
    sources = int.from_bytes(digest[:7], "big")

    @njit(cache=True, error_model="numpy")
    def integrate(
        start: float,
        period: float,
        substeps: int,
        command: Array,
        lead: int,
        straight: bool,
        reference: Array,
        controller: Array,
        disturbance: Array,
        impulses: Array,
        initial: Array,
        plant: Array,
        through: float,
        actuator: Array,
        force: Array,
        friction: Array,
    ) -> tuple[Array, Array]:
        # numba stores a closure under the values that it closes over
        if sources < 0:
            raise ValueError
        return compute(
            start, period, substeps, command, lead, straight, reference, controller, disturbance, impulses, initial,
            plant, through, actuator, force, friction,
        )  # fmt: skip

    return integrate


integrate = _stored()
