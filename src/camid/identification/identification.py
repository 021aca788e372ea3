"""What an identification returns to people and machines."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.identification.accuracy import characteristics
from camid.identification.declarations import Alternative, contradiction_sentence
from camid.identification.estimate import Estimate
from camid.identification.residual_analysis import ResidualAnalysis
from camid.number_text import SPACE, percentage, plain
from camid.simulation.model import Simulation
from camid.writing import without_infinities

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]

# A mean of the residual calls for a warning if it is this many standard deviations off and this share of the power.
OFFSET_SIGNIFICANCE = 5.0
OFFSET_SHARE = 0.02
# A larger NRMSE leaves less than a fifth of the variance explained.
LITTLE_EXPLAINED = 0.9
# Deviations are those of many samples.
FEWEST_ROWS_PER_UNKNOWN = 5
QUANTITY = ("name", "value", "standard_deviation", "unit")
# Rivals of a smaller weight are left to --json, and so are those beyond the first few.
NAMED_WEIGHT, MOST_NAMED_RIVALS = 1e-3, 3


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
    acquisition : Acquisition or None
        Hold and sensor as they were declared for the first recording.
    residual_analysis : ResidualAnalysis or None
        Whether the residual is white and independent of the input; None if there is no usable residual.
    alternatives : list of Alternative
        Other declarations that were fitted because the residual contradicts this one, best first.
    recording_warnings : tuple of str
        What was done to the rows of the recordings before.
    method : str or None
        How it was identified, where the plant leaves no choice.
    notes : tuple of str
        What was not estimated, and why.
    effect_rows : tuple of dict
        Parameters of the simulation's effects that were estimated with the plant: ``effect``, ``name``, ``value``,
        ``standard_deviation`` and ``unit``.
    """

    simulation: Simulation
    estimate: Estimate
    converged: bool
    period: float
    rows_fitted: int
    nrmse: float
    nrmse_validation: float | None
    acquisition: Acquisition | None = None
    residual_analysis: ResidualAnalysis | None = None
    alternatives: list[Alternative] = field(default_factory=list)
    recording_warnings: tuple[str, ...] = ()
    method: str | None = None
    notes: tuple[str, ...] = ()
    effect_rows: tuple[dict[str, Any], ...] = ()

    def to_control(self) -> control.TransferFunction:
        """The identified plant as a continuous-time python-control transfer function."""
        return self.simulation.plant.to_control()

    def characteristics(self) -> list[dict[str, Any]]:
        """Static gain, natural frequencies, damping ratios and real poles with their standard deviations."""
        found = characteristics(self.estimate.plant, self.estimate.covariance)
        if self.simulation.physical is not None and self.simulation.input_column is None:
            # Constants that were held make a gain, of which a free decay says nothing.
            return [row for row in found if row["name"] != "static gain"]
        return found

    def parameters(self) -> list[dict[str, Any]]:
        """Named constants of the plant: ``name``, ``value``, ``standard_deviation``, ``unit`` and ``state``.

        The state is ``estimated``, ``fixed``, or ``undetermined`` where the recording does not tell them apart.
        """
        physical = self.simulation.physical
        if physical is None:
            return []
        left_open = () if physical.left_open is None else physical.left_open.open
        deviations = physical.standard_deviations or {}
        return [
            {
                "name": name,
                "value": float(value),
                "standard_deviation": deviations.get(name),
                "unit": physical.units.get(name, ""),
                "state": "undetermined"
                if name in left_open
                else "estimated"
                if name in deviations
                else "fixed"
                if name in physical.fixed
                else "undetermined",
            }
            for name, value in physical.parameters.items()
        ]

    def combinations(self) -> list[dict[str, Any]]:
        """What is determined where constants are not: ``expression``, ``value`` and ``standard_deviation``."""
        physical = self.simulation.physical
        rows = () if physical is None else physical.combination_rows()
        return [{"expression": e, "value": value, "standard_deviation": deviation} for e, value, deviation in rows]

    def constants(self) -> list[dict[str, Any]]:
        """Offset and bias where they were estimated: ``name``, ``value``, ``standard_deviation`` and ``unit``."""
        rows = []
        for name, unit, constant in (
            ("offset of the sensor", "y", self.estimate.offset),
            ("bias of the input", "u", self.estimate.bias),
        ):
            if constant is not None:
                value, deviation = constant.value, constant.standard_deviation
                rows.append({"name": name, "value": value, "standard_deviation": deviation, "unit": unit})
        model = self.simulation
        for name, value, known, unit in (
            ("latency of the sensor", model.known_latency, model.latency_deviation, "s"),
            ("skew of its clock", model.known_skew, model.skew_deviation, ""),
        ):
            if known is not None:
                rows.append({"name": name, "value": value, "standard_deviation": known, "unit": unit})
        return rows

    def at_stability_limit(self) -> bool:
        """Whether a free coefficient of the denominator ended at zero, where the data left to themselves go beyond."""
        plant, free = self.estimate.plant, self.estimate.free[len(self.estimate.plant.numerator) :]
        return bool(np.any((np.array(plant.denominator[1:]) == 0.0) & free))

    def _name(self, coefficient: int) -> str:
        """Of a coefficient in [b_0 … b_m, a_1 … a_n], as the table on the screen names it."""
        zeros, poles = len(self.estimate.plant.numerator) - 1, self.estimate.plant.order
        return f"b{zeros - coefficient}" if coefficient <= zeros else f"a{poles - (coefficient - zeros)}"

    def _unknowns(self) -> int:
        """Number of coefficients and constants that were estimated, and of initial states."""
        constants = sum(constant is not None for constant in (self.estimate.offset, self.estimate.bias))
        states = self.estimate.plant.order if self.simulation.estimates_initial_state else 0
        return int(np.sum(self.estimate.free)) + constants + states * len(self.estimate.residuals)

    def warnings(self) -> list[str]:
        """What limits how far the numbers can be trusted, one sentence each."""
        sentences = [*self.recording_warnings, *self.notes]
        if not self.converged:
            sentences.append("the iteration did not converge; do not use the numbers (another order? more excitation?)")
        elif not self.nrmse < 1.0:
            sentences.append(
                "the model follows the recording no better than a constant does: another plant, or other first values?"
            )
        elif self.nrmse > LITTLE_EXPLAINED:
            share = percentage(max(1.0 - self.nrmse**2, 0.0), 2)
            sentences.append(
                f"the model explains {share} of the output's variance, next to nothing: is the output moved by this "
                "input, and does the recording show more than noise?"
            )
        unknowns = self._unknowns()
        if self.rows_fitted < FEWEST_ROWS_PER_UNKNOWN * unknowns:
            sentences.append(
                f"{self.rows_fitted} samples for {unknowns} unknowns are few: the deviations may say too little "
                f"(record at least {FEWEST_ROWS_PER_UNKNOWN * unknowns})"
            )
        latency = self.simulation.latency_deviation
        if latency is not None and self.simulation.known_latency < latency:
            sentences.append(
                "the latency ended at zero or near it, and its interval has one side only: are time stamps too early?"
            )
        if self.at_stability_limit():
            sentences.append(
                "a pole lies at the limit of stability: an integrator or an undamped mode? For an integrator, write a "
                "zero at the end of the denominator"
            )
        analysis = self.residual_analysis
        if self.converged and analysis is not None and analysis.contradicts and self.acquisition is not None:
            sentences.append(contradiction_sentence(analysis, self.nrmse, self.acquisition, self.alternatives))
        open_ended = [i for i in self.estimate.intervals if not np.isfinite(i.high - i.low)]
        if open_ended:
            names = ", ".join(self._name(i.coefficient) for i in open_ended)
            sentences.append(f"the data do not limit {names}: no accuracy can be stated (longer record? less noise?)")
        named = [r for r in self.estimate.rivals if r.weight >= NAMED_WEIGHT][:MOST_NAMED_RIVALS]
        for rival in named:
            modes = ", ".join(plain(value, 5) for value in rival.natural_frequencies)
            dampings = ", ".join(plain(value, 2) for value in rival.damping_ratios)
            sentences.append(
                f"the data cannot tell this plant from one with poles of {modes} rad/s and damping {dampings} (weight "
                f"{plain(rival.weight, 2)}): another sampling period would"
            )
        if len(self.estimate.rivals) > len(named):
            sentences.append(f"{len(self.estimate.rivals) - len(named)} less likely plants are listed by --json")
        return [*sentences, *self._means_of_residuals()]

    def _means_of_residuals(self) -> list[str]:
        """A sentence for each recording with another offset than the simulation declares."""
        sentences, units = [], self.simulation.units
        for residual in self.estimate.residuals if self.converged else ():
            mean, power = float(np.mean(residual)), float(np.mean(residual**2))
            centred = residual - mean
            spread = float(centred @ centred)
            correlation = float(centred[1:] @ centred[:-1]) / spread if spread > 0.0 else 0.0
            # A slow residual has fewer independent samples than rows.
            effective = len(residual) * (1.0 - correlation) / (1.0 + correlation)
            if mean**2 > OFFSET_SHARE * power and mean**2 > OFFSET_SIGNIFICANCE**2 * (power - mean**2) / effective:
                size = plain(units.shown(mean, "y"), 3, units.text("y")).replace(SPACE, " ")
                sentences.append(
                    f"the residual has a mean of {size}, {percentage(mean**2 / power, 2)} of its power: the "
                    "recording has another offset than the simulation declares"
                )
        return sentences

    def quantities(self) -> list[list[tuple[str, float, float | None, str]]]:
        """What was estimated, in groups: names, values and standard deviations as people read them, with their units.

        In the units that are declared for the columns; a deviation of zero belongs to what was not estimated.
        """
        model, units = self.simulation, self.simulation.units
        derived = [] if model.states_characteristics else self.characteristics()
        combined = [{"name": row["expression"], "unit": "", **row} for row in self.combinations()]
        effects = [{**r, "name": f"{r['effect']}, {r['name'].replace('_', ' ')}"} for r in self.effect_rows]
        groups = [
            [*model.coefficient_rows()],
            *([tuple(r[k] for k in QUANTITY) for r in part] for part in (combined, derived, self.constants(), effects)),
        ]
        own = None if model.physical is None else groups[0]  # their units are those that the plant declares
        return [
            [(n, v, d, u) if g is own else (n, units.shown(v, u), units.shown(d, u), units.text(u)) for n, v, d, u in g]
            for g in groups
            if g
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``: SI units, and what people read in ``declared``."""
        plant, units = self.simulation.plant, self.simulation.units

        def with_declared(rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
            return [{**r, "declared": units.declared(r["value"], r["standard_deviation"], r["unit"])} for r in rows]

        named = self.simulation.physical is not None or self.simulation.pendulum is not None
        coefficients = [] if named else self.simulation.coefficient_rows()
        written = [dict(zip(QUANTITY, row, strict=True)) for row in coefficients]
        content = {
            "schema": 1,
            "units": units.to_mapping(),
            "converged": self.converged,
            "iterations": self.estimate.iterations,
            "numerator": list(plant.numerator),
            "denominator": list(plant.denominator),
            "standard_deviations": self.simulation.standard_deviations,
            "covariance": self.simulation.covariance,
            "coefficients": with_declared(written),
            "parameters": self.parameters(),
            "combinations": self.combinations(),
            "characteristics": with_declared(self.characteristics()),
            "constants": with_declared(self.constants()),
            "effects": with_declared(self.effect_rows),
            "noise_standard_deviation": float(np.sqrt(self.estimate.noise_variance)),
            "nrmse": self.nrmse,
            "nrmse_validation": self.nrmse_validation,
            "rows_fitted": self.rows_fitted,
            "period": self.period,
            "rivals": [
                {
                    "natural_frequencies": list(r.natural_frequencies),
                    "damping_ratios": list(r.damping_ratios),
                    "weight": r.weight,
                }
                for r in self.estimate.rivals
            ],
            "intervals": [
                {"coefficient": self._name(i.coefficient), "low": i.low, "high": i.high}
                for i in self.estimate.intervals
            ],
            "residual_analysis": None
            if self.residual_analysis is None
            else {
                **self.residual_analysis.to_mapping(),
                "alternatives": [a.to_mapping() for a in self.alternatives],
            },
            "warnings": self.warnings(),
        }
        return {key: without_infinities(value) for key, value in content.items()}
