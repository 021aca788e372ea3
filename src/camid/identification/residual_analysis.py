"""Tests of what an estimate leaves of the recording: whether it is white, and whether it depends on the input.

At the estimate the residual is e ≈ (I − P) e0 with the noise e0 and the projection P on the sensitivities S (and on a
constant for each experiment, so that an offset, which has its own warning, does not pass for dynamics). The fit
took part of the noise with it, and both tests account for what it took, as Durbin (1970) did for regressions.

*Whiteness.* For white Gaussian e0 the quadratic forms q_k = eᵀA_k e (A_k the symmetric shift by k rows, over pairs of
fitted rows of one experiment) have E q_k = σ² tr(MA_k) and cov(q_j, q_k) = 2σ⁴ tr(MA_jMA_k), M = I − P, and q_k/q_0 is
independent of q_0. The autocorrelations less their mean become partial autocorrelations, whose sum of squares in the
metric of that covariance is chi-square: in small samples far better than the sum of Ljung and Box (Monti 1994).

*Independence.* The residual is regressed on S and on the lagged inputs U. The F statistic of U is the quadratic form of
Uᵀe in the pseudo-inverse of its covariance σ² Uᵀ(I − P)U (Ljung 1999, section 16.6); its effective rank is the number
of degrees of freedom. Where the declaration may be wrong, few directions are in question: what another hold, exposure
or latency would change in the simulated output. They are tested first, U after them; the two F statistics are
independent, and the smaller p-value, corrected for being the smaller of two, is stated. Coloured noise is not a fault
of the plant, so an autoregression is fitted to the residual (order by BIC, autocovariances freed of the bias by P as in
Worsley et al. 2002), and everything passes its whitening filter first.

References
----------
Durbin, J. (1970), Econometrica 38, 410–421. Ljung, L. (1999), System Identification, 2nd ed., sections 16.5–16.6.
Monti, A. C. (1994), Biometrika 81, 776–780. Worsley, K. J. et al. (2002), NeuroImage 15, 1–15. Young, P. C. (2011),
Recursive Estimation and Time-Series Analysis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.residual_statistics import (
    Moments,
    Rows,
    autocorrelations_with_bounds,
    crosscorrelations_with_bounds,
    independence,
    noise_model,
    sums_of_products,
    whiteness,
)
from camid.identification.structure import Structure
from camid.number_text import equals_probability

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

# A p-value below this is an alarm.
ALARM = 1e-3
LARGEST_LAG = 25
ROWS_PER_LAG = 8
# Residual, relative to the output, that is rounding: there is nothing to test.
ROUNDING = 1e-9
# Delay whose difference quotient replaces the derivative by it, in periods.
SMALL_DELAY = 0.1


@dataclass(frozen=True)
class ResidualAnalysis:
    """Tests of a residual.

    Attributes
    ----------
    lags : int
        Largest lag, in samples.
    whiteness_p : float or None
        Probability of a residual at least as coloured, if the noise is white; None where there is nothing to test.
    independence_p : float or None
        Probability of a residual that depends at least as much on the input, if model and declaration are right, be the
        noise white or coloured; None also for a free decay.
    noise_order : int
        Order of the autoregression that describes the noise; 0: white.
    deviance : float
        -2 log likelihood of the residual under that noise, up to a constant that the rows alone determine.
    at_rounding : bool
        Whether the residual is at rounding level.
    """

    lags: int
    whiteness_p: float | None
    independence_p: float | None
    noise_order: int
    deviance: float
    at_rounding: bool = False
    rows: Rows | None = field(default=None, repr=False, compare=False)

    @property
    def contradicts(self) -> bool:
        """Whether the residual depends on the input."""
        return self.independence_p is not None and self.independence_p < ALARM

    def summary(self) -> str:
        """One line for people."""
        if self.at_rounding:
            return "residual: at rounding level, so there is nothing to test"
        if self.whiteness_p is None:
            return "residual: too few samples to test"
        white = self.whiteness_p >= ALARM
        sentence = f"residual: {'white' if white else 'not white'} (p {equals_probability(self.whiteness_p)})"
        if self.independence_p is not None:
            verdict = "depends on the input" if self.contradicts else "independent of the input"
            sentence += f", {verdict} (p {equals_probability(self.independence_p)})"
        return sentence if white else f"{sentence}; the standard deviations are meant for white noise"

    def to_mapping(self) -> dict[str, Any]:
        """Part of ``--json``."""
        return {
            "whiteness_p": self.whiteness_p,
            "independence_p": self.independence_p,
            "lags": self.lags,
            "noise_order": self.noise_order,
            "at_rounding": self.at_rounding,
        }

    def correlations(self, period: float) -> pd.DataFrame:
        """Correlations of the residual with itself and with the input, with 99 % bounds.

        Parameters
        ----------
        period : float
            Seconds.

        Returns
        -------
        DataFrame
            ``lag`` (negative: future inputs, a correlation with which means feedback), ``seconds``,
            ``autocorrelation`` (less its mean under white noise), ``bound_autocorrelation`` (if the noise is white),
            ``crosscorrelation`` with the input ``lag`` samples earlier, ``bound_crosscorrelation`` (if the model is
            right, for noise with the spectrum of the fitted autoregression); NaN where there is nothing to say.
        """
        import pandas as pd

        first = 0 if self.rows is None else self.rows.first_lag
        lag = np.arange(-self.lags, first + self.lags + 1)
        columns = np.full((4, len(lag)), np.nan)
        if self.rows is not None:
            near = np.abs(lag) <= self.lags
            columns[:2, near] = autocorrelations_with_bounds(self.rows, self.lags)[:, np.abs(lag[near])]
            columns[2:] = crosscorrelations_with_bounds(self.rows, lag)
        names = ("autocorrelation", "bound_autocorrelation", "crosscorrelation", "bound_crosscorrelation")
        return pd.DataFrame({"lag": lag, "seconds": period * lag, **dict(zip(names, columns, strict=True))})


def analyse_residual(
    structure: Structure, plant: TransferFunction, experiments: Sequence[Experiment]
) -> ResidualAnalysis | None:
    """Test the residual of an estimate.

    Parameters
    ----------
    structure : Structure
        What was estimated.
    plant : TransferFunction
        The estimate, of that structure, in SI units; initial states are refitted.
    experiments : sequence of Experiment

    Returns
    -------
    ResidualAnalysis or None
        None if the model overflows, so that there is no residual.
    """
    structure, plant, scaled, _ = in_units_of_the_data(structure, plant, experiments)
    monic = plant.monic
    predictor = Predictor.around(structure, scaled, np.array(monic.denominator))
    coefficients = np.array([*monic.numerator, *monic.denominator[1:]])
    parameters = predictor.with_fitted_initial_states(coefficients)
    residual, sensitivities = predictor.linearise(parameters)
    table = sensitivities[:, predictor.free]
    if not (np.all(np.isfinite(residual)) and np.all(np.isfinite(table)) and np.max(np.abs(residual)) < 1e100):
        return None
    longest = max(int(np.count_nonzero(e.used)) for e in scaled)
    lags = min(LARGEST_LAG, longest // ROWS_PER_LAG)
    recorded = np.concatenate([e.position[e.used] for e in scaled])
    floor = ROUNDING * float(np.linalg.norm(recorded))
    if np.linalg.norm(residual) <= floor:
        deviance = len(residual) * float(np.log(max(floor**2, np.finfo(float).tiny) / len(residual)))
        return ResidualAnalysis(lags, None, None, 0, deviance, at_rounding=True)
    if lags < 1 or len(residual) <= 3 * (table.shape[1] + len(scaled)):
        return ResidualAnalysis(lags, None, None, 0, np.nan)
    first = max(0, min(e.acquisition.window()[0] for e in scaled) - 4)
    simulated = np.concatenate([e.output[e.used] for e in scaled]) - residual
    others = [_otherwise(predictor, i, parameters) - simulated for i in range(3)]
    return _tested(Rows.of(scaled, residual, table, np.column_stack(others), lags, first), lags)


def analyse_given(experiments: Sequence[Experiment], residual: Array, sensitivities: Array) -> ResidualAnalysis:
    """Test a residual that another model than a linear plant leaves, as the engine simulates it.

    No other declaration is tried: the test of independence is that of the lagged inputs alone.

    Parameters
    ----------
    experiments : sequence of Experiment
        ``used`` marks the rows of the residual; ``signal`` is what it must not depend on.
    residual : ndarray, shape (M,)
        On the used rows of all experiments, concatenated.
    sensitivities : ndarray, shape (M, p)
        Derivatives of the simulated output by what was fitted.
    """
    longest = max(int(np.count_nonzero(e.used)) for e in experiments)
    lags = min(LARGEST_LAG, longest // ROWS_PER_LAG)
    recorded = np.concatenate([e.position[e.used] for e in experiments])
    largest = float(np.max(np.abs(residual), initial=0.0))
    if np.linalg.norm(residual) <= ROUNDING * float(np.linalg.norm(recorded)):
        return ResidualAnalysis(lags, None, None, 0, np.nan, at_rounding=True)
    if lags < 1 or len(residual) <= 3 * (sensitivities.shape[1] + len(experiments)):
        return ResidualAnalysis(lags, None, None, 0, np.nan)
    first = max(0, min(e.acquisition.window()[0] for e in experiments) - 4)
    driven = max(float(np.max(np.abs(e.signal), initial=0.0)) for e in experiments) or 1.0
    scaled = [replace(e, signal=e.signal / driven) for e in experiments]
    nothing = np.zeros((len(residual), 0))
    return _tested(Rows.of(scaled, residual / largest, sensitivities, nothing, lags, first), lags)


def _otherwise(predictor: Predictor, which: int, parameters: Array) -> Array:
    """Simulated output if hold (0), exposure (1) or latency (2) were another, shape (rows,)."""

    def other(acquisition: Acquisition) -> Acquisition:
        if which == 0:
            return replace(acquisition, hold="foh" if acquisition.hold == "zoh" else "zoh")
        if which == 2:
            return replace(acquisition, latency=acquisition.latency + SMALL_DELAY * acquisition.period)
        exposure = acquisition.exposure or acquisition.period
        longer = acquisition.sensor == "instant" or exposure < 0.5 * acquisition.period
        return replace(acquisition, sensor="camera", exposure=acquisition.period if longer else 0.5 * exposure)

    changed = [replace(e, acquisition=other(e.acquisition)) for e in predictor.experiments]
    simulated = Predictor(predictor.structure, changed, predictor.time_unit).simulate(parameters)
    return np.concatenate([x[e.used] for x, e in zip(simulated, predictor.experiments, strict=True)])


def in_units_of_the_data(
    structure: Structure, plant: TransferFunction, experiments: Sequence[Experiment]
) -> tuple[Structure, TransferFunction, list[Experiment], float]:
    """The same in units of about the largest input and output, whose squares do not overflow; and the unit of gains."""
    signal, output = (
        float(2.0 ** np.round(np.log2(max(float(np.max(np.abs(v), initial=0.0)) for v in values) or 1.0)))
        for values in ([e.signal for e in experiments], [e.position[e.used] for e in experiments])
    )
    gain = output / signal
    scaled = [
        replace(e, signal=e.signal / signal, output=e.output / output, offset=e.offset / output) for e in experiments
    ]
    return (
        replace(structure, numerator=structure.numerator / gain),
        TransferFunction(tuple(b / gain for b in plant.numerator), plant.denominator),
        scaled,
        gain,
    )


def _tested(rows: Rows, lags: int) -> ResidualAnalysis:
    moments = Moments.of(rows, lags)
    sums = sums_of_products(rows.residual, lags)
    whitening, variance = noise_model(sums, moments)
    rows = replace(rows, whitening=whitening)
    count = int(np.count_nonzero(rows.used))
    return ResidualAnalysis(
        lags=lags,
        whiteness_p=whiteness(sums, moments),
        independence_p=independence(rows, lags),
        noise_order=len(whitening) - 1,
        deviance=float(count * np.log(variance)),
        rows=rows,
    )
