"""What an identification returns to people and machines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from camid.identification.accuracy import characteristics
from camid.identification.estimate import Estimate
from camid.simulation import Simulation

# A mean of the residual is worth a warning if it is this many standard deviations off and this share of the power.
OFFSET_SIGNIFICANCE = 5.0
OFFSET_SHARE = 0.02


@dataclass(frozen=True)
class Identification:
    """What ``camid.identify`` returns.

    Attributes
    ----------
    simulation : Simulation
        The identified model, ready to be written as YAML: coefficients, standard deviations, covariance.
    estimate : Estimate
        The bare estimate with its residuals.
    converged : bool
        False: do not use the numbers.
    period : float
        Seconds.
    rows_fitted : int
    nrmse : float
        Root mean square residual over the standard deviation of the recorded output, on the fitted rows.
    nrmse_validation : float or None
        The same on the validation rows, where the simulation declares some.
    """

    simulation: Simulation
    estimate: Estimate
    converged: bool
    period: float
    rows_fitted: int
    nrmse: float
    nrmse_validation: float | None

    def characteristics(self) -> list[dict[str, Any]]:
        """Static gain, natural frequencies, damping ratios and real poles with their standard deviations."""
        return characteristics(self.estimate.plant, self.estimate.covariance)

    def at_stability_limit(self) -> bool:
        """Whether a free coefficient of the denominator ended at zero, where the data left to themselves go beyond."""
        plant, free = self.estimate.plant, self.estimate.free[len(self.estimate.plant.numerator) :]
        return bool(np.any((np.array(plant.denominator[1:]) == 0.0) & free))

    def warnings(self) -> list[str]:
        """What changes the worth of the numbers, a sentence each."""
        sentences = []
        if not self.converged:
            sentences.append(
                "the iteration did not converge; the numbers are not to be used (another order? more excitation?)"
            )
        if self.at_stability_limit():
            sentences.append(
                "a pole lies at the limit of stability: an integrator or an undamped mode? For an integrator, write a "
                "zero at the end of the denominator"
            )
        for rival in self.estimate.rivals:
            modes = ", ".join(f"{value:.5g}" for value in rival.natural_frequencies)
            sentences.append(
                f"the data do not tell this plant from one with poles of {modes} rad/s (weight {rival.weight:.2g}): "
                "another sampling period would"
            )
        for residual in self.estimate.residuals:
            if not np.max(np.abs(residual), initial=0.0) < 1e100:
                continue  # a method without safeguard ran away, and its squares would overflow
            mean, power = float(np.mean(residual)), float(np.mean(residual**2))
            centred = residual - mean
            spread = float(centred @ centred)
            correlation = float(centred[1:] @ centred[:-1]) / spread if spread > 0.0 else 0.0
            # A slow residual has fewer independent samples than rows.
            effective = len(residual) * (1.0 - correlation) / (1.0 + correlation)
            if mean**2 > OFFSET_SHARE * power and mean**2 > OFFSET_SIGNIFICANCE**2 * (power - mean**2) / effective:
                sentences.append(
                    f"the residual has a mean of {mean:.3g}, {100.0 * mean**2 / power:.0f} % of its power: the "
                    "recording has an offset, which a linear model at rest has not; remove the means of input and "
                    "output"
                )
        return sentences

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        plant = self.simulation.plant
        content = {
            "schema": 1,
            "converged": self.converged,
            "iterations": self.estimate.iterations,
            "numerator": list(plant.numerator),
            "denominator": list(plant.denominator),
            "standard_deviations": self.simulation.standard_deviations,
            "covariance": self.simulation.covariance,
            "characteristics": self.characteristics(),
            "noise_standard_deviation": float(np.sqrt(self.estimate.noise_variance)),
            "nrmse": self.nrmse,
            "nrmse_validation": self.nrmse_validation,
            "rows_fitted": self.rows_fitted,
            "period": self.period,
            "rivals": [
                {"natural_frequencies": list(r.natural_frequencies), "weight": r.weight} for r in self.estimate.rivals
            ],
            "warnings": self.warnings(),
        }
        return {key: without_infinities(value) for key, value in content.items()}


def without_infinities(value: Any) -> Any:
    """The same with None for infinities and NaN, which JSON does not know."""
    if isinstance(value, dict):
        return {k: without_infinities(v) for k, v in value.items()}
    if isinstance(value, list):
        return [without_infinities(v) for v in value]
    return value if not isinstance(value, float | complex) or (np.isfinite(value) and np.isreal(value)) else None
