"""The offset and the skew between two clocks from a signal that both tables hold: a motion, a flash, a step.

What the clip holds is, up to gain and offset, the mean of what the other table holds over the exposure,

    a_i = c + g mean{b(t) : t_i' − τ ≤ t ≤ t_i'} + e_i,        t_i' = offset + (1 + skew) t_i,

which is fitted by least squares; the residual may be coloured, so the covariance is the sandwich with the weights of
Newey & West (1987, Econometrica 55, 703–708).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.recording.nature import nature_of

Array = NDArray[np.float64]

# Share of the shorter table that has to overlap.
LEAST_OVERLAP = 0.4
# Parts of the clip whose lags show the skew, the largest skew that is looked for, and fewest rows of a part.
PARTS = 8
LARGEST_SKEW = 5e-3
FEWEST_ROWS = 40
# Share of its power that a part of a signal needs to say where it lies, and below which it stands still.
LEAST_SHARE, LEAST_POWER = 0.05, 1e-3
# Correlation of two signals that are one.
LEAST_CORRELATION = 0.7
# Standard deviation of the skew between clocks that are not set, where nothing is known of it.
USUAL_SKEW = 1e-3
# Half the window of the local cubics that smooth a signal of the drive, in frames, and fewest samples of a window.
SMOOTHED = 2.0
SHORTEST_WINDOW = 7
# Lags over which the noise may be correlated, as a share of the cube root of the number of rows.
LAGS_PER_ROOT = 4.0


@dataclass(frozen=True)
class Clocks:
    """Time of the drive = offset + (1 + skew) · time of the clip.

    Attributes
    ----------
    offset, skew : float
        Seconds, and without unit.
    covariance : ndarray, shape (2, 2)
        Of both.
    correlation : float
        Of the signals once they are aligned.
    """

    offset: float
    skew: float
    covariance: Array
    correlation: float

    @property
    def offset_deviation(self) -> float:
        """Standard deviation in seconds, at time zero of the clip."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def skew_deviation(self) -> float:
        """Standard deviation."""
        return float(np.sqrt(self.covariance[1, 1]))

    def to_drive(self, time: Array) -> Array:
        """Times of the clip on the clock of the drive."""
        return self.offset + (1.0 + self.skew) * time

    def counted_from(self, clip: float, drive: float) -> Clocks:
        """The same clocks, whose times were counted from these of their tables, by the tables' own zeros."""
        rate = 1.0 + self.skew
        carried = np.array([[1.0, -clip], [0.0, 1.0]])
        offset = drive + self.offset - rate * clip
        return Clocks(offset, self.skew, carried @ self.covariance @ carried.T, self.correlation)

    def uncertainty(self, time: float) -> float:
        """Standard deviation in seconds of a time of the clip on the clock of the drive."""
        row = np.array([1.0, time])
        return float(np.sqrt(row @ self.covariance @ row))


class CommonSignal:
    """A signal of the drive as the clip would see it; ``edges`` has the times at which one that is held changes."""

    def __init__(self, time: Array, values: Array, exposure: float, frame: float = 0.0) -> None:
        """Of a drive's column.

        Parameters
        ----------
        time, values : ndarray, shape (M,)
        exposure : float
            Seconds.
        frame : float
            Seconds between frames: what changes faster is noise, whose slopes would count as those of the motion.
        """
        from scipy.interpolate import CubicSpline, PPoly
        from scipy.signal import savgol_filter

        nature = nature_of(values)
        self.edges = np.zeros(0)
        if nature is not None and nature.kind == "held":
            self.edges = time[1:][np.diff(values) != 0.0]
            steps = np.append(np.diff(time), np.median(np.diff(time)))
            edges = np.append(time, time[-1] + steps[-1])
            self._curve = PPoly(values[None, :], edges)
        else:
            window = 2 * int(SMOOTHED * frame / float(np.median(np.diff(time)))) + 1
            if SHORTEST_WINDOW <= window < len(values):
                values = savgol_filter(values, window, 3)
            self._curve = CubicSpline(time, values)
        self.start, self.end = float(time[0]), float(time[-1])
        self.exposure = exposure
        self._integral = self._curve.antiderivative()

    def at(self, time: Array) -> Array:
        """Mean over exposures that end at times of the drive, in their shape."""
        inside = np.clip(time, self.start + self.exposure, self.end)
        if self.exposure <= 0.0:
            return np.asarray(self._curve(inside))
        return np.asarray((self._integral(inside) - self._integral(inside - self.exposure)) / self.exposure)

    def rate(self, time: Array) -> Array:
        """Derivative of :meth:`at` by the time."""
        inside = np.clip(time, self.start + self.exposure, self.end)
        if self.exposure <= 0.0:
            return np.asarray(self._curve.derivative()(inside))
        return np.asarray((self._curve(inside) - self._curve(inside - self.exposure)) / self.exposure)

    def covers(self, time: Array) -> NDArray[np.bool_]:
        """Whether exposures that end at these times lie within the table."""
        return np.asarray((time - self.exposure >= self.start) & (time <= self.end))


