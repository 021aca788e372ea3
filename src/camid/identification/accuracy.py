"""How well the data determine the parameters: covariance of an estimate and the Cramér–Rao bound."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.compiled import njit
from camid.identification.experiment import Experiment
from camid.identification.iteration_result import LARGEST_CONDITION, UNDETERMINED_SHARE
from camid.identification.predictor import Predictor
from camid.identification.structure import Structure

Array = NDArray[np.float64]

LONGEST_REGRESSION = 30
# Smallest pivot of a Cholesky factorisation that leaves half of the digits.
SMALLEST_PIVOT = 1e-4
# Smallest share of the power that may be left, as a difference of two powers, before its digits are lost.
SMALLEST_REMAINDER = 1e-5


def inverse_information(sensitivities: Array, coefficients: int | None = None) -> tuple[Array, bool]:
    """(JᵀJ)⁻¹ by a singular value decomposition of the column-scaled J.

    Parameters
    ----------
    sensitivities : ndarray, shape (M, p)
        Or the triangle of their QR factorisation.
    coefficients : int, optional
        How many of the first columns must be determined by the data; all, unless it is given.

    Returns
    -------
    inverse : ndarray, shape (p, p)
        With infinite variances where the data determine nothing.
    determined : bool
    """
    from scipy.linalg import svd

    number = sensitivities.shape[1] if coefficients is None else coefficients
    table = np.ascontiguousarray(sensitivities, dtype=np.float64)
    columns = table.shape[1]
    power = np.zeros(columns)
    for row in table:
        power += row * row
    lengths = np.sqrt(power)
    if np.any(lengths == 0.0) or not np.all(np.isfinite(lengths)):
        return np.diag(np.where(lengths > 0.0, 0.0, np.inf)), False
    _, singular, right = svd(table / lengths, full_matrices=False)
    limit = singular[0] / LARGEST_CONDITION
    determined = True
    inverse = np.zeros((columns, columns))
    for value, vector in zip(singular, right, strict=True):
        # A direction that the data do not determine may concern initial states alone.
        if value <= limit and sum(float(each) ** 2 for each in vector[:number]) >= UNDETERMINED_SHARE**2:
            determined = False
        direction = vector / (lengths * max(value, limit))
        inverse += np.outer(direction, direction)
    return inverse, determined


def covariance_from(predictor: Predictor, triangle: Array, cost: float) -> tuple[Array, float, bool]:
    """Covariance σ² (Σ ẑ ẑᵀ)⁻¹ of all parameters, coefficients in SI units (Young 2011; white output noise).

    Parameters
    ----------
    predictor : Predictor
    triangle : ndarray, shape (p + 1, p + 1)
    cost : float
        Both from :meth:`camid.identification.predictor.Predictor.factorise` at the estimate.

    Returns
    -------
    covariance : ndarray, shape (p, p)
        Rows and columns of coefficients that are not free are zero.
    variance : float
        σ², residual sum of squares over its degrees of freedom.
    determined : bool
        Whether the information matrix has full rank.
    """
    free = predictor.free
    covariance = np.zeros((len(free), len(free)))
    variance = cost / max(len(predictor.target) - int(free.sum()), 1)
    if not np.isfinite(variance):
        return np.diag(np.where(free, np.inf, 0.0)), np.inf, False  # a method without safeguard ran away
    if not free.any():
        return covariance, variance, True
    coefficients = int(predictor.structure.free.sum())
    inverse, determined = inverse_information(triangle[:, :-1][:, free], coefficients)
    covariance[np.ix_(free, free)] = variance * inverse
    scale = predictor.scale()
    return covariance / np.outer(scale, scale), variance, determined


def cramer_rao_bound(
    plant: TransferFunction,
    signal: Array,
    acquisition: Acquisition,
    noise_variance: float,
    *,
    estimate_initial_state: bool = False,
    estimate_offset: bool = False,
) -> Array:
    """Smallest covariance of an unbiased estimate of [b_0 … b_m, a_1 … a_n] in white Gaussian output noise.

    Parameters
    ----------
    plant : TransferFunction
        The true plant, taken with a monic denominator.
    signal : ndarray, shape (N,)
        Input samples.
    acquisition : Acquisition
    noise_variance : float
        Variance of the output noise, in the units of y squared.
    estimate_initial_state, estimate_offset : bool
        Whether the initial state and the zero of the sensor are unknown, too.

    Returns
    -------
    ndarray, shape (m + 1 + n, m + 1 + n)
    """
    monic = plant.monic
    structure = Structure.of_order(monic.order, len(monic.numerator) - 1)
    rows = np.ones(len(signal), bool)
    experiment = Experiment(
        np.asarray(signal, float),
        np.zeros(len(signal)),
        acquisition,
        rows,
        estimate_initial_state,
        estimate_offset=estimate_offset,
    )
    predictor = Predictor.around(structure, [experiment], np.asarray(monic.denominator))
    parameters = predictor.from_physical(np.array([*monic.numerator, *monic.denominator[1:]]))
    scale = predictor.scale()
    bound = inverse_information(predictor.factorise(parameters)[0][:, :-1])[0] / np.outer(scale, scale)
    count = len(structure.free)
    return noise_variance * bound[:count, :count]


def innovation_variance(experiment: Experiment) -> float:
    """Variance of the part of the output that its own past and the input do not predict (long ARX model).

    For white output noise this is the noise variance whatever the plant, so it tells whether an output-error fit has
    reached its global optimum.
    """
    signal, output = experiment.for_regression()
    count = len(output)
    length = min(LONGEST_REGRESSION, count // 10)
    if length < 2:
        return 0.0
    rows = experiment.used[length:]
    driven = bool(np.any(signal))
    freedom = int(rows.sum()) - (2 * length + 1 if driven else length) - int(experiment.estimate_offset)
    if freedom < length:
        return 0.0
    if rows.all():
        power = _power_left(_lagged_products(output, signal if driven else output[:0], length))
        if np.isfinite(power):
            return power / freedom
    past = sliding_window_view(output, length + 1)
    columns = [past[:, :-1], sliding_window_view(signal, length + 1)] if driven else [past[:, :-1]]
    table, target = np.hstack(columns)[rows], past[rows, -1]
    residual = target - table @ np.linalg.lstsq(table, target, rcond=None)[0]
    return float(residual @ residual) / freedom


@njit(fastmath={"reassoc", "contract"})
def _lagged_products(output: Array, signal: Array, length: int) -> Array:
    """Products of the columns [u_{k-L} … u_k, y_{k-L} … y_k] of a long ARX model, without a signal those of y alone.

    The sum for two lags differs from that for the next two by one product at each end.
    """
    count, inputs = len(output), length + 1 if len(signal) else 0
    size = inputs + length + 1
    products = np.zeros((size, size))
    for a in range(size):
        first, lag_a = (signal, length - a) if a < inputs else (output, length - (a - inputs))
        for b in range(a + 1):
            second, lag_b = (signal, length - b) if b < inputs else (output, length - (b - inputs))
            if lag_a < length and lag_b < length:
                total = products[a - 1, b - 1]
                total += first[count - 1 - lag_a] * second[count - 1 - lag_b]
                total -= first[length - 1 - lag_a] * second[length - 1 - lag_b]
            else:
                total = 0.0
                for k in range(length, count):
                    total += first[k - lag_a] * second[k - lag_b]
            products[a, b] = total
            products[b, a] = total
    return products


@njit(fastmath={"reassoc", "contract"})
def _power_left(products: Array) -> float:
    """Sum of squares that a regression of the last column on the others leaves; NaN where it loses its digits.

    Cholesky's last pivot is the distance of the last column from the span of those before it.
    """
    size = len(products)
    factor = np.zeros((size, size))
    scale = np.empty(size)
    for i in range(size):
        if not products[i, i] > 0.0:
            return np.nan
        scale[i] = 1.0 / np.sqrt(products[i, i])
    for i in range(size):
        for j in range(i + 1):
            total = products[i, j] * scale[i] * scale[j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if j < i:
                factor[i, j] = total / factor[j, j]
            elif i < size - 1:
                if not total > SMALLEST_PIVOT**2:
                    return np.nan
                factor[i, i] = np.sqrt(total)
    return total * products[size - 1, size - 1] if total > SMALLEST_REMAINDER else np.nan


def characteristics(plant: TransferFunction, covariance: Array) -> list[dict[str, float | str]]:
    """What engineers call a plant by: static gain, natural frequency and damping of each mode, real poles.

    Parameters
    ----------
    plant : TransferFunction
        With a monic denominator.
    covariance : ndarray, shape (m + 1 + n, m + 1 + n)
        Of [b_0 … b_m, a_1 … a_n].

    Returns
    -------
    list of dict
        ``name``, ``value``, ``standard_deviation`` (first-order propagation) and ``unit``, poles in ascending order.
    """
    split = len(plant.numerator)
    count = split + plant.order
    rows: list[dict[str, float | str]] = []

    def add(name: str, value: float, gradient: Array, unit: str) -> None:
        with np.errstate(invalid="ignore", over="ignore"):
            variance = float(gradient @ covariance @ gradient)
        # A repeated pole has no derivative, hence no standard deviation of first order.
        deviation = max(variance, 0.0) ** 0.5 if np.isfinite(variance) else float("inf")
        rows.append({"name": name, "value": value, "standard_deviation": deviation, "unit": unit})

    last = plant.denominator[-1]
    if last != 0.0:
        gradient = np.zeros(count)
        gradient[split - 1], gradient[-1] = 1.0 / last, -plant.numerator[-1] / last / last
        add("static gain", plant.static_gain(), gradient, "y/u")
    derivative = np.polyder(np.asarray(plant.denominator))
    poles = sorted(plant.poles(), key=abs)
    for pole in poles:
        if pole.imag < 0.0:
            continue
        # dp/da_i = -p^(n-i) / A'(p)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = -(pole ** np.arange(plant.order - 1, -1, -1)) / np.polyval(derivative, pole)
        gradient = np.zeros(count)
        if pole.imag == 0.0:
            gradient[split:] = slope.real
            add("real pole", float(pole.real), gradient, "rad/s")
            continue
        radius = abs(pole)
        radial = (np.conj(pole) * slope).real / radius
        gradient[split:] = radial
        add("natural frequency", float(radius), gradient, "rad/s")
        gradient = np.zeros(count)
        gradient[split:] = -slope.real / radius + pole.real / radius**2 * radial
        add("damping ratio", float(-pole.real / radius), gradient, "")
    return rows
