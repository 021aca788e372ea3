"""Hysteresis that saturates more suddenly than the plain Bouc–Wen law: its exponent is free."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.compiled import njit
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.hysteresis import Hysteresis
from camid.effects.parameter import Parameter
from camid.effects.situation import Situation

# First guesses of the exponent.
EXPONENTS = (2.0, 4.0)
# Normalised ways at which a loop is worked out, and steps between two of them; what is left of saturation behind the
# last way is a power of e of about -SATURATED.
WAYS, STEPS, SATURATED = 401, 2, 30.0
# Where they stand among the values of a force: their distance, then the loop there, then its slopes.
DISTANCE, FIRST = 3, 4
# Steps of Newton's method to the way behind a loop, from a chord: a cubic is nearly straight between two ways.
NEWTON_STEPS = 3


@njit(error_model="numpy")
def virgin_loop(exponent: float) -> tuple[float, NDArray[np.float64]]:
    """The loop from zero, dz/dx = 1 - z^n, by the classical Runge-Kutta method.

    Returns
    -------
    float
        Distance of the ways.
    ndarray, shape (2, WAYS)
        z there, and its slopes.
    """
    distance = (1.0 + SATURATED / exponent) / (WAYS - 1)
    step = distance / STEPS
    loop = np.empty((2, WAYS))
    z = 0.0
    for k in range(WAYS):
        if k > 0:
            for _ in range(STEPS):
                first = 1.0 - z**exponent
                second = 1.0 - (z + 0.5 * step * first) ** exponent
                third = 1.0 - (z + 0.5 * step * second) ** exponent
                fourth = 1.0 - (z + step * third) ** exponent
                z = min(z + step * (first + 2.0 * second + 2.0 * third + fourth) / 6.0, 1.0)
        loop[0, k] = z
        loop[1, k] = 1.0 - z**exponent
    return distance, loop


@njit(error_model="numpy")
def _between(share: float, cell: int, values: Any) -> tuple[float, float]:
    """The loop, and its slope, at a share of the distance behind one of its ways: Hermite's cubic."""
    start, end = values[FIRST + cell], values[FIRST + cell + 1]
    slopes = FIRST + WAYS + cell
    leaving, arriving = values[DISTANCE] * values[slopes], values[DISTANCE] * values[slopes + 1]
    square = 3.0 * (end - start) - 2.0 * leaving - arriving
    cube = leaving + arriving - 2.0 * (end - start)
    slope = leaving + share * (2.0 * square + 3.0 * share * cube)
    return start + share * (leaving + share * (square + share * cube)), slope


@njit(error_model="numpy")
def further_along(along: float, way: float, values: Any) -> float:
    """What a force along its own sign, of at most 1, becomes over a normalised way."""
    low, high = 0, WAYS - 1
    if along >= values[FIRST + high]:
        return along
    while high - low > 1:
        middle = (low + high) // 2
        if values[FIRST + middle] <= along:
            low = middle
        else:
            high = middle
    share = (along - values[FIRST + low]) / (values[FIRST + high] - values[FIRST + low])
    for _ in range(NEWTON_STEPS):
        found, slope = _between(share, low, values)
        share = min(max(share + (along - found) / slope, 0.0), 1.0) if slope > 0.0 else share
    behind = low + share + way / values[DISTANCE]
    if behind >= WAYS - 1:
        return float(values[FIRST + WAYS - 1])
    cell = int(behind)
    return float(_between(behind - cell, cell, values)[0])


class HysteresisOfAnyPower(Hysteresis):
    """Bouc–Wen hysteresis with its exponent: the larger it is, the longer the force is straight before it saturates."""

    title = "Hysteresis (Bouc-Wen) of any power"
    equation = (
        r"f = h\,z,\quad \dot z = \kappa\left(\dot y - \frac{1}{2}|\dot y|\,z\,|z|^{n-1} "
        r"- \frac{1}{2}\dot y\,|z|^n\right)"
    )
    reference = Hysteresis.reference
    parameters = (
        *Hysteresis.parameters,
        Parameter("exponent", "", "exponent n; 1 for the plain law", 1.0, 20.0, scale="one"),
    )

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        # Exact against the present sign of z; along it, on the loop from zero, which all parts of loops are.
        way = values[1] * position
        side = 1.0 if way >= 0.0 else -1.0
        along, way = side * memory, side * way
        if along < 0.0:
            if way <= -along:
                return side * (along + way)
            way, along = way + along, 0.0
        return side * further_along(along, way, values)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """The parameters, and behind them the loop from zero: its way has a closed form, and not what it is there."""
        distance, loop = virgin_loop(self.values["exponent"])
        return [*super().force_values(plant), distance, *loop.ravel().tolist()]

    def simplified(self) -> Hysteresis:  # type: ignore[override] # with less detail, and not another name
        """The plain law."""
        return Hysteresis(strength=self.values["strength"], shape=self.values["shape"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None: friction has a loop that saturates."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """As stiff at first, and more sudden."""
        for exponent in EXPONENTS:
            yield cls(**{"exponent": exponent, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a plain law that was found."""
        yield from ()
