"""Gravity on a pendulum: what it has beside the linear spring that the plant contains.

A joint that is declared as an inertia with damping has no such spring: :mod:`camid.effects.arm_gravity`.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import atan, cos, inf, pi, sin, sqrt, tan
from typing import Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.force_over_position import plant_beside_wave
from camid.effects.parameter import Parameter
from camid.effects.plant_force import LEAST_FACTOR, static_stiffness
from camid.effects.recorded_force import waves_of_force
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Constants of a plant that a beginning says.
BIAS, OFFSET = "bias", "offset"
# Way in turns from which a pendulum has turned over, what a simulation without gravity leaves then, as a share of the
# motion, angles at half the way of one that has, and how many of them are kept.
LEAST_TURNED_OVER, FOLLOWED = 0.75, 0.1
TURNED_ANGLES, BEST = np.arange(2.5, 80.0, 0.5), 2
# Largest angle in rad at which a pendulum rests.
LARGEST_ANGLE = 1.5


class PendulumGravity(Effect):
    """Restoring force that follows the sine of the displacement, as gravity on a pendulum does."""

    identifier = "pendulum-gravity"
    place = "plant"
    title = "Gravity on a pendulum"
    equation = r"f = k\,(A\,\sin(y/A) - y),\quad k = 1/G(0)"
    reference = "Nelson & Olsson (1986), Am. J. Phys. 54, 112-121"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("amplitude", "y", "displacement A of one radian", 1e-300),)
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[1] * (values[0] * sin(position / values[0]) - position)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Amplitude and static stiffness."""
        return [self.values["amplitude"], static_stiffness(plant)]

    def scaled(self, factor: float) -> PendulumGravity:
        """Another amplitude: the force is proportional to the inverse of its square while the angle is small."""
        return self.with_vector(self.vector / sqrt(max(factor, LEAST_FACTOR)))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """From small angles to large ones; what pushes tells both apart. Without a spring it is an arm's.

        One that has turned over shows in the recorded motion: a simulation without gravity may be anywhere.
        """
        if static_stiffness(situation.plant) == 0.0:
            yield from PendulumGravity.with_keys(["torque"]).candidates(situation)
            return
        laws = (PendulumGravity, PendulumDrivenAcross) if np.any(situation.signal) else (PendulumGravity,)
        for law in laws:
            for angle in (0.15, 0.5, 1.2):
                yield law(amplitude=situation.largest("position") / angle)
        left = (situation.recorded - situation.position)[situation.used]
        # A simulation that has run away follows nothing, either.
        if len(left) and not np.std(left) <= FOLLOWED * np.std(situation.recorded[situation.used]):
            for period in _turns(situation):
                yield cls(amplitude=period / (2.0 * pi))

    @classmethod
    def with_plant(
        cls, situation: Situation, constants: Mapping[str, float]
    ) -> tuple[Effect, TransferFunction, dict[str, float]] | None:
        """Beside the plant that the recorded motion shows with it, where the pendulum has turned over.

        From coefficients that are a little off a simulation turns over at other times, and no fit finds the way.
        """
        numerator, denominator = situation.plant.numerator, situation.plant.denominator
        turns = _turns(situation) if static_stiffness(situation.plant) != 0.0 else []
        if not turns:
            return None
        # The spring is that of gravity for small angles.
        driven = replace(situation, plant=TransferFunction(numerator, (*denominator[:-1], 0.0)))
        found = plant_beside_wave(driven, turns[0], ())
        if found is None:
            return None
        ((torque, phase),) = found.waves
        amplitude = found.period / (2.0 * pi)
        gain = found.plant.numerator[0]
        stiffness = abs(gain) * torque / amplitude
        plant = TransferFunction((gain,), (*found.plant.denominator[:-1], stiffness))
        hangs = -amplitude * (phase if gain > 0.0 else phase - pi)
        zero = constants.get(OFFSET, 0.0) + hangs
        known = {BIAS: found.bias, OFFSET: (zero + 0.5 * found.period) % found.period - 0.5 * found.period}
        return cls(amplitude=amplitude), plant, {name: known[name] for name in constants.keys() & known.keys()}


