"""An input that was logged at times of its own, between which frames lie wherever they do."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from camid.chain.hold import driven

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StraightPieces:
    """A function of time that consists of straight pieces.

    Attributes
    ----------
    time : ndarray, shape (M,)
        Seconds: where pieces start, growing.
    first, last : ndarray, shape (M,)
        Its values at the start and at the end of each; the last piece goes on for ever with the value that it starts
        with.
    before : float
        Its value before the first piece.
    """

    time: Array
    first: Array
    last: Array
    before: float = 0.0

    @cached_property
    def _sums(self) -> tuple[Array, Array, Array, Array, Array]:
        """Start, value and slope of the pieces, and the integrals of u and of t·u up to them; each (M + 1,)."""
        start = self.time - self.time[0]
        length = np.diff(start)
        slope = np.append((self.last - self.first)[:-1] / length, 0.0)
        area = self.first[:-1] * length + 0.5 * slope[:-1] * length**2
        moment = start[:-1] * area + 0.5 * self.first[:-1] * length**2 + slope[:-1] * length**3 / 3.0
        zero = np.zeros(1)
        return (
            np.concatenate([zero, start]),
            np.concatenate([[self.before], self.first]),
            np.concatenate([zero, slope]),
            np.concatenate([zero, zero, np.cumsum(area)]),
            np.concatenate([zero, zero, np.cumsum(moment)]),
        )

    def integrals(self, time: Array) -> tuple[Array, Array]:
        """∫u and ∫(t − t_0)·u from the first piece to times, shape (K,) each."""
        start, value, slope, area, moment = self._sums
        piece = np.searchsorted(self.time, time, side="right")
        within = time - self.time[0] - start[piece]
        added = value[piece] * within + 0.5 * slope[piece] * within**2
        first = start[piece] * added + 0.5 * value[piece] * within**2 + slope[piece] * within**3 / 3.0
        return area[piece] + added, moment[piece] + first

    def means(self, edges: Array) -> Array:
        """Mean between times, shape (K + 1,); the means are (K,)."""
        return np.asarray(np.diff(self.integrals(edges)[0]) / np.diff(edges))

    def at(self, time: Array) -> Array:
        """Values at times, shape (K,)."""
        start, value, slope, _, _ = self._sums
        piece = np.searchsorted(self.time, time, side="right")
        return np.asarray(value[piece] + slope[piece] * (time - self.time[0] - start[piece]))

    def on_grid(self, start: float, step: float, count: int) -> tuple[Array, Array]:
        """Values at the start and at the end of each step of a grid, shape (count,) each.

        A straight line in each step has the mean and the first moment of the function there: what a step leaves behind
        in a mass that it pushes is exact, wherever in the step the function changes.
        """
        edges: Array = start + step * np.arange(count + 1, dtype=np.float64)
        area, moment = self.integrals(edges)
        mean = np.diff(area) / step
        middle = 0.5 * (edges[1:] + edges[:-1]) - self.time[0]
        slope = 12.0 * (np.diff(moment) - middle * np.diff(area)) / step**3
        return mean - 0.5 * step * slope, mean + 0.5 * step * slope


@dataclass(frozen=True, eq=False)
class InputLog:
    """An input and the times of its samples. Two logs are the same only if they are the same object.

    Attributes
    ----------
    time : ndarray, shape (M,)
        Seconds, growing; by the clock of the frames.
    values : ndarray, shape (M,)
        u at these times. Before the first the input is zero, after the last it stays.
    hold : {"zoh", "foh", "band-limited"}
        How it goes on between them.
    """

    time: Array
    values: Array
    hold: str

    @property
    def period(self) -> float:
        """Seconds between samples."""
        return float(self.time[-1] - self.time[0]) / max(len(self.time) - 1, 1)

    def with_hold(self, hold: str) -> InputLog:
        """The same samples held otherwise."""
        return self if hold == self.hold else _held_otherwise(self, hold)

    @cached_property
    def pieces(self) -> StraightPieces:
        """The input between the samples."""
        corners, straight = driven(self.values, self.hold)
        return StraightPieces(self.time, corners, np.append(corners[1:], corners[-1]) if straight else corners)

    def on_grid(self, start: float, step: float, count: int) -> tuple[Array, Array]:
        """See :meth:`StraightPieces.on_grid`; the arrays may not be written to."""
        return _on_grid(self, start, step, count)

    def divided(self, parts: int) -> tuple[Array, Array, Array]:
        """Start of pieces and the input at their starts and ends, ``parts`` of them to a sample, shape (parts M,).

        One array stands for starts and ends where the input is held.
        """
        pieces = self.pieces
        if parts == 1:
            return pieces.time, pieces.first, pieces.last
        share = np.arange(parts) / parts
        lengths = np.append(np.diff(pieces.time), self.period)
        time = (pieces.time[:, None] + lengths[:, None] * share).ravel()
        if pieces.last is pieces.first:
            held = np.repeat(pieces.first, parts)
            return time, held, held
        slope = (pieces.last - pieces.first)[:, None]
        first = (pieces.first[:, None] + slope * share).ravel()
        return time, first, (pieces.first[:, None] + slope * (share + 1.0 / parts)).ravel()

    def samples(self, time: Array, period: float) -> Array:
        """What stands for the input in rows of a period that start at times, shape (K,): its mean over a held row."""
        if self.hold == "zoh":
            return self.pieces.means(np.append(time, time[-1] + period))
        return self.pieces.at(time)


@lru_cache(maxsize=16)
def _held_otherwise(log: InputLog, hold: str) -> InputLog:
    return replace(log, hold=hold)


@lru_cache(maxsize=16)
def _on_grid(log: InputLog, start: float, step: float, count: int) -> tuple[Array, Array]:
    lines = log.pieces.on_grid(start, step, count)
    for line in lines:
        line.flags.writeable = False
    return lines
