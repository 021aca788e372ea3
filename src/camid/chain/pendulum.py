"""The pendulum that a simulation may declare as its plant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction

Array = NDArray[np.float64]

PARAMETERS = ("natural_frequency", "damping", "gain", "rest")


@dataclass(frozen=True)
class Pendulum:
    """ÿ + 2ξωẏ + ω² sin(y − rest) = gain ω² u (design, section 2), y in radians.

    Attributes
    ----------
    natural_frequency : float
        ω in rad/s, of small motions.
    damping : float
        ξ.
    gain : float
        Static gain of small motions, in rad per unit of u.
    rest : float
        Angle in rad at which it hangs still.
    free : dict of str to bool
        What may be re-estimated; what is not named may be.
    standard_deviations : dict of str to float or None
    covariance : list of list of float or None
        In the order of :data:`PARAMETERS`.
    """

    natural_frequency: float
    damping: float
    gain: float = 1.0
    rest: float = 0.0
    free: Mapping[str, bool] = field(default_factory=dict)
    standard_deviations: Mapping[str, float] | None = None
    covariance: list[list[float]] | None = None

    def is_free(self, parameter: str) -> bool:
        """Whether a parameter may be re-estimated."""
        return bool(self.free.get(parameter, True))

    def transfer_function(self) -> TransferFunction:
        """Plant of small motions about rest."""
        square = self.natural_frequency**2
        return TransferFunction((self.gain * square,), (1.0, 2.0 * self.damping * self.natural_frequency, square))

    def freedom(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which coefficients of :meth:`transfer_function` may be re-estimated."""
        return np.array([self.is_free("gain")]), np.array(
            [False, self.is_free("damping"), self.is_free("natural_frequency")]
        )

    def coefficient_rows(self) -> Iterator[tuple[str, float, float | None, str]]:
        """Name, value, standard deviation where there is one, and unit of each parameter."""
        units = {"natural_frequency": "rad/s", "damping": "", "gain": "y/u", "rest": "y"}
        for name, unit in units.items():
            known = None if self.standard_deviations is None else self.standard_deviations.get(name)
            deviation = known if self.is_free(name) else 0.0
            yield name.replace("_", " "), getattr(self, name), deviation, unit

    def to_mapping(self) -> dict[str, Any]:
        """Part of a simulation file: the content of ``plant``."""
        content: dict[str, Any] = {"pendulum": {name: float(getattr(self, name)) for name in PARAMETERS}}
        if self.standard_deviations is not None:
            content["standard_deviations"] = {k: float(v) for k, v in self.standard_deviations.items()}
        if self.covariance is not None:
            content["covariance"] = self.covariance
        content["free"] = {name: self.is_free(name) for name in PARAMETERS}
        return content

    def estimated(self, plant: TransferFunction, rest: float, covariance: Array, *, gain_fixed: bool) -> Pendulum:
        """The same pendulum with estimated coefficients.

        Parameters
        ----------
        plant : TransferFunction
            Monic, of small motions.
        rest : float
            rad.
        covariance : ndarray, shape (4, 4)
            Of b_0, a_1, a_2 and the rest; zero where nothing was estimated.
        gain_fixed : bool
            Whether b_0 follows a_2, so that the gain is what it was.
        """
        (b0,), (_, a1, a2) = plant.numerator, plant.denominator
        frequency = float(np.sqrt(a2))
        damping, gain = a1 / (2.0 * frequency), b0 / a2
        derivatives = np.array(
            [
                [0.0, 0.0, 0.5 / frequency, 0.0],
                [0.0, 0.5 / frequency, -0.5 * damping / a2, 0.0],
                [0.0 if gain_fixed else 1.0 / a2, 0.0, 0.0 if gain_fixed else -gain / a2, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
        table = derivatives @ covariance @ derivatives.T
        known = bool(np.all(np.isfinite(table)))
        deviations = dict(zip(PARAMETERS, np.sqrt(np.abs(np.diag(table))).tolist(), strict=True)) if known else None
        return replace(
            self,
            natural_frequency=frequency,
            damping=float(damping),
            gain=self.gain if gain_fixed else float(gain),
            rest=rest,
            standard_deviations=deviations,
            covariance=table.tolist() if known else None,
        )
