"""The chain hold → plant → sensor, run exactly: matrix exponentials, no step size anywhere.

The plant is augmented with the integrator of the paper's Fig. 4, so that the camera's average over the exposure is a
difference of integrals and as exact as the state itself. Because input and sensor are linear, the average of *every*
state comes at the same price, and with it the regressors, instruments and sensitivities of identification.

Time convention: frame k is delivered at t_k; w_k = (1/τ)∫ y dt over [t_k − ℓ − τ, t_k − ℓ] (instant sensor:
y(t_k − ℓ)); u_k is applied from t_k to t_{k+1}, held (zoh) or along a straight line to u_{k+1} (foh); before the first
sample u = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numba import njit
from numpy.typing import NDArray

from camid.plant import TransferFunction

HOLDS = ("zoh", "foh")
SENSORS = ("camera", "instant")
# Times that differ by less than this share of the period are the same instant.
SAME_INSTANT = 1e-9
PERIOD_TOLERANCE = 1e-6

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Acquisition:
    """How the input is held and how the output is sampled.

    Attributes
    ----------
    period : float
        Sampling period T in seconds.
    hold : {"zoh", "foh"}
        Intersample behaviour of the input.
    sensor : {"camera", "instant"}
        Mean over the exposure, or the value at one instant.
    exposure : float, optional
        τ in seconds, 0 < τ ≤ T; the period where it is not given. Ignored by an instant sensor.
    latency : float
        ℓ ≥ 0 in seconds.

    Raises
    ------
    ValueError
        If a value is outside its range.
    """

    period: float
    hold: str = "zoh"
    sensor: str = "camera"
    exposure: float | None = None
    latency: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.period) and self.period > 0.0):
            raise ValueError(f"period = {self.period} s: it must be positive")
        if self.hold not in HOLDS:
            raise ValueError(f"hold = {self.hold!r}: it must be one of {', '.join(HOLDS)}")
        if self.sensor not in SENSORS:
            raise ValueError(f"sensor = {self.sensor!r}: it must be one of {', '.join(SENSORS)}")
        if not (np.isfinite(self.latency) and self.latency >= 0.0):
            raise ValueError(f"latency = {self.latency} s: it must be zero or positive")
        exposure = self.period if self.exposure is None else self.exposure
        if not (np.isfinite(exposure) and exposure > 0.0):
            raise ValueError(f"exposure = {exposure} s: it must be positive (an instant sensor has kind: instant)")
        if exposure > self.period * (1.0 + PERIOD_TOLERANCE):
            raise ValueError(f"exposure = {exposure} s is longer than the period of {self.period:.9g} s")
        object.__setattr__(self, "exposure", min(exposure, self.period))

    def window(self) -> tuple[int, float, float, bool]:
        """Where the sensor's window lies on the grid of the input.

        Returns
        -------
        delay : int
            The window of frame k begins in the interval that starts at t_{k - delay}.
        start, length : float
            Begin of the window after t_{k - delay}, and its length (0 for an instant sensor), in seconds.
        straddles : bool
            Whether it ends in the next interval of the input.
        """
        length = 0.0 if self.sensor == "instant" else float(self.exposure or 0.0)
        back = (self.latency + length) / self.period
        nearest = round(back)
        delay = nearest if abs(back - nearest) < SAME_INSTANT else ceil(back)
        start = max(delay - back, 0.0) * self.period
        if start < SAME_INSTANT * self.period:
            start = 0.0
        return delay, start, length, start + length > self.period * (1.0 + SAME_INSTANT)


@njit(cache=True)
def _exponential_and_integral(matrix: Array, duration: float) -> tuple[Array, Array]:
    """Exp(F h) and its integral over [0, h], by a Taylor series of a halved duration and doubling.

    Doubling keeps the integral as exact as the exponential even where F is singular, which a formula with the inverse
    of F would not.
    """
    size = matrix.shape[0]
    identity = np.eye(size)
    scaled = matrix * duration
    norm = 0.0
    for i in range(size):
        norm = max(norm, np.sum(np.abs(scaled[i])))
    if not np.isfinite(norm):
        return np.full((size, size), np.nan), np.full((size, size), np.nan)
    halvings = 0
    while norm > 0.5:
        norm *= 0.5
        halvings += 1
    step = duration / 2.0**halvings
    scaled = matrix * step
    exponential = identity.copy()
    integral = identity.copy()
    term = identity.copy()
    for k in range(1, 15):  # 0.5**15 / 15! lies below the rounding error
        term = term @ scaled / k
        exponential += term
        integral += term / (k + 1)
    integral *= step
    for _ in range(halvings):
        integral = integral + exponential @ integral
        exponential = exponential @ exponential
    return exponential, integral


@njit(cache=True)
def _run(  # noqa: PLR0912 - one loop, so that it compiles to one
    state_matrix: Array,
    input_vector: Array,
    initial_state: Array,
    selection: Array,
    signal: Array,
    first_order: bool,
    period: float,
    delay: int,
    start: float,
    length: float,
    straddles: bool,
    begin: int,
) -> Array:
    """Sampled sensor outputs of a linear system with one held input; see :func:`respond`."""
    order = state_matrix.shape[0]
    outputs, count = selection.shape[0], signal.shape[0]
    # The input and its slope are states of their own, so one exponential holds the transitions for both holds.
    augmented = np.zeros((order + 2, order + 2))
    augmented[:order, :order] = state_matrix
    augmented[:order, order] = input_vector
    augmented[order, order + 1] = 1.0
    transition = _exponential_and_integral(augmented, period)[0]
    first = np.zeros((outputs, order + 2))
    second = np.zeros((outputs, order + 2))
    onset = _exponential_and_integral(augmented, start)[0]
    if length == 0.0:
        first = selection @ np.ascontiguousarray(onset[: order + 1])
    elif not straddles:
        mean = _exponential_and_integral(augmented, length)[1] @ onset / length
        first = selection @ np.ascontiguousarray(mean[: order + 1])
    else:
        before = _exponential_and_integral(augmented, period - start)[1] @ onset / length
        after = _exponential_and_integral(augmented, start + length - period)[1] / length
        first = selection @ np.ascontiguousarray(before[: order + 1])
        second = selection @ np.ascontiguousarray(after[: order + 1])

    result = np.zeros((count, outputs))
    now = np.zeros(order + 2)
    following = np.zeros(order + 2)
    for j in range(-delay, count - delay):
        if j == begin:
            now[:order] += initial_state
        if j == 0:
            # The record begins: the input jumps from 0 to its first value.
            now[order] = signal[0]
            now[order + 1] = (signal[1] - signal[0]) / period if first_order and count > 1 else 0.0
        for row in range(order):
            total = 0.0
            for column in range(order + 2):
                total += transition[row, column] * now[column]
            following[row] = total
        following[order] = signal[j + 1] if 0 <= j + 1 < count else 0.0
        following[order + 1] = 0.0
        if first_order and j + 1 >= 0 and j + 2 < count:
            following[order + 1] = (signal[j + 2] - signal[j + 1]) / period
        frame = j + delay
        for row in range(outputs):
            total = 0.0
            for column in range(order + 2):
                total += first[row, column] * now[column]
            if straddles:
                for column in range(order + 2):
                    total += second[row, column] * following[column]
            result[frame, row] = total
        for row in range(order + 2):
            now[row] = following[row]
    return result


def respond(
    state_matrix: Array,
    input_vector: Array,
    initial_state: Array,
    selection: Array,
    signal: Array,
    acquisition: Acquisition,
    time_unit: float = 1.0,
    *,
    before_record: bool = True,
) -> Array:
    """Run dX/dt' = A X + B u through the hold and the sensor.

    Parameters
    ----------
    state_matrix : ndarray, shape (p, p)
        In units of ``1/time_unit``: t' = t / time_unit.
    input_vector, initial_state : ndarray, shape (p,)
        The input is zero before t_0.
    selection : ndarray, shape (q, p + 1)
        Rows that pick the wanted combinations of states and (last column) input, after the sensor.
    signal : ndarray, shape (N,)
        Input samples u_k.
    acquisition : Acquisition
    time_unit : float
        Seconds in a unit of the scaled time.
    before_record : bool
        Whether the initial state is that at t_0 - delay·T, where the interval begins in which the first frame was
        exposed, or that at t_0. The second leaves the frames that were exposed before t_0 without free motion.

    Returns
    -------
    ndarray, shape (N, q)
        Row k belongs to frame k.
    """
    delay, start, length, straddles = acquisition.window()
    return _run(
        np.ascontiguousarray(state_matrix, dtype=np.float64),
        np.ascontiguousarray(input_vector, dtype=np.float64),
        np.ascontiguousarray(initial_state, dtype=np.float64),
        np.ascontiguousarray(selection, dtype=np.float64),
        np.ascontiguousarray(signal, dtype=np.float64),
        acquisition.hold == "foh",
        acquisition.period / time_unit,
        delay,
        start / time_unit,
        length / time_unit,
        straddles,
        -delay if before_record else 0,
    )


def companion(denominator: Array) -> Array:
    """Companion matrix of a monic polynomial, shape (n, n), for the states z^(n-1), …, z' and z of z = u / A."""
    coefficients = np.asarray(denominator, dtype=float)
    return np.eye(len(coefficients) - 1, k=-1) - np.outer(np.eye(len(coefficients) - 1)[0], coefficients[1:])


