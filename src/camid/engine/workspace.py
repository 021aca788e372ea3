"""What the kernels of the integrator share: room to work in, and the kinds of forces that they have to look after."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit
from camid.engine.forces import Mechanics

Array = NDArray[np.float64]


class Workspace(NamedTuple):
    """Room for the state of a run and for what its steps work with; kernels allocate nothing.

    Attributes
    ----------
    state, following : ndarray, shape (q,)
        State now and after a step.
    memory, remembered : ndarray, shape (f,)
        Inner states of the effects now and after a step.
    before, between, after : ndarray, shape (f + 2,)
        Switches at the start of a step, in its middle and at its end.
    derivative : ndarray, shape (q,)
        Row that gives the derivative of the measured motion.
    work : ndarray, shape (10, max(q, f + 2))
    """

    state: Array
    following: Array
    memory: Array
    remembered: Array
    before: Array
    between: Array
    after: Array
    derivative: Array
    work: Array


@njit
def workspace_of(m: Mechanics, initial: Array) -> Workspace:
    """Room for a run from an initial state, shape (q,)."""
    size, count = len(initial), m.forces.functions.shape[1]
    return Workspace(
        initial.copy(),
        np.empty(size),
        m.forces.begun.copy(),
        np.zeros(count),
        np.ones(count + 2),
        np.ones(count + 2),
        np.ones(count + 2),
        np.zeros(size),
        np.zeros((10, max(size, count + 2))),
    )


class Kinds(NamedTuple):
    """What the forces of a chain ask of a step.

    Attributes
    ----------
    dry, kinks, remembers, forced : bool
        Whether there is dry friction that can hold the body, a kink, a force that remembers, or any force.
    stepwise : bool
        Whether a step is more than that of a linear system.
    """

    dry: bool
    kinks: bool
    remembers: bool
    forced: bool
    stepwise: bool


@kernel(inline="always")
def kinds_of(m: Mechanics) -> Kinds:
    """Kinds of the forces of a chain."""
    functions = m.forces.functions
    dry, kinks, remembers, forced = False, m.forces.implicit, False, False
    for i in range(functions.shape[1]):
        dry = dry or (functions[1, i] != 0 and m.sticks)
        kinks = kinks or functions[3, i] != 0
        remembers = remembers or functions[2, i] != 0
        forced = forced or functions[0, i] != 0 or functions[1, i] != 0
    return Kinds(dry, kinks, remembers, forced, forced or m.equations.function != 0)


@kernel(inline="always")
def copy(source: Array, target: Array) -> None:
    """Copy numbers; an assignment of whole arrays checks their shapes."""
    for i in range(len(source)):
        target[i] = source[i]
