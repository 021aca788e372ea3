"""Which effects are static laws of the same variable as a learned one, and their values: tried, not asked by name."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from camid.chain.motion import WEIGHTS, Motion
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.learned import FORCES, LearnedEffect
from camid.effects.plant_force import motion_sign
from camid.engine.mechanics import FEWEST_VALUES
from camid.fitting.linearised_law import bend_of

Array = NDArray[np.float64]

# Values of time, of the other variables and of memory with which a static law does the same.
TRIALS = ((0.0, 1.0, 1.0, 0.0), (0.7, -1.3, 0.4, 0.2), (3.1, 0.6, -2.1, -0.5))
SAME = 1e-9


def static_values(effect: Effect, variables: str, at: Array, plant: TransferFunction, step: float) -> Array | None:
    """Force, or bend, of an effect as a function of what a learned law depends on; None where it is none.

    Parameters
    ----------
    effect : Effect
    variables : str
        Of the learned law.
    at : ndarray, shape (N,)
        Values of what it is over.
    plant : TransferFunction
    step : float
        Sampling period, s.
    """
    if isinstance(effect, LearnedEffect):
        return bend_of(effect, at) if effect.values["variables"] == variables else None
    if effect.noise_like or effect.is_constant or effect.corrects_declaration:
        return None
    if variables in FORCES:
        return _force(effect, variables, at, plant)
    if effect.place != ("actuator" if variables == "input" else "sensor"):
        return None
    return _bend(effect, variables, at, step)


def _force(effect: Effect, variables: str, at: Array, plant: TransferFunction) -> Array | None:
    if effect.memory_after is not None or (effect.force is None and effect.friction_level is None):
        return None
    over, times = FORCES[variables]
    numbers = effect.force_values(plant)
    # A compiled part may read zeros behind those that it gets, as in the engine.
    values = np.zeros(max(FEWEST_VALUES, len(numbers)))
    values[: len(numbers)] = numbers
    found: list[Array] = []
    for time, first, second, memory in TRIALS:
        rows = []
        for x in at:
            now = {"position": first, "velocity": second, "input": first * second, over: float(x)}
            force = _against_motion(effect, (time, now["position"], now["velocity"], now["input"], memory), values)
            rows.append(force / now[times] if times else force)
        found.append(np.array(rows))
    size = float(np.max(np.abs(found[0])))
    if size == 0.0 or not all(np.max(np.abs(other - found[0])) <= SAME * size for other in found[1:]):
        return None
    # Dry friction is against the motion whatever the signs; other forces have that of the input.
    return found[0] if times == "input" or effect.force is None else motion_sign(plant) * found[0]


def _against_motion(effect: Effect, state: tuple[float, float, float, float, float], values: Array) -> float:
    """Force and dry friction of an effect at a time, position, velocity, input and memory."""
    time, position, velocity, signal, memory = state
    total = 0.0
    if effect.force is not None:
        total += float(effect.force.function(*state, values))
    if effect.friction_level is not None:
        level = effect.friction_level.function(time, position, abs(velocity), signal, memory, values)
        total += float(np.sign(velocity) * level)
    return total


def _bend(effect: Effect, variables: str, at: Array, step: float) -> Array | None:
    """By how much a static curve bends, if it does the same in any order."""
    forth = np.arange(len(at))
    found = []
    for order in (forth, forth[::-1]):
        signal = at[order]
        if variables == "input":
            changed = effect.transform(signal, signal, step)[0]
        else:
            time = step * (1.0 + order[0]) * forth
            changed = effect.observe(_seen(effect, signal, time), time)
        bend = np.empty(len(at))
        bend[order] = np.asarray(changed) - signal
        found.append(bend)
    size = float(np.max(np.abs(at)))
    same = np.max(np.abs(found[0] - found[1])) <= SAME * size
    return found[0] if same and np.max(np.abs(found[0])) > SAME * size else None


class _Still:
    """Held positions, one for each exposure, for what a camera makes of a motion."""

    def __init__(self, positions: Array) -> None:
        self.positions = positions

    def points(self, start: Array, end: Array) -> Array:
        """The same within an exposure."""
        return np.repeat(self.positions[:, None], len(WEIGHTS), axis=1)


def _seen(effect: Effect, positions: Array, time: Array) -> Array:
    """What the camera makes of held positions; they themselves where it needs a motion."""
    try:
        measured = effect.measure(cast(Motion, _Still(positions)), time, time)
    except AttributeError:
        return positions
    return positions if measured is None else measured