def time_scale(denominator: tuple[float, ...] | Array) -> float:
    """Time unit in seconds in which the coefficients of a monic denominator are of the order of one."""
    coefficients = np.abs(np.asarray(denominator, dtype=float))
    radii = [c ** (1.0 / i) for i, c in enumerate(coefficients) if i > 0 and c > 0.0]
    return 1.0 / max(radii) if radii else 1.0


def derivative_rows(denominator: Array, degrees: range | list[int]) -> Array:
    """Rows that pick the derivatives z^(degree) of z = u / A out of the companion states and the input.

    Returns
    -------
    ndarray, shape (len(degrees), n + 1)
    """
    order = len(denominator) - 1
    rows = np.zeros((len(degrees), order + 1))
    for row, degree in zip(rows, degrees, strict=True):
        if degree == order:  # z^(n) = u - a_1 z^(n-1) - … - a_n z
            row[:order] = -np.asarray(denominator, dtype=float)[1:]
            row[order] = 1.0
        else:
            row[order - 1 - degree] = 1.0
    return rows


def sample(
    plant: TransferFunction, signal: Array, acquisition: Acquisition, initial_state: Array | None = None
) -> Array:
    """Output samples of a plant behind a hold and before a sensor, exact to rounding.

    Parameters
    ----------
    plant : TransferFunction
    signal : ndarray, shape (N,)
        Input samples u_k, in the units of u.
    acquisition : Acquisition
    initial_state : ndarray, shape (n,), optional
        Coefficients of the initial polynomial C(s'), highest power first, so that C/A is the free motion that begins
        where :func:`respond` says, with s' in units of ``1/time_scale``; at rest where it is not given.

    Returns
    -------
    ndarray, shape (N,)
        w_k, in the units of y.
    """
    monic = plant.monic
    signal = np.asarray(signal, dtype=float)
    unit = time_scale(monic.denominator)
    order, degree = monic.order, len(monic.numerator) - 1
    if order == 0:
        return (
            monic.numerator[0]
            * respond(np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.ones((1, 1)), signal, acquisition)[:, 0]
        )
    denominator = np.asarray(monic.denominator) * unit ** np.arange(order + 1)
    numerator = np.asarray(monic.numerator) * unit ** (order - degree + np.arange(degree + 1.0))
    selection = numerator @ derivative_rows(denominator, range(degree, -1, -1))
    forced = respond(
        companion(denominator), np.eye(order)[0], np.zeros(order), selection[None, :], signal, acquisition, unit
    )[:, 0]
    if initial_state is None:
        return forced
    free = np.append(np.asarray(initial_state, dtype=float), 0.0)
    return (
        forced
        + respond(companion(denominator), np.zeros(order), np.eye(order)[0], free[None, :], signal, acquisition, unit)[
            :, 0
        ]
    )
