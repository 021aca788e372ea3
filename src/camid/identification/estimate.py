"""From starts to the estimate with its covariance: the default method, and the others by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.identification.accuracy import covariance_from
from camid.identification.experiment import Experiment
from camid.identification.iteration_result import IterationResult
from camid.identification.likelihood_profile import Interval, intervals, standard_deviations
from camid.identification.optimum_search import Search
from camid.identification.optimum_selection import Rival
from camid.identification.output_error import output_error
from camid.identification.predictor import Predictor
from camid.identification.records import Records
from camid.identification.safeguarded import safeguarded_srivc
from camid.identification.srivc import least_squares_state_variable_filter, plain_srivc, reflect
from camid.identification.starts import output_errors_of
from camid.identification.structure import Structure

Array = NDArray[np.float64]
Progress = Callable[[str], None]

METHODS = ("srivc", "output-error", "plain-srivc")
# A wrong model (a hold declared wrongly, say) leaves a large residual, for which Gauss–Newton converges only linearly.
FINAL_ITERATIONS = 1000


@dataclass(frozen=True)
class Constant:
    """A constant that was estimated beside the plant.

    Attributes
    ----------
    value : float
    standard_deviation : float
        Infinite where the data leave it undetermined.
    """

    value: float
    standard_deviation: float


@dataclass(frozen=True)
class Estimate:
    """An identified plant.

    Attributes
    ----------
    plant : TransferFunction
        Monic denominator, SI units.
    standard_deviations : ndarray, shape (m + 1 + n,)
        Of [b_0 … b_m, a_1 … a_n]; zero where a coefficient was not free.
    covariance : ndarray, shape (m + 1 + n, m + 1 + n)
        In the same order.
    noise_variance : float
        Of the output residual, degrees of freedom counted.
    converged : bool
    iterations : int
    residuals : list of ndarray
        Recorded minus simulated output, every row of every experiment.
    free : ndarray of bool, shape (m + 1 + n,)
    rivals : list of Rival
        Models of other frequencies that the data do not tell from this one.
    intervals : list of Interval
        95 % intervals where the data say so little that the output error is not a parabola; the standard deviations
        then reach to their farther ends.
    bias, offset : Constant or None
        What is added to the input and to the output, in units of u and of y, where it was unknown.
    """

    plant: TransferFunction
    standard_deviations: Array
    covariance: Array
    noise_variance: float
    converged: bool
    iterations: int
    residuals: list[Array]
    free: NDArray[np.bool_]
    rivals: list[Rival]
    intervals: list[Interval]
    bias: Constant | None = None
    offset: Constant | None = None


def estimate(
    structure: Structure,
    experiments: list[Experiment],
    *,
    nominal: TransferFunction | None = None,
    method: str = "srivc",
    progress: Progress | None = None,
) -> Estimate:
    """Identify a plant from recordings of one rig.

    Parameters
    ----------
    structure : Structure
        Degrees, and which coefficients are free.
    experiments : list of Experiment
    nominal : TransferFunction, optional
        A believed plant of the same degrees, one start among others.
    method : {"srivc", "output-error", "plain-srivc"}
        Safeguarded SRIVC; output error by ``scipy.optimize.least_squares``; SRIVC as published, from an LSSVF start.
    progress : callable, optional
        Called with a sentence about the current step.

    Raises
    ------
    ValueError
        If there are fewer used rows than free parameters or the method is unknown.
    """
    if method not in METHODS:
        raise ValueError(f"method = {method!r}: it must be one of {', '.join(METHODS)}")
    experiments = _centred(experiments, method)
    units = _units(experiments)
    gain = units.output / units.signal
    scaled = [
        replace(e, signal=e.signal / units.signal, output=e.output / units.output, offset=e.offset / units.output)
        for e in experiments
    ]
    result = _estimate_scaled(
        replace(structure, numerator=structure.numerator / gain),
        scaled,
        None if nominal is None else np.asarray(nominal.monic.denominator),
        method,
        progress,
    )
    return _in_units(result, units, experiments[0].offset)


def _centred(experiments: list[Experiment], method: str) -> list[Experiment]:
    """The experiments counted from the mean output where the offset is unknown: numbers of pixels lose no digits so.

    SRIVC as published knows of no constant, and takes the mean as the offset.
    """
    if not any(e.estimate_offset for e in experiments):
        return experiments
    mean = float(np.mean(np.concatenate([e.output[e.used] for e in experiments])))
    published = method == "plain-srivc"
    return [replace(e, offset=mean, estimate_offset=not published) for e in experiments]


@dataclass(frozen=True)
class _Units:
    """About the largest input and output: in these units no square of a datum overflows or vanishes.

    Powers of two, so that scaling is exact.
    """

    signal: float
    output: float


def _units(experiments: list[Experiment]) -> _Units:
    signal = max(float(np.max(np.abs(e.signal))) for e in experiments)
    output = max(float(np.max(np.abs(e.position))) for e in experiments)
    signal, output = (float(2.0 ** np.round(np.log2(largest or 1.0))) for largest in (signal, output))
    return _Units(signal, output)


def _times_gain(plant: TransferFunction, gain: float) -> TransferFunction:
    return TransferFunction(tuple(gain * b for b in plant.numerator), plant.denominator)


def _in_units(result: Estimate, units: _Units, known_offset: float) -> Estimate:
    """The estimate for the recording as it came."""
    gain = units.output / units.signal
    factors = np.ones(len(result.free))
    factors[: len(result.free) - result.plant.order] = gain
    return replace(
        result,
        plant=_times_gain(result.plant, gain),
        standard_deviations=factors * result.standard_deviations,
        covariance=np.outer(factors, factors) * result.covariance,
        noise_variance=units.output**2 * result.noise_variance,
        residuals=[units.output * r for r in result.residuals],
        intervals=[
            Interval(i.coefficient, factors[i.coefficient] * i.low, factors[i.coefficient] * i.high)
            for i in result.intervals
        ],
        bias=_scaled(result.bias, units.signal),
        offset=_scaled(result.offset, units.output, known_offset),
    )


def _scaled(constant: Constant | None, unit: float, known: float = 0.0) -> Constant | None:
    if constant is None:
        return None
    return Constant(known + unit * constant.value, unit * constant.standard_deviation)


def _estimate_scaled(
    structure: Structure,
    experiments: list[Experiment],
    believed: Array | None,
    method: str,
    progress: Progress | None,
) -> Estimate:
    """Estimate from data of the order of one; ``believed`` is a monic denominator in SI units."""
    tell = progress or (lambda _sentence: None)
    if method == "plain-srivc":
        predictor, fit = _plain(structure, experiments, believed, tell)
        others: list[Rival] = []
    else:
        records = Records.of(experiments)
        search = Search(structure, experiments, records, believed, tell)
        best, others = search.run()
        predictor, fit = best.predictor, best.fit
        if method == "output-error" or not (search.whole and fit.converged):
            coefficients = predictor.to_physical(fit.parameters)
            denominator = np.concatenate([[1.0], coefficients[structure.degree + 1 :]])
            predictor = Predictor.around(structure, experiments, denominator, records)
            parameters = predictor.with_fitted_initial_states(coefficients)
            tell("final iteration on the whole recording")
            if method == "output-error":
                fit = output_error(predictor, parameters)
            else:
                fit = safeguarded_srivc(
                    predictor,
                    parameters,
                    maximum_iterations=FINAL_ITERATIONS,
                    on_iteration=lambda i, cost: tell(f"iteration {i}: output error {cost:.4g}"),
                )
    return _summarise(predictor, fit, others)


def _plain(
    structure: Structure,
    experiments: list[Experiment],
    believed: Array | None,
    tell: Progress,
) -> tuple[Predictor, IterationResult]:
    """SRIVC as published: start from the nominal plant, else from LSSVF with the cut-off that fits best."""
    if believed is not None:
        denominator = believed
    else:
        tell("state-variable filters")
        period = experiments[0].acquisition.period
        records = Records.of(experiments)
        trials = []
        for cut_off in np.geomspace(0.02, 1.0, 8) * np.pi / period:
            predictor = Predictor(structure, experiments, 1.0 / cut_off)
            start = least_squares_state_variable_filter(predictor, cut_off)
            split = structure.degree + 1
            denominator = reflect(np.concatenate([[1.0], predictor.to_physical(start)[split:]]))
            trials += [(c.cost, c.denominator) for c in output_errors_of(structure, records, [denominator])]
        denominator = min(trials, key=lambda t: t[0])[1]
    predictor = Predictor.around(structure, experiments, denominator)
    scaled = denominator * predictor.time_unit ** np.arange(structure.order + 1)
    start = predictor.solve_numerator(scaled)[0]
    tell("plain SRIVC")
    return predictor, plain_srivc(predictor, start)


def _summarise(predictor: Predictor, fit: IterationResult, others: list[Rival]) -> Estimate:
    structure = predictor.structure
    coefficients = np.where(structure.free, predictor.to_physical(fit.parameters), structure.coefficients())
    triangle, cost, residual = predictor.factorise(fit.parameters)
    covariance, variance, determined = covariance_from(predictor, triangle, cost)
    count = len(structure.free)
    if not fit.converged:
        # Where an iteration stopped without an optimum, the curvature says nothing of the accuracy.
        covariance = np.diag(np.where(predictor.free, np.inf, 0.0))
    found = intervals(predictor, fit, covariance)
    first_order = np.sqrt(np.diag(covariance)[:count])
    deviations = standard_deviations(coefficients, first_order, found)
    with np.errstate(divide="ignore", invalid="ignore"):
        wider = np.where((first_order > 0.0) & np.isfinite(first_order), deviations / first_order, 1.0)
        # What does not vary together does not where one of both is unbounded, either.
        together = covariance[:count, :count]
        together = np.where(together == 0.0, 0.0, together * np.outer(wider, wider))
    plant = structure.plant(coefficients)
    return Estimate(
        plant=plant,
        standard_deviations=deviations,
        covariance=together,
        noise_variance=variance,
        converged=bool(fit.converged and determined and plant.unstable_poles().size == 0),
        iterations=fit.iterations,
        residuals=np.split(residual, predictor.records.offsets[1:-1]),
        free=predictor.structure.free,
        rivals=others,
        intervals=found,
        **_constants(predictor, fit, covariance),
    )


def _constants(predictor: Predictor, fit: IterationResult, covariance: Array) -> dict[str, Constant]:
    """Bias and offset with their standard deviations, where they were estimated."""
    found = {}
    values = dict(zip(("bias", "offset"), predictor.bias_and_offset(fit.parameters), strict=True))
    for place, name, unknown in (
        (-1, "offset", predictor.records.sensor_offset),
        (-2 if predictor.records.sensor_offset else -1, "bias", predictor.records.input_bias),
    ):
        if unknown:
            found[name] = Constant(values[name], float(np.sqrt(covariance[place, place])))
    return found
