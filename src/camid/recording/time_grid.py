"""Sampling of a recording: the order of its times, their period, and the regular grid that irregular times go onto.

Times that are regular, or would be except for the rounding of their digits, stay as they are. Others are brought onto
the grid of the period. The output is interpolated there by cubic splines (not-a-knot) through the rows of each part
without gaps: a shape-preserving cubic (PCHIP) flattens every extremum: of an oscillation of ten rows per period it
misses up to 4.9 % of the amplitude, the spline 0.05 %. Motion has no jumps at which a spline would overshoot. Midway
between rows it leaves three quarters of the variance of noise, PCHIP and the straight line one half.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError

Array = NDArray[np.float64]

# Steps that differ from the period by less than this share are regular (design, section 1).
PERIOD_TOLERANCE = 1e-6
# Rounding of the times, as a share of the period, that still tells a missing row from a rounded one.
COARSEST_RESOLUTION = 0.5
# Row numbers that are farther apart, in periods, have a gap between them, over which nothing is interpolated.
LARGEST_STEP = 1.5
# A row of the grid beyond the last row before a gap is still known if it is that near, in periods.
REACH = 0.1
# More than this is too irregular: largest over smallest step that is not a gap, and share of the grid without data.
LARGEST_SPREAD = 20.0
LARGEST_SHARE_MISSING = 0.5

# The scatter of the times is negligible if what it changes in the values is below this share of their noise (1 % of its
# variance), and if it is below the second share of the period: of values as rough as noise nothing else could be told.
NEGLIGIBLE_SHARE = 0.1
NEGLIGIBLE_SCATTER = 0.01
FEWEST_FOR_NOISE = 10
VARIANCE_OF_FOURTH_DIFFERENCES = 70.0  # 1 + 16 + 36 + 16 + 1, of white noise of variance one


@dataclass(frozen=True)
class Grid:
    """Regular times that a recording is brought onto.

    Attributes
    ----------
    time : ndarray, shape (N,)
        Seconds. The recorded times themselves where they are regular.
    recorded : ndarray, shape (M,)
        Recorded times.
    period, uncertainty : float
        Seconds.
    regular : bool
        Whether ``time`` and ``recorded`` are the same.
    deviation : float
        Largest distance of a recorded time from the grid, in periods.
    scatter : float
        Root mean square of those distances, in seconds.
    gaps : ndarray of bool, shape (M - 1,), or None
        Steps in which rows are missing; None if there are none.
    """

    time: Array
    recorded: Array
    period: float
    uncertainty: float = 0.0
    regular: bool = True
    deviation: float = 0.0
    scatter: float = 0.0
    gaps: NDArray[np.bool_] | None = None

    def rows_missing(self) -> int:
        """Number of rows of the grid that lie in its gaps."""
        if self.gaps is None:
            return 0
        return max(round(float(np.sum(np.diff(self.recorded)[self.gaps])) / self.period) - int(self.gaps.sum()), 0)

    @property
    def off_by_rounding(self) -> bool:
        """Whether all recorded times are those of the grid, but for the rounding that regular times have, too."""
        resolutions = [r for r in _resolutions(self.recorded) if r <= COARSEST_RESOLUTION * self.period]
        return self.deviation <= max([PERIOD_TOLERANCE, *(1.5 * r / self.period for r in resolutions)])

    def negligible_for(self, values: Array) -> bool:
        """Whether what the scatter of the times changes in recorded values, shape (M,), is lost in their noise.

        The change is the slope of the values times the distance of a row from the grid. Their noise is taken from their
        fourth differences, where a signal of ten rows a period or more leaves next to nothing, and is no less than the
        rounding to the step in which the values are written.
        """
        known = values[np.isfinite(values)]
        if self.regular or len(known) < FEWEST_FOR_NOISE:
            return self.regular
        noise = noise_of(known)
        levels = np.unique(known)
        rounding = float(np.min(np.diff(levels))) / np.sqrt(12.0) if len(levels) > 1 else np.inf
        change = float(np.sqrt(np.mean(np.diff(known) ** 2))) / self.period * self.scatter
        small = self.scatter <= NEGLIGIBLE_SCATTER * self.period
        return bool(small and change <= NEGLIGIBLE_SHARE * max(noise, rounding))

    def interpolated(self, values: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Output on the grid, and where it is missing; NaN in ``values``, shape (M,), are missing, too.

        What is missing gets a value on the straight line between its neighbours, or, at the ends, a mirrored one.
        """
        known = np.isfinite(values)
        if self.regular:
            result, found = values.copy(), known
        else:
            result, found = np.zeros(len(self.time)), np.zeros(len(self.time), bool)
            rows = np.flatnonzero(known)
            parts = np.split(rows, np.flatnonzero(np.diff(self.recorded[rows]) > LARGEST_STEP * self.period) + 1)
            for part in parts:
                near = self._near(part)
                result[near], found[near] = spline(self.recorded[part], values[part], self.time[near]), True
        if not found.any():
            return result, ~found
        rows = np.flatnonzero(found)
        result[~found] = np.interp(self.time[~found], self.time[found], result[found])
        # A value that is repeated at the ends would look like a frame that was delivered twice.
        inner = result[rows[0] : rows[-1] + 1]
        return np.pad(inner, (rows[0], len(result) - 1 - rows[-1]), mode="reflect"), ~found

    def _near(self, part: NDArray[np.intp]) -> slice:
        """Row numbers of the grid between the first and the last of some recorded rows, and hardly farther."""
        if part.size == 0:
            return slice(0, 0)
        margin = REACH * self.period
        first = int(np.searchsorted(self.time, self.recorded[part[0]] - margin))
        return slice(first, int(np.searchsorted(self.time, self.recorded[part[-1]] + margin, side="right")))

    def held(self, values: Array, hold: str) -> Array:
        """Input on the grid.

        The corners of a first-order hold are read off its lines, those of a band-limited input off a spline. Of a
        zero-order hold it is the mean over the period that starts at the grid's time: the value there alone would be
        that of the row before wherever a time stamp is slightly late. Before the first row nothing acts.
        """
        if self.regular:
            return values
        if hold == "foh":
            lines = np.interp(self.time, self.recorded, values)
            before = np.clip(np.searchsorted(self.recorded, self.time, side="right") - 1, 0, len(values) - 1)
            if self.gaps is None:
                return lines
            return np.where(np.append(self.gaps, False)[before], values[before], lines)
        if hold == "band-limited" and self.gaps is None:
            return spline(self.recorded, values, np.clip(self.time, self.recorded[0], self.recorded[-1]))
        # A grid that begins after the first row has what its input did until then in the first step.
        begin = min(self.time[0], self.recorded[0])
        edges = np.concatenate([[begin], self.time[1:], [self.time[-1] + self.period]])
        knots = np.concatenate([[begin], self.recorded, [max(edges[-1], self.recorded[-1])]])
        area = np.concatenate([[0.0], np.cumsum(np.diff(knots) * np.concatenate([[0.0], values]))])
        return np.diff(np.interp(edges, knots, area)) / self.period


