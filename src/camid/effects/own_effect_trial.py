"""Try an effect that a user wrote on a recording, before a search that drops guesses which fail relies on it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import Any

import numpy as np

from camid.chain.acquisition import Acquisition
from camid.chain.motion import Motion
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.own_effect_form import COMPILED, line_of
from camid.effects.situation import Situation
from camid.errors import InputError

# First guesses, each of which costs a simulation, and rows of the recording at which they are tried.
MOST_GUESSES = 500
ROWS = 200
EVERYWHERE = "it has to be a finite number everywhere"


class _BeyondValues(Exception):  # noqa: N818 - no error of its own
    """A part reads a value that the effect does not give it."""


class _Values:
    """Values that notice when others are asked for; no list, which functions with @njit would be compiled for."""

    def __init__(self, values: Sequence[float]) -> None:
        self._values = values

    def __getitem__(self, index: Any) -> float:
        if not 0 <= int(index) < len(self._values):
            raise _BeyondValues(int(index))
        return self._values[int(index)]


def tried_guesses(kind: type[Effect], situation: Situation) -> list[Effect]:
    """First guesses of an effect, after what they do was tried on a recording.

    Raises
    ------
    InputError
        If guessing fails, or a guess returns something that is no finite number, or of another shape than it got.
    """
    reason = kind.invisible(situation)
    if not isinstance(reason, str | None):
        raise _wrong(kind, "invisible", f"returns {_named(reason)}", "return why it cannot be seen, or None")
    if kind.noise_like or reason is not None:
        return []
    guesses = _guesses(kind, situation)
    for guess in guesses:
        values = _values(guess, situation.plant)
        for name in COMPILED:
            _try_compiled(guess, name, values, situation)
        _try_signals(guess, situation)
        _try_motion(guess, situation)
        _try_declarations(guess, situation)
    return guesses


def _wrong(kind: type[Effect], name: str, problem: str, hint: str) -> InputError:
    return InputError(f"{kind.identifier}: '{name}' {problem}", where=line_of(kind, name), hint=hint)


def _named(value: Any) -> str:
    return "nothing" if value is None else f"a {type(value).__name__}"


def _guesses(kind: type[Effect], situation: Situation) -> list[Effect]:
    found: list[Effect] = []
    try:
        for guess in islice(kind.candidates(situation), MOST_GUESSES + 1):
            if not isinstance(guess, kind):
                raise _wrong(kind, "candidates", f"yields {_named(guess)}", f"yield {kind.__name__}(…)")
            found.append(guess)
    except InputError:
        raise
    except ValueError:  # bounds may forbid a guess in this situation, but hardly the first
        if not found:
            raise
    except TypeError as error:
        if not found and "iterable" in str(error):
            raise _wrong(kind, "candidates", "gives no guesses", f"yield {kind.__name__}(…)") from error
        raise
    if len(found) > MOST_GUESSES:
        raise _wrong(kind, "candidates", f"yields more than {MOST_GUESSES} guesses", "yield one for each shape")
    if not found:
        hint = "without one it is not looked for: yield one at least, or let 'invisible' say why it cannot be seen"
        raise _wrong(kind, "candidates", "yields no guess for this recording", hint)
    return found


def _values(guess: Effect, plant: TransferFunction) -> list[float]:
    """What the compiled parts get, checked."""
    found = guess.force_values(plant)
    try:
        numbers = [float(value) for value in found]
    except (TypeError, ValueError) as error:
        raise _wrong(type(guess), "force_values", f"returns {_named(found)}", "return a list of numbers") from error
    if not np.all(np.isfinite(numbers)):
        raise _wrong(type(guess), "force_values", f"returns {numbers}", EVERYWHERE)
    return numbers


def _rows(situation: Situation) -> list[int]:
    """Rows that are tried: some all over the recording, and those where a signal is at its ends."""
    count = len(situation.time)
    rows = set(np.linspace(0, count - 1, min(ROWS, count)).astype(int).tolist())
    for signal in (situation.position, situation.velocity, situation.signal):
        rows |= {int(np.argmin(signal)), int(np.argmax(signal)), int(np.argmin(np.abs(signal)))}
    return sorted(rows)


def _try_compiled(guess: Effect, name: str, values: Sequence[float], situation: Situation) -> None:
    part = getattr(guess, name)
    if part is None:
        return
    kind, s = type(guess), situation
    for row in _rows(s):
        position, velocity = float(s.position[row]), float(s.velocity[row])
        if name == "friction_level":
            velocity = abs(velocity)
        arguments = (float(s.time[row]), position, velocity, float(s.signal[row]), 0.0)
        _refuse_reading_beyond(guess, name, arguments, values)
        found = part.at(*arguments, values=values)
        if not np.isfinite(found):
            stated = ", ".join(f"{n} = {v:.3g}" for n, v in guess.values.items() if isinstance(v, float))
            at = f"position {position:.3g}, velocity {velocity:.3g}, input {arguments[3]:.3g}"
            raise _wrong(kind, name, f"returns {found:g} at {at}{f', {stated}' if stated else ''}", EVERYWHERE)


def _refuse_reading_beyond(guess: Effect, name: str, arguments: tuple[float, ...], values: Sequence[float]) -> None:
    """Refuse a part that reads values which are not there: compiled, it would read zeros."""
    try:
        getattr(guess, name).function(*arguments, _Values(values))
    except _BeyondValues as error:
        there = "there is 1" if len(values) == 1 else f"there are {len(values)}"
        hint = "they are the parameters in order, or what force_values returns"
        raise _wrong(type(guess), name, f"reads values[{error}], and {there}", hint) from None
    except Exception:  # only the compiled result counts: a division by zero, for instance, is infinite
        return


def _try_signals(guess: Effect, situation: Situation) -> None:
    """Try what a guess does to the input and to the samples."""
    kind, count = type(guess), len(situation.signal)
    both = guess.transform(situation.signal.copy(), situation.signal.copy(), situation.acquisition.period)
    if not isinstance(both, tuple) or len(both) != 2:
        raise _wrong(kind, "transform", f"returns {_named(both)}", "return the input at start and end of each step")
    read = guess.observe(situation.position.copy(), situation.time.copy())
    for name, signal in (("transform", both[0]), ("transform", both[1]), ("observe", read)):
        shape = np.shape(signal)
        if shape != (count,):
            raise _wrong(kind, name, f"returns the shape {shape} for {count} rows", f"return the shape ({count},)")
        if not np.all(np.isfinite(np.asarray(signal, dtype=float))):
            raise _wrong(kind, name, "returns what is no finite number", EVERYWHERE)


def _try_motion(guess: Effect, situation: Situation) -> None:
    """Try what a guess makes of a motion before the camera, and of its exposures."""
    kind, count, step = type(guess), len(situation.time), situation.acquisition.period
    position, velocity = situation.position.copy(), situation.velocity.copy()
    integral = step * np.concatenate([[0.0], np.cumsum(0.5 * (position[1:] + position[:-1]))])
    start = float(situation.time[0])
    motion = Motion(start, step, position, velocity, integral, velocity[1:], np.zeros(0), np.zeros((0, 3)))
    carried = guess.carry(motion)
    if not isinstance(carried, Motion):
        raise _wrong(kind, "carry", f"returns {_named(carried)}", "return a Motion")
    opened = np.asarray(start + step * np.arange(count), dtype=np.float64)
    windows = guess.windows(carried, opened, opened + step)
    if not isinstance(windows, tuple) or len(windows) != 2 or any(np.shape(each) != (count,) for each in windows):
        raise _wrong(
            kind, "windows", f"returns {_named(windows)}", f"return start and end, each of the shape ({count},)"
        )
    measured = guess.measure(carried, *windows)
    if measured is not None and (np.shape(measured) != (count,) or np.asarray(measured).dtype.kind not in "fiu"):
        raise _wrong(kind, "measure", f"returns {_named(measured)}", f"return numbers of the shape ({count},), or None")


def _try_declarations(guess: Effect, situation: Situation) -> None:
    """Try what a guess says of the chain in other words."""
    kind = type(guess)
    declared = guess.declare(situation.acquisition)
    if not isinstance(declared, Acquisition):
        raise _wrong(kind, "declare", f"returns {_named(declared)}", "return an Acquisition")
    for name in ("before_plant", "beside_plant", "after_plant"):
        dynamics = getattr(guess, name)()
        if not isinstance(dynamics, TransferFunction | None):
            raise _wrong(kind, name, f"returns {_named(dynamics)}", "return a TransferFunction or None")
    rate = guess.frequency(situation.plant)
    if not isinstance(rate, float | int) or not np.isfinite(rate) or rate < 0.0:
        raise _wrong(kind, "frequency", f"returns {rate!r}", "return rad/s, zero or more")
