"""How well responses to some signals explain the residual of a situation: to first order, and without a simulation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.effects.situation import Situation

Array = NDArray[np.float64]

# Rows that are looked at, evenly spread over so many from the begin of a recording on.
MOST_ROWS, MOST_SIMULATED = 2000, 30_000
# Share of a regressor beside the others below which nothing is left of it.
LEAST_LEFT = 1e-9


def sampled(plant: TransferFunction, signals: Array, acquisition: Acquisition) -> Array:
    """What a plant makes of signals at its input, shape (N,) or (N, c), in samples of its output, of the same shape."""
    columns = [sample(plant, each, acquisition) for each in signals.reshape(len(signals), -1).T]
    return np.column_stack(columns).reshape(signals.shape)


class ResidualRegression:
    """The residual of a situation, and responses, beside what the plant's coefficients can do.

    Parameters
    ----------
    situation : Situation
    respond : callable
        What becomes of signals, shape (N,) or (N, c), in the recorded output, of the same shape.

    Attributes
    ----------
    situation : Situation
        Its begin, as far as it is looked at.
    residual : ndarray, shape (n,)
        On the rows that are looked at.
    fails : bool
        Whether a response is no number.
    """

    def __init__(self, situation: Situation, respond: Callable[[Array], Array]) -> None:
        self.situation = situation = situation.until(MOST_SIMULATED)
        rows = np.flatnonzero(situation.used)
        self._rows = rows[:: max(len(rows) // MOST_ROWS, 1)]
        self._respond = respond
        others = [np.ones(len(situation.position)), situation.position, situation.signal, situation.velocity]
        responses = [respond(other)[self._rows] for other in others]
        table = np.column_stack([*responses, situation.position[self._rows], np.ones(len(self._rows))])
        self.fails = not np.all(np.isfinite(table))
        self.residual = np.zeros(len(self._rows))
        if self.fails:
            return
        basis, triangle = np.linalg.qr(table / np.maximum(np.linalg.norm(table, axis=0), 1e-300))
        self._basis = basis[:, np.abs(np.diag(triangle)) > LEAST_LEFT]
        residual = situation.residual[self._rows]
        self.residual = residual - self._basis @ (self._basis.T @ residual)

    def left(self, signals: Array) -> tuple[Array, NDArray[np.bool_]]:
        """What coefficients cannot do of responses to signals, shape (N, c): (n, c), and where that is something."""
        seen = self._respond(signals)[self._rows]
        left = seen - self._basis @ (self._basis.T @ seen)
        return left, np.linalg.norm(left, axis=0) > LEAST_LEFT * np.linalg.norm(seen, axis=0)

    @property
    def reversed_answer(self) -> Array:
        """What responds to the residual in reversed time, shape (N,): its product with a signal is the response's."""
        placed = np.zeros(len(self.situation.signal))
        placed[self._rows] = self.residual
        return self._respond(placed[::-1])[::-1]