def noise_of(values: Array) -> float:
    """Standard deviation of the noise of values, shape (N,), by their fourth differences."""
    return float(np.std(np.diff(values, 4))) / float(np.sqrt(VARIANCE_OF_FOURTH_DIFFERENCES))


def spline(time: Array, values: Array, wanted: Array) -> Array:
    """Cubic spline (not-a-knot) through ``values``; a parabola, a line or a constant through fewer than four."""
    if len(time) == 1:
        return np.full(len(wanted), values[0])
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(time, values)(wanted), dtype=np.float64)


def check_order(time: Array, where: Callable[[int], str]) -> None:
    """Refuse times that repeat or go back; ``where`` names the place of a row."""
    steps = np.diff(time)
    wrong = np.flatnonzero(steps <= 0.0)
    if wrong.size == 0:
        return
    row = int(wrong[0]) + 1
    if steps[row - 1] == 0.0:
        raise InputError(f"the time {time[row]:.9g} s appears twice", where=where(row), hint="remove one of the rows")
    raise InputError(
        f"the time goes back from {time[row - 1]:.9g} s to {time[row]:.9g} s",
        where=where(row),
        hint="sort the rows by time",
    )


def grid_of(time: Array, where: Callable[[int], str]) -> Grid:
    """Grid for increasing times, shape (M,), M ≥ 2.

    Raises
    ------
    InputError
        If they are too irregular to interpolate between them.
    """
    steps = np.diff(time)
    median = float(np.median(steps))
    if np.max(np.abs(steps - median)) <= PERIOD_TOLERANCE * median:
        return Grid(time, time, median)
    # Rounded times, such as 0.033, 0.067, 0.100 at 30 frames/s: no step is exact, but all times lie along a straight
    # line within the rounding. Digits as coarse as the period would hide a missing row.
    count = np.arange(len(time), dtype=float)
    slope, _, spread = _line(count, time)
    for resolution in _resolutions(time):
        if resolution <= COARSEST_RESOLUTION * median and spread <= 1.5 * resolution:
            return Grid(time, time, slope, 2.0 * resolution / (len(time) - 1))
    return _irregular(time, steps, median, where)