def _turns(situation: Situation) -> list[float]:
    """Ways of a turn, in units of the output, that the recorded motion shows of a pendulum that has turned over."""
    recorded = situation.recorded[situation.used]
    if len(recorded) == 0 or not np.any(situation.signal):
        return []
    way = float(np.ptp(recorded))
    waves = waves_of_force(situation, pi * way / TURNED_ANGLES, BEST)
    return [wave["period"] for wave in waves if way > LEAST_TURNED_OVER * wave["period"]]


class PendulumDrivenAcross(PendulumGravity):
    """A pendulum that is pushed horizontally, as one is whose pivot is accelerated.

    Only the part of the input along the arc moves it then, and not all of it as with a motor at the pivot.
    """

    title = "Gravity on a pendulum that is driven horizontally"
    equation = r"f = k\,(A\,\sin(y/A) - y) + u\,(1 - \cos(y/A)),\quad k = 1/G(0)"
    reference = "Ogata (2010), Modern Control Engineering, 5th ed., section 3.3"
    parameters = (
        *PendulumGravity.parameters,
        Parameter("drive", "", "how the input pushes", choices=("horizontal",), default="horizontal"),
    )

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """The same amplitude; without an input nothing tells both laws apart."""
        if np.any(situation.signal):
            yield cls(**values)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        angle = position / values[0]
        return values[1] * (values[0] * sin(angle) - position) + signal * (1.0 - cos(angle))


class PendulumAtAnAngle(PendulumGravity):
    """A pendulum that does not hang straight down where it rests, as a constant torque or a spring holds it there.

    That is a pendulum and a constant of the input. Where the sensor's zero, or the input's bias, is estimated, that
    constant moves with it, and the pendulum alone stands at the wrong angle.
    """

    title = "Gravity on a pendulum that rests at an angle"
    equation = r"f = k\,(A\,\sin(y/A) - y - A\,(1 - \cos(y/A))\,\tan(y_0/A)),\quad k = 1/G(0)"
    reference = "Nelson & Olsson (1986), Am. J. Phys. 54, 112-121"
    parameters = (
        *PendulumGravity.parameters,
        Parameter("rest", "y", "displacement y_0 from where it hangs straight down to where it rests", default=0.0),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        angle = position / values[0]
        return values[1] * (values[0] * (sin(angle) - values[2] * (1.0 - cos(angle))) - position)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Amplitude, static stiffness and tangent of the angle at rest."""
        return [*super().force_values(plant), tan(self.values["rest"] / self.values["amplitude"])]

    def is_plausible(self, extent: Extent) -> bool:
        """Whether gravity holds it where it rests, which beyond a right angle it does not."""
        return super().is_plausible(extent) and abs(self.values["rest"]) < LARGEST_ANGLE * self.values["amplitude"]

    def simplified(self) -> PendulumGravity:
        """The same that hangs straight down."""
        return PendulumGravity(amplitude=self.values["amplitude"])


def pendulum_like(plant: TransferFunction, quadratic: float, cubic: float) -> tuple[Effect, ...]:
    """The pendulum whose force begins with a softening cube (u/y^3) and a square (u/y^2); none where it hardens."""
    stiffness = abs(static_stiffness(plant))
    ratio = -stiffness / (6.0 * cubic or inf)
    if not 0.0 < ratio < inf:
        return ()
    amplitude = sqrt(ratio)
    if quadratic == 0.0:
        return (PendulumGravity(amplitude=amplitude),)
    return (PendulumAtAnAngle(amplitude=amplitude, rest=-amplitude * atan(2.0 * amplitude * quadratic / stiffness)),)