def first_alignment(
    time: Array, seen: Array, other_time: Array, other: Array, rank: int = 0
) -> tuple[float, float, float]:
    """Offset, skew and correlation without derivatives: by correlation, over all lags and then part by part.

    Parameters
    ----------
    time, seen : ndarray, shape (N,)
        Of the clip.
    other_time, other : ndarray, shape (M,)
        Of the drive.
    rank : int
        Which of the peaks of the correlation is taken; 0 is the highest.

    Raises
    ------
    ValueError
        If the tables overlap nowhere, or a signal does not change, or there are not so many peaks.
    """
    if float(np.ptp(seen)) == 0.0 or float(np.ptp(other)) == 0.0:
        raise ValueError("what is matched does not change")
    step = min(float(np.median(np.diff(time))), float(np.median(np.diff(other_time))))
    step = max(step, float(np.median(np.diff(time))) / 8.0)
    grid, other_grid = (np.arange(t[0], t[-1] + 0.5 * step, step) for t in (time, other_time))
    a, b = np.interp(grid, time, seen), np.interp(other_grid, other_time, other)
    lag, correlation = _best_lag(a, b, None, rank)
    offset = other_grid[0] + lag * step - grid[0]
    middles, lags = [], []
    for part in np.array_split(np.arange(len(a)), PARTS):
        if len(part) < FEWEST_ROWS or float(np.var(a[part])) < LEAST_SHARE * float(np.var(a)):
            continue
        reach = int(LARGEST_SKEW * (grid[-1] - grid[0]) / step) + 3
        try:
            found, agreement = _best_lag(a[part], b, (lag + part[0] - reach, lag + part[0] + reach))
        except ValueError:  # this part lies outside the other table
            continue
        if agreement > LEAST_CORRELATION:
            middles.append(float(grid[part].mean()))
            lags.append((found - part[0]) * step)
    if len(middles) < 3:
        return offset, 0.0, correlation
    slope = _median_slope(np.array(middles), np.array(lags))
    intercept = float(np.median(np.array(lags) - slope * np.array(middles)))
    return other_grid[0] + intercept - grid[0], slope, correlation


def _median_slope(x: Array, y: Array) -> float:
    """Slope that outliers do not move (Theil 1950, Sen 1968)."""
    from scipy.stats import theilslopes

    return float(theilslopes(y, x)[0])


def _best_lag(a: Array, b: Array, allowed: tuple[int, int] | None, rank: int = 0) -> tuple[float, float]:
    """Row of ``b`` at which ``a`` starts, with a fraction, and the correlation there."""
    from scipy.signal import fftconvolve, find_peaks

    least = int(LEAST_OVERLAP * min(len(a), len(b)))
    ones_a, ones_b = np.ones(len(a)), np.ones(len(b))

    def moved(x: Array, y: Array) -> Array:
        return np.asarray(fftconvolve(y, x[::-1], mode="full"))

    count = np.maximum(np.round(moved(ones_a, ones_b)), 1.0)
    sum_a, sum_b = moved(a, ones_b), moved(ones_a, b)
    # Where one of them stands still there is no correlation, whatever rounding leaves.
    variance_a = np.maximum(
        moved(a * a, ones_b) / count - (sum_a / count) ** 2, LEAST_POWER * float(np.var(a)) + 1e-300
    )
    variance_b = np.maximum(moved(ones_a, b * b) / count - (sum_b / count) ** 2, 1e-300)
    floor = LEAST_POWER * float(np.var(b)) + 1e-300
    found = (moved(a, b) / count - sum_a * sum_b / count**2) / np.sqrt(variance_a * np.maximum(variance_b, floor))
    lags = np.arange(len(found)) - (len(a) - 1)
    usable = count >= least
    if allowed is not None:
        usable &= (lags >= allowed[0]) & (lags <= allowed[1])
    if not usable.any():
        raise ValueError("the two tables overlap nowhere")
    size = np.where(usable, np.abs(found), -1.0)
    best = int(np.argmax(size))
    if rank:
        peaks = find_peaks(size)[0]
        if rank >= len(peaks):
            raise ValueError("the correlation has no other peak")
        best = int(peaks[np.argsort(-size[peaks])[rank]])
    fraction = 0.0
    if 0 < best < len(size) - 1 and usable[best - 1] and usable[best + 1]:
        left, middle, right = size[best - 1 : best + 2]
        curvature = left - 2.0 * middle + right
        fraction = 0.5 * (left - right) / curvature if curvature < 0.0 else 0.0
    return float(lags[best] + fraction), float(size[best])


