"""Choice of the order: every candidate is estimated, and the simplest that explains the recording is taken.

A candidate has n poles and m < n zeros. It counts if its iteration converged, the data determine its poles, and no zero
cancels a pole within their standard deviations. Among these the lowest order is chosen whose residual passes the test
of independence and whose BIC (Schwarz 1978) is within 6 of the smallest, the limit of "strong" evidence of Kass and
Raftery (1995): a richer model must earn its parameters.

References
----------
Burnham, K. P. and Anderson, D. R. (2002), Model Selection and Multimodel Inference, sections 2.4 (AICc) and 6.4
(weights). Kass, R. E. and Raftery, A. E. (1995), JASA 90, 773–795. Schwarz, G. (1978), Annals of Statistics 6, 461–464.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.identification.estimate import Estimate, estimate
from camid.identification.experiment import Experiment
from camid.identification.residual_analysis import ALARM, analyse_residual
from camid.identification.structure import Structure

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

LARGEST_ORDER = 4
# A larger BIC by this is strong evidence.
STRONG_EVIDENCE = 6.0
# 95 % of a chi-square variable with one and two degrees of freedom: a real and a complex difference that may be zero.
LARGEST_REAL, LARGEST_COMPLEX = 3.841, 5.991


@dataclass(frozen=True)
class OrderSelection:
    """What ``camid.select_order`` returns.

    Attributes
    ----------
    table : DataFrame
        One row per candidate: ``poles``, ``zeros``, ``parameters`` (initial states included), ``nrmse``, ``converged``,
        ``determined`` (no pole has a standard deviation as large as itself), ``cancels`` (a zero on a pole, within
        their standard deviations), ``independence_p``, ``whiteness_p``, ``delta_bic`` and ``delta_aicc`` (above the
        smallest), ``weight`` (exp(−ΔBIC/2), normalised), ``passes`` (all checks), ``chosen``.
    poles, zeros : int
        The chosen order.
    explained : bool
        False: no candidate passes all checks, and the chosen one has the smallest BIC only.
    recording_warnings : tuple of str
        What was done to the rows of the recordings before.
    """

    table: pd.DataFrame
    poles: int
    zeros: int
    explained: bool
    recording_warnings: tuple[str, ...] = ()

    def warnings(self) -> list[str]:
        """What limits how far the choice can be trusted, one sentence each."""
        said = list(self.recording_warnings)
        if self.explained:
            return said
        return [
            *said,
            "no order passes all checks; the one of the smallest BIC is shown, but something else is wrong: hold, "
            "exposure, latency, a nonlinearity, or too little data",
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        rows = self.table.astype(object).where(self.table.notna(), None).to_dict("records")
        return {
            "schema": 1,
            "poles": self.poles,
            "zeros": self.zeros,
            "explained": self.explained,
            "candidates": rows,
            "warnings": self.warnings(),
        }


def select_order(
    experiments: Sequence[Experiment],
    largest: int = LARGEST_ORDER,
    *,
    progress: Callable[[str], None] | None = None,
) -> OrderSelection:
    """Estimate every order up to the largest, and choose.

    Parameters
    ----------
    experiments : sequence of Experiment
        Of one rig, at least one of them with an input.
    largest : int
        Largest number of poles.
    progress : callable, optional
        Called with a sentence about the current step.

    Raises
    ------
    ValueError
        If there is no input, the largest order is not positive, or no candidate can be estimated.
    """
    import pandas as pd

    if largest < 1:
        raise ValueError(f"the largest order is {largest}: it must be at least one")
    if not any(np.any(e.signal) for e in experiments):
        raise ValueError("without an input the zeros cannot be determined")
    candidates = [(poles, zeros) for poles in range(1, largest + 1) for zeros in range(poles)]
    rows = []
    for i, (poles, zeros) in enumerate(candidates):
        if progress:
            progress(f"order {poles} {zeros} ({i + 1} of {len(candidates)})")
        rows.append(_row(poles, zeros, list(experiments)))
    table = pd.DataFrame(rows)
    if not np.isfinite(table["delta_bic"]).any():
        raise ValueError("no order can be estimated")
    for criterion in ("delta_bic", "delta_aicc"):
        table[criterion] -= table[criterion].min()
    weights = np.exp(-0.5 * table["delta_bic"].fillna(np.inf))
    table["weight"] = weights / weights.sum()
    sound = table["converged"] & table["determined"] & ~table["cancels"]
    # An exact fit leaves nothing to test.
    independent = ~(table["independence_p"] < ALARM)
    reference = table.loc[sound, "delta_bic"].min() if sound.any() else 0.0
    table["passes"] = sound & independent & (table["delta_bic"] <= reference + STRONG_EVIDENCE)
    explained = bool(table["passes"].any())
    likely = table["delta_bic"].where(sound) if sound.any() else table["delta_bic"]
    chosen = int(np.argmax(table["passes"])) if explained else int(np.argmin(likely.fillna(np.inf)))
    table["chosen"] = np.arange(len(table)) == chosen
    return OrderSelection(table, *candidates[chosen], explained)


def _row(poles: int, zeros: int, experiments: list[Experiment]) -> dict[str, Any]:
    """A candidate, its checks and criteria; NaN where it cannot be estimated."""
    structure = Structure.of_order(poles, zeros)
    recorded = np.concatenate([e.output[e.used] for e in experiments])
    rows = len(recorded)
    parameters = poles + zeros + 1 + poles * sum(e.estimate_initial_state for e in experiments)
    row: dict[str, Any] = {
        "poles": poles,
        "zeros": zeros,
        "parameters": parameters,
        "nrmse": np.nan,
        "converged": False,
        "determined": False,
        "cancels": False,
        "independence_p": np.nan,
        "whiteness_p": np.nan,
        "delta_bic": np.nan,
        "delta_aicc": np.nan,
    }
    if rows <= parameters + 2:
        return row
    try:
        result = estimate(structure, experiments)
        analysis = analyse_residual(structure, result.plant, experiments)
    except (ValueError, ArithmeticError):  # no start leads to a stable model
        return row
    if analysis is None or not np.isfinite(analysis.deviance):
        return row
    residual = np.concatenate([r[e.used] for r, e in zip(result.residuals, experiments, strict=True)])
    size = parameters + analysis.noise_order + 1  # and the variance
    duration = max(len(e.output) * e.acquisition.period for e in experiments)
    return row | {
        "nrmse": float(np.sqrt(np.mean(residual**2)) / np.std(recorded)),
        "converged": result.converged,
        "determined": poles_determined(result, duration),
        "cancels": cancels(result),
        "independence_p": np.nan if analysis.independence_p is None else analysis.independence_p,
        "whiteness_p": np.nan if analysis.whiteness_p is None else analysis.whiteness_p,
        "delta_bic": analysis.deviance + size * np.log(rows),
        "delta_aicc": analysis.deviance + 2.0 * size + 2.0 * size * (size + 1.0) / max(rows - size - 1.0, 1.0),
    }


def _gradients(roots: ComplexArray, coefficients: Array, powers: range) -> ComplexArray:
    """Derivatives of the roots of a polynomial with respect to its coefficients of the given powers."""
    slope = np.polyval(np.polyder(coefficients), roots)
    with np.errstate(divide="ignore", invalid="ignore"):
        return -(roots[:, None] ** np.array(powers)) / slope[:, None]


def _roots(result: Estimate) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
    """Poles, zeros, and their derivatives with respect to [b_0 … b_m, a_1 … a_n]."""
    plant = result.plant
    split, order = len(plant.numerator), plant.order
    poles, zeros = plant.poles(), plant.zeros()
    pole_gradients = np.zeros((len(poles), split + order), complex)
    zero_gradients = np.zeros((len(zeros), split + order), complex)
    pole_gradients[:, split:] = _gradients(poles, np.array(plant.denominator), range(order - 1, -1, -1))
    zero_gradients[:, :split] = _gradients(zeros, np.array(plant.numerator), range(split - 1, -1, -1))
    return poles, zeros, pole_gradients, zero_gradients


def poles_determined(result: Estimate, duration: float) -> bool:
    """Whether every pole is known better than to its own size; a pole at zero, better than to one in the duration.

    Parameters
    ----------
    result : Estimate
    duration : float
        Seconds.
    """
    if not np.all(np.isfinite(result.covariance)):
        return False
    poles, _, gradients, _ = _roots(result)
    variances = np.real(np.einsum("ij,jk,ik->i", gradients, result.covariance, gradients.conj()))
    # A repeated pole has no derivative; that does not speak against the order.
    return not bool(np.any(variances > np.maximum(np.abs(poles), 1.0 / duration) ** 2))


def cancels(result: Estimate) -> bool:
    """Whether a zero lies on a pole, within the standard deviation of their distance (95 %)."""
    if not np.all(np.isfinite(result.covariance)):
        return False
    poles, zeros, pole_gradients, zero_gradients = _roots(result)
    for pole, pole_gradient in zip(poles, pole_gradients, strict=True):
        for zero, zero_gradient in zip(zeros, zero_gradients, strict=True):
            if (pole.imag == 0.0) != (zero.imag == 0.0):
                continue
            distance, gradient = pole - zero, pole_gradient - zero_gradient
            parts = 1 if pole.imag == 0.0 else 2
            table = np.array([gradient.real, gradient.imag])[:parts]
            difference = np.array([distance.real, distance.imag])[:parts]
            covariance = table @ result.covariance @ table.T
            if np.all(np.isfinite(covariance)) and np.linalg.matrix_rank(covariance) == parts:
                form = float(difference @ np.linalg.solve(covariance, difference))
                if form <= (LARGEST_REAL if parts == 1 else LARGEST_COMPLEX):
                    return True
    return False