def _irregular(time: Array, steps: Array, median: float, where: Callable[[int], str]) -> Grid:
    near = steps[(steps > 0.5 * median) & (steps < LARGEST_STEP * median)]
    typical = float(np.mean(near)) if near.size else median
    slope = _line(_labelled(steps, typical), time)[0]
    # No row is missing, or one wherever the steps say so.
    labels = [np.arange(len(time), dtype=float), _labelled(steps, typical), _labelled(steps, slope)]
    deviation, count = min(((_deviation(time, c), c) for c in labels), key=lambda pair: pair[0])
    if deviation < 0.5:
        period, origin, _ = _line(count, time)
        size, gaps = int(count[-1]) + 1, np.diff(count) > 1.0
    else:  # the rate wanders: any grid will do that is as dense as the rows
        period, origin = typical, float(time[0])
        size, gaps = int(np.floor((time[-1] - time[0]) / period + REACH)) + 1, steps > LARGEST_STEP * typical
    _refuse_too_irregular(time, steps, period, size, where)
    grid = origin + np.float64(period) * np.arange(size, dtype=np.float64)
    deviations = np.abs((time - origin) / period - np.round((time - origin) / period))
    uncertainty = 2.0 * float(np.max(deviations)) * period / (len(time) - 1)
    return Grid(
        grid,
        time,
        period,
        uncertainty,
        regular=False,
        deviation=float(np.max(deviations)),
        scatter=float(np.sqrt(np.mean(deviations**2))) * period,
        gaps=gaps if gaps.any() else None,
    )


def _refuse_too_irregular(time: Array, steps: Array, period: float, size: int, where: Callable[[int], str]) -> None:
    smallest, largest = int(np.argmin(steps)), int(np.argmax(steps))
    if min(float(steps[largest]), LARGEST_STEP * period) > LARGEST_SPREAD * steps[smallest]:
        raise InputError(
            f"a step of {steps[smallest]:.6g} s where the period is {period:.6g} s: the sampling is too irregular",
            where=where(smallest + 1),
            hint="remove one of the two rows, or resample to a constant period",
        )
    dense = steps[steps <= LARGEST_STEP * period]
    share = 1.0 - (float(np.sum(dense)) / period + len(steps) - len(dense) + 1.0) / size
    if share > LARGEST_SHARE_MISSING:
        raise InputError(
            f"{100 * share:.3g} % of the period's grid has no row near, the largest gap being {steps[largest]:.6g} s: "
            "the sampling is too irregular",
            where=where(largest + 1),
            hint="cut the recording at the gaps, or resample to a constant period",
        )


def _line(count: Array, time: Array) -> tuple[float, float, float]:
    """Slope, origin and spread of the straight line of the times over their number in the grid."""
    centre, middle = float(np.mean(count)), float(np.mean(time - time[0]))
    slope = float((count - centre) @ (time - time[0] - middle) / ((count - centre) @ (count - centre)))
    return slope, float(time[0]) + middle - slope * centre, float(np.ptp(time - time[0] - slope * count))


def _labelled(steps: Array, period: float) -> Array:
    """Number of each row in a grid of the period, from the steps between the rows."""
    return np.concatenate([[0.0], np.cumsum(np.maximum(np.round(steps / period), 1.0))])


def _deviation(time: Array, count: Array) -> float:
    """Largest distance of a row from its place in the grid, in periods."""
    slope, origin, _ = _line(count, time)
    return float(np.max(np.abs(time - origin - slope * count))) / slope


def _resolutions(time: Array) -> list[float]:
    """Seconds to which the times may be rounded: by the floating point of large offsets, and by their decimals.

    Of times that are written with so many significant digits the largest have the fewest decimals.
    """
    largest = float(np.max(np.abs(time)))
    rounding = 4.0 * float(np.spacing(largest))
    decade = 10.0 ** np.floor(np.log10(largest)) if largest > 0.0 else 0.0
    written = (_decimals(each, rounding) for each in (time, time[np.abs(time) >= decade]))
    return [rounding, *(rounding + 10.0**-decimals for decimals in written if decimals is not None)]


def _decimals(time: Array, rounding: float) -> int | None:
    """Decimals with which times are written; None where they have all."""
    for decimals in range(16):
        if 10.0**-decimals <= rounding:
            break
        if np.max(np.abs(np.round(time, decimals) - time), initial=0.0) <= rounding:
            return decimals
    return None