def aligned(time: Array, seen: Array, signal: CommonSignal, start: tuple[float, float]) -> Clocks:
    """Clocks by least squares.

    Parameters
    ----------
    time, seen : ndarray, shape (N,)
        Of the clip.
    signal : CommonSignal
    start : (float, float)
        Offset and skew to start from.

    Raises
    ------
    ValueError
        If the tables overlap in too few rows, or the signal does not change where they do.
    """
    from scipy.optimize import least_squares

    rows = signal.covers(start[0] + (1.0 + start[1]) * time)
    if np.count_nonzero(rows) < FEWEST_ROWS:
        raise ValueError(f"the two tables overlap in {np.count_nonzero(rows)} rows; {FEWEST_ROWS} are needed")
    known, values = time[rows], seen[rows]
    middle, length = float(known.mean()), float(np.ptp(known))
    period = float(np.median(np.diff(known)))
    # Time of the drive in the middle, in periods, and by how many it is gained over the record; then gain and offset.
    at_middle = start[0] + (1.0 + start[1]) * middle

    def drive(vector: Array) -> Array:
        share = (known - middle) / length
        return at_middle + period * vector[0] + (1.0 + start[1]) * (known - middle) + period * vector[1] * share

    def table(vector: Array) -> Array:
        at = drive(vector)
        rate = signal.rate(at) * period
        columns = [signal.at(at), np.ones(len(known)), vector[2] * rate, vector[2] * rate * (known - middle) / length]
        return np.column_stack(columns)[:, [2, 3, 0, 1]]

    first = np.column_stack([signal.at(drive(np.zeros(4))), np.ones(len(known))])
    gain, offset = np.linalg.lstsq(first, values, rcond=None)[0]
    if float(np.ptp(first[:, 0])) == 0.0 or gain == 0.0:
        raise ValueError("the signal does not change where the two tables overlap")

    def error(vector: Array) -> Array:
        return np.asarray(values - vector[2] * signal.at(drive(vector)) - vector[3])

    # Where steps say little of the skew it is that of clocks in general.
    usual = USUAL_SKEW * length / period

    def penalised(vector: Array) -> Array:
        return np.append(error(vector), spread * vector[1] / usual)

    def slope(vector: Array) -> Array:
        return np.vstack([-table(vector), [0.0, spread / usual, 0.0, 0.0]])

    spread = float(np.std(error(np.array([0.0, 0.0, gain, offset]))))
    found = least_squares(penalised, np.array([0.0, 0.0, gain, offset]), jac=slope, x_scale="jac")
    vector, residual = found.x, found.fun[:-1]
    if len(signal.edges):
        covariance = _of_edges(signal.edges, at_middle, length, period, usual)
    else:
        covariance = sandwich(table(vector), residual)[:2, :2] * period**2
    skew = start[1] + period * vector[1] / length
    carried = np.array([[1.0, -middle / length], [0.0, 1.0 / length]])
    total = at_middle + period * vector[0] - (1.0 + skew) * middle
    agreement = float(np.corrcoef(values, values - residual)[0, 1])
    return Clocks(float(total), float(skew), carried @ covariance @ carried.T, abs(agreement))


def _of_edges(edges: Array, middle: float, length: float, period: float, usual: float) -> Array:
    """Covariance of the time in the middle and of what is gained over the record, in s², from the edges of steps.

    The frames say between which two of them an edge lies; that is all that is sure of a flash whose exposure, rise and
    brightness are not known.
    """
    inside = edges[np.abs(edges - middle) <= 0.5 * length]
    table = np.column_stack([np.ones(len(inside)), (inside - middle) / length])
    precision = table.T @ table * 12.0 / period**2 + np.diag([0.0, 1.0 / (usual * period) ** 2])
    return np.asarray(np.linalg.pinv(precision))


def sandwich(table: Array, residual: Array) -> Array:
    """Covariance of least squares in noise that may be coloured."""
    count = len(residual)
    lags = min(int(LAGS_PER_ROOT * count ** (1.0 / 3.0)), count // 4)
    scores = table * residual[:, None]
    meat = scores.T @ scores
    for lag in range(1, lags + 1):
        cross = scores[lag:].T @ scores[:-lag]
        meat += (1.0 - lag / (lags + 1.0)) * (cross + cross.T)
    # Columns of one length: those of a small signal's rate would be lost in rounding beside the others.
    lengths = np.linalg.norm(table, axis=0)
    lengths[lengths == 0.0] = 1.0
    scaled = table / lengths
    inverse = np.linalg.pinv(scaled.T @ scaled) / np.outer(lengths, lengths)
    white = inverse * float(residual @ residual) / max(count - table.shape[1], 1)
    # Few products of weights may come out too small by chance; coloured noise never says more than white.
    return np.asarray(np.maximum(1.0, _largest_ratio(inverse @ meat @ inverse, white)) * white)


def _largest_ratio(covariance: Array, white: Array) -> float:
    """By how much the variance of the time in the middle, or of the skew, exceeds that in white noise."""
    return float(max(covariance[i, i] / white[i, i] for i in range(2)))
