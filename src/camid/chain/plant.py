"""Plants: transfer functions in descending powers of s, to and from python-control."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camid.errors import need

if TYPE_CHECKING:
    import control

# Relative size of a real part that counts as zero: an undamped mode is not an unstable one, and a repeated root of the
# denominator is only known to the square root of the rounding error.
STABILITY_TOLERANCE = 1e-6
# Relative size below which a root at zero, or a Markov parameter, of a state-space model is rounding.
CONVERSION_ROUNDING = 1e-7


def polynomial_roots(coefficients: Sequence[float] | NDArray[np.float64]) -> NDArray[np.complex128]:
    """Roots of a polynomial in descending powers, leading coefficient not zero; up to degree two in closed form."""
    degree = len(coefficients) - 1
    if degree > 2:
        return np.roots(coefficients).astype(complex)
    if degree < 2:
        return np.array([-coefficients[1] / coefficients[0]] if degree == 1 else [], dtype=complex)
    half, constant = -0.5 * coefficients[1] / coefficients[0], coefficients[2] / coefficients[0]
    square = half * half - constant
    if square < 0.0:
        return np.array([complex(half, sqrt(-square)), complex(half, -sqrt(-square))])
    far = half + (sqrt(square) if half > 0.0 else -sqrt(square))
    # The product of the roots gives the near one without cancellation.
    return np.array([far, constant / far if far != 0.0 else 0.0], dtype=complex)


@dataclass(frozen=True)
class TransferFunction:
    """Rational transfer function B(s)/A(s) of a plant with one input and one output.

    Attributes
    ----------
    numerator, denominator : tuple of float
        Coefficients in descending powers of s, with no leading zeros.

    Raises
    ------
    ValueError
        If a polynomial is zero or not finite, or the degree of the numerator exceeds that of the denominator.
    """

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("numerator", "denominator"):
            given = getattr(self, name)
            # A diagnosis makes some ten thousand of tuples, for which an array takes longer than all the rest.
            coefficients = (
                [*map(float, given)] if isinstance(given, tuple) else np.ravel(np.asarray(given, float)).tolist()
            )
            if not all(map(isfinite, coefficients)):
                raise ValueError(f"the {name} has a coefficient that is not a finite number")
            leading = next((i for i, c in enumerate(coefficients) if c != 0.0), None)
            if leading is None:
                raise ValueError(f"the {name} is zero")
            object.__setattr__(self, name, tuple(coefficients[leading:]))
        if len(self.numerator) > len(self.denominator):
            raise ValueError(
                f"the transfer function is improper: numerator of degree {len(self.numerator) - 1}, "
                f"denominator of degree {len(self.denominator) - 1}"
            )

    @property
    def order(self) -> int:
        """Number of poles."""
        return len(self.denominator) - 1

    @cached_property
    def monic(self) -> TransferFunction:
        """The same function with a leading denominator coefficient of one."""
        lead = self.denominator[0]
        if lead == 1.0:
            return self
        return TransferFunction(tuple(b / lead for b in self.numerator), tuple(a / lead for a in self.denominator))

    def poles(self) -> NDArray[np.complex128]:
        """Poles in rad/s, shape (order,)."""
        return polynomial_roots(self.denominator)

    @cached_property
    def fastest_pole(self) -> float:
        """Magnitude of the pole that lies farthest from zero, in rad/s; zero without poles."""
        return float(np.max(np.abs(self.poles()), initial=0.0))

    def zeros(self) -> NDArray[np.complex128]:
        """Finite zeros in rad/s."""
        return polynomial_roots(self.numerator)

    def unstable_poles(self) -> NDArray[np.complex128]:
        """Poles in the open right half plane; integrators and undamped modes do not count."""
        poles = self.poles()
        return poles[poles.real > STABILITY_TOLERANCE * np.abs(poles)]

    def static_gain(self) -> float:
        """B(0)/A(0); infinite for a plant with an integrator."""
        return self.numerator[-1] / self.denominator[-1] if self.denominator[-1] != 0.0 else float("inf")

    def frequency_response(self, angular_frequency: ArrayLike) -> NDArray[np.complex128]:
        """G(jω) at the given angular frequencies in rad/s, in their shape."""
        s = 1j * np.asarray(angular_frequency, dtype=float)
        return np.polyval(self.numerator, s) / np.polyval(self.denominator, s)

    def to_control(self) -> control.TransferFunction:
        """The same plant as a continuous-time python-control transfer function."""
        need("a plant for python-control", "control")
        import control

        return control.tf(list(self.numerator), list(self.denominator))

    @classmethod
    def from_control(cls, system: control.TransferFunction | control.StateSpace) -> TransferFunction:
        """Take a continuous-time python-control system with one input and one output.

        Coefficients that conversion from state space leaves at rounding level count as zero.

        Raises
        ------
        ValueError
            If the system has several inputs or outputs, or is in discrete time.
        """
        import control

        if (system.ninputs, system.noutputs) != (1, 1):
            raise ValueError(
                f"the system has {system.ninputs} inputs and {system.noutputs} outputs; camid identifies one input and "
                "one output: take one pair, e.g. system[0, 0]"
            )
        if system.isdtime(strict=True):
            raise ValueError(
                "the system is in discrete time; camid works with the continuous-time plant: give that, or its order"
            )
        if isinstance(system, control.TransferFunction):
            return cls(tuple(system.num[0][0]), tuple(system.den[0][0]))
        rational = control.tf(system)
        numerator, denominator = (np.trim_zeros(np.array(c[0][0], float), "f") for c in (rational.num, rational.den))
        # The numerator has as many leading zeros as the impulse response has vanishing Markov parameters D, CB, CAB, …
        numerator = numerator[max(len(numerator) + _vanishing_parameters(system) - len(denominator), 0) :]
        for coefficients in (numerator, denominator):
            sizes = np.abs(np.roots(coefficients))
            at_zero = np.sum(sizes <= CONVERSION_ROUNDING * np.max(np.abs(system.poles()), initial=0.0))
            coefficients[len(coefficients) - int(at_zero) :] = 0.0
        return cls(tuple(numerator), tuple(denominator))

    def __mul__(self, other: TransferFunction) -> TransferFunction:
        """Two plants in series (paper equation (25))."""
        return TransferFunction(
            tuple(np.polymul(self.numerator, other.numerator)), tuple(np.polymul(self.denominator, other.denominator))
        )

    def __add__(self, other: TransferFunction) -> TransferFunction:
        """Two plants with one input, whose outputs add up."""
        numerator = np.polyadd(
            np.polymul(self.numerator, other.denominator), np.polymul(other.numerator, self.denominator)
        )
        return TransferFunction(
            tuple(np.trim_zeros(numerator, "f")), tuple(np.polymul(self.denominator, other.denominator))
        )


def _vanishing_parameters(system: control.StateSpace) -> int:
    """How many of the first Markov parameters are zero except for rounding."""
    if system.D[0, 0] != 0.0:
        return 0
    state, size = np.array(system.B), np.abs(system.B)
    for i in range(1, system.nstates + 1):
        if abs((system.C @ state)[0, 0]) > CONVERSION_ROUNDING * (np.abs(system.C) @ size)[0, 0]:
            return i
        state, size = system.A @ state, np.abs(system.A) @ size
    return system.nstates


def second_order(static_gain: float, natural_frequency: float, damping: float) -> TransferFunction:
    """Second-order mode, paper equations (15) and (26).

    Parameters
    ----------
    static_gain : float
        K, in units of the output over units of the input.
    natural_frequency : float
        ω0 in rad/s.
    damping : float
        Damping ratio ξ, without unit.
    """
    return TransferFunction(
        (static_gain * natural_frequency**2,), (1.0, 2.0 * damping * natural_frequency, natural_frequency**2)
    )
