"""Effects between the commanded input and the force that reaches the plant."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

import numpy as np

from camid.chain.acquisition import HOLDS, Acquisition
from camid.chain.plant import TransferFunction
from camid.compiled import njit
from camid.effects.base import Array, Effect
from camid.effects.command import SMALL_SHARES, at_both_ends, one_level
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import LEAST_FACTOR
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Shares of the largest input, or of its changes, at which limits are looked for.
LARGE_SHARES = (0.97, 0.9, 0.75, 0.55, 0.3)
DELAYS = (0.05, 0.3, 1.0, 3.0)
# Lag, as a share of the period, below which it is nothing but a delay: a faster pole costs the integrator only steps.
LEAST_LAG = 5e-3


class Saturation(Effect):
    """No force beyond a limit."""

    identifier = "saturation"
    place = "actuator"
    title = "Saturation of the actuator"
    equation = r"u' = \max(-s,\ \min(u,\ s))"
    reference = "Khalil (2002), Nonlinear Systems, 3rd ed., section 1.2"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("limit", "u", "largest force s in units of the command", 0.0),
    )
    separated_by = (SeparatingExperiment.MANY_LEVELS, SeparatingExperiment.SCALE_IN_THE_IMAGE)
    keeps_hold = True

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return min(max(signal, -values[0]), values[0])

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Clip at the limit."""
        limit = self.values["limit"]
        return at_both_ends(lambda u: np.clip(u, -limit, limit), start, end)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several shares of the largest input."""
        for share in LARGE_SHARES:
            yield cls(limit=share * situation.largest("signal")).measured_from(situation.largest("signal"))
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """A two-level input shows nothing of it."""
        return one_level(situation, "saturation")


@njit
def _play(start: Array, end: Array, half_width: float) -> tuple[Array, Array]:
    after, after_end = np.empty_like(start), np.empty_like(end)
    value = 0.0
    for k in range(len(start)):
        value = min(max(value, start[k] - half_width), start[k] + half_width)
        after[k] = value
        value = min(max(value, end[k] - half_width), end[k] + half_width)
        after_end[k] = value
    return after, after_end


class Backlash(Effect):
    """Play between command and force: a reversal has to cross the gap first."""

    identifier = "backlash"
    place = "actuator"
    title = "Backlash (play) of the actuator"
    equation = r"u'_k = \min(\max(u'_{k-1},\ u_k - b),\ u_k + b)"
    reference = "Nordin & Gutman (2002), Automatica 38, 1633-1649"
    parameters = (Parameter("half_width", "u", "half b of the gap", 0.0),)
    transforms_by_compiled_code = True
    separated_by = (SeparatingExperiment.MANY_LEVELS, SeparatingExperiment.FREE_DECAY)
    strength = "half_width"
    keeps_hold = True

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return min(max(memory, signal - values[0]), signal + values[0])

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Play operator, from the middle of the gap."""
        return _play(np.ascontiguousarray(start), np.ascontiguousarray(end), self.values["half_width"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several shares of the largest input."""
        for share in SMALL_SHARES:
            yield cls(half_width=share * situation.largest("signal"))

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """A two-level input shows nothing of it."""
        return one_level(situation, "backlash")


@njit
def _follow(start: Array, end: Array, step: float, rate: float) -> tuple[Array, Array]:
    """The command followed at a limited rate; each piece has the right mean, though a corner lies within it."""
    after, after_end = np.empty_like(start), np.empty_like(end)
    value = 0.0
    longest = rate * step
    for k in range(len(start)):
        slope = end[k] - start[k]
        distance = start[k] - value
        following = value
        mean = 0.0
        closing = longest - slope if distance > 0.0 else longest + slope
        if abs(distance) <= closing * 1e-12 or (closing > 0.0 and abs(distance) < closing):
            # The command is reached within the step, at this share of it; after that it is followed if it is slow.
            share = abs(distance) / closing
            sign = 1.0 if distance > 0.0 else -1.0
            reached = value + sign * longest * share
            if abs(slope) <= longest:
                following = end[k]
            else:
                following = reached + (1.0 if slope > 0.0 else -1.0) * longest * (1.0 - share)
            mean = 0.5 * (value + reached) * share + 0.5 * (reached + following) * (1.0 - share)
        else:
            following = value + (longest if distance > 0.0 else -longest)
            mean = 0.5 * (value + following)
        # A straight piece of the same mean and the same slope on average.
        middle = 0.5 * (following - value)
        after[k], after_end[k] = mean - middle, mean + middle
        value = following
    return after, after_end


class RateLimit(Effect):
    """The actuator follows its command no faster than a rate."""

    identifier = "rate-limit"
    place = "actuator"
    title = "Rate limit of the actuator"
    drawn_against = "change of the input"
    equation = r"|\dot u'| \leq r"
    reference = "Khalil (2002), Nonlinear Systems, 3rd ed.; Franklin, Powell & Emami-Naeini, Feedback Control"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("rate", "u/s", "largest rate r", 0.0),)
    transforms_by_compiled_code = True
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return memory + min(max(signal - memory, -values[0] * time), values[0] * time)

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Follow at a limited rate, from zero."""
        return _follow(np.ascontiguousarray(start), np.ascontiguousarray(end), step, self.values["rate"])

    def scaled(self, factor: float) -> RateLimit:
        """Another time for the same change: the effect is proportional to the inverse of the rate."""
        return self.with_vector(self.vector / max(factor, LEAST_FACTOR))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Rates at which the largest change takes from a tenth of a period to many periods."""
        change = float(np.max(np.abs(np.diff(situation.signal)), initial=0.0)) or 1.0
        for periods in (0.15, 0.4, 1.0, 2.5, 6.0):
            guess = RateLimit(rate=change / (periods * situation.acquisition.period))
            yield guess
            yield from guess.finer(situation)[-1:]


class ActuatorLag(Effect):
    """First-order lag between command and force."""

    identifier = "actuator-lag"
    place = "actuator"
    title = "First-order lag of the actuator"
    drawn_against = "change of the input"
    equation = r"\tau\,\dot u' + u' = u"
    reference = "Ljung (1999), System Identification, 2nd ed., section 4.3"
    parameters = (Parameter("time_constant", "s", "time constant τ", 0.0),)
    linear_dynamics = True
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)
    strength = "time_constant"

    def before_plant(self) -> TransferFunction | None:
        """1 / (τ s + 1)."""
        constant = self.values["time_constant"]
        return TransferFunction((1.0,), (constant, 1.0)) if constant > 1e-7 else None

    def bounds(self, acquisition: Acquisition) -> list[tuple[float, float]]:
        """No shorter than what differs from a delay."""
        return [(LEAST_LAG * acquisition.period, np.inf)]

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several shares of the period."""
        for periods in DELAYS:
            yield cls(time_constant=periods * situation.acquisition.period)


class GainAsymmetry(Effect):
    """Another gain for negative commands than for positive ones."""

    identifier = "gain-asymmetry"
    place = "actuator"
    title = "Asymmetric gain of the actuator"
    equation = r"u' = u\ \ (u \geq 0),\quad u' = \rho\,u\ \ (u < 0)"
    reference = "Jelali & Kroll (2003), Hydraulic Servo-systems, chapter 2 (asymmetric actuators)"
    parameters = (Parameter("ratio", "", "negative over positive gain ρ", 0.0),)
    separated_by = (SeparatingExperiment.REVERSED_INPUT,)
    keeps_hold = True

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return signal if signal >= 0.0 else values[0] * signal

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Scale negative commands."""
        ratio = self.values["ratio"]
        return at_both_ends(lambda u: np.where(u < 0.0, ratio * u, u), start, end)

    @property
    def one_sided(self) -> bool:
        """The negative gain may be smaller or larger."""
        return False

    def scaled(self, factor: float) -> GainAsymmetry:
        """The distance of the ratio from one, scaled."""
        return self.with_vector(np.array([1.0 + factor * (self.values["ratio"] - 1.0)]))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """A small asymmetry: the effect is proportional to it."""
        yield cls(ratio=0.95)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """An input of one sign shows nothing of it, and none at all even less."""
        signals = situation.all_signals
        if not np.any(signals):
            return "there is no input, of which it is a gain"
        if np.min(signals) >= 0.0 or np.max(signals) <= 0.0:
            return "the input has one sign only, for which an asymmetric gain is a change of the gain"
        return None


class InputHold(Effect):
    """The input is held differently from the declaration."""

    identifier = "input-hold"
    place = "actuator"
    title = "Hold of the input"
    drawn_against = "change of the input"
    equation = (
        r"u(t) = u_k\ \mathrm{(zoh)},\ \ u_k + (u_{k+1}-u_k)\,\tau/T\ \mathrm{(foh)},\ \ "
        r"\sum_j u_j\,\mathrm{sinc}(t/T-j)\ \mathrm{(band-limited)}"
    )
    reference = "Laroche & Delavigne, section 3.2; Pintelon & Schoukens (2012), System Identification, section 13.2"
    parameters = (Parameter("hold", "", "intersample behaviour of the input", choices=HOLDS),)
    linear_dynamics = True
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)
    corrects_declaration = True
    box = "hold"

    def declare(self, acquisition: Acquisition) -> Acquisition:
        """Another hold."""
        return replace(acquisition, hold=self.values["hold"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """The holds that were not declared."""
        for hold in HOLDS:
            if hold != situation.acquisition.hold:
                yield cls(hold=hold)


class InputBias(Effect):
    """A constant that is added to the command."""

    identifier = "input-bias"
    place = "actuator"
    title = "Bias of the input"
    equation = r"u' = u + b"
    reference = "Ljung (1999), System Identification, 2nd ed., section 14.1"
    parameters = (Parameter("bias", "u", "constant b"),)
    separated_by = (SeparatingExperiment.REVERSED_INPUT,)
    strength = "bias"
    keeps_hold = True
    is_constant = True

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return signal + values[0]

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Add the bias."""
        return at_both_ends(lambda u: u + self.values["bias"], start, end)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """A small bias: the effect is proportional to it."""
        yield cls(bias=0.02 * situation.largest("signal"))
