"""Gravity on a pendulum, and on an arm.

A pendulum's law is what gravity has beside the linear spring that the plant contains. A joint that is declared as an
inertia with damping has no such spring: what is left out then is the whole torque, and where the arm hangs is another
number.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product
from math import ceil, cos, pi, sin, sqrt
from typing import Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.actuator import InputBias
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.force_over_position import plant_beside_wave
from camid.effects.parameter import Parameter
from camid.effects.periodic_in_position import LARGEST_PERIOD
from camid.effects.plant_force import GUESS, LEAST_FACTOR, mobility, motion_sign, static_stiffness
from camid.effects.recorded_force import waves_of_force
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# First guesses: angles at the largest displacement, and angles from where the arm hangs at the sensor's zero.
ANGLES = (0.5, 1.2, 2.5)
QUADRANTS = (0, 1, 2, 3)
# Angle over the whole way from which an arm turns at all.
LEAST_ANGLE = 0.05
# Angles at the largest displacement of which the recorded motion is asked, and how many of them are kept.
SEEN_ANGLES, BEST = np.geomspace(0.3, 12.0, 60), 2
# Sine of the angle from where an arm hangs from which it is level.
LEVEL = 0.9
# Constants of a plant that a beginning says.
BIAS, OFFSET = "bias", "offset"
# Way in turns from which a pendulum has turned over, what a simulation without gravity leaves then, as a share of the
# motion, and angles at half the way of one that has.
LEAST_TURNED_OVER, FOLLOWED = 0.75, 0.1
TURNED_ANGLES = np.arange(2.5, 80.0, 0.5)


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
            yield from ArmGravity.candidates(situation)
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


class ArmGravity(PendulumGravity):
    """The torque of gravity on an arm, which pulls it to where it hangs."""

    title = "Gravity on an arm"
    equation = r"f = m\,\sin(y/A + \varphi)"
    reference = "Spong, Hutchinson & Vidyasagar (2006), Robot Modeling and Control, section 7.3"
    parameters = (
        *PendulumGravity.parameters,
        Parameter("torque", "u", "torque m of the arm held level", 0.0),
        Parameter("phase", "rad", "angle φ from where it hangs at y = 0", scale="one"),
    )
    strength = "torque"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[1] * sin(position / values[0] + values[2])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Amplitude, torque with the sign of the plant's gain, and phase."""
        amplitude, torque, phase = self.vector.tolist()
        return [amplitude, motion_sign(plant) * torque, phase]

    def frequency(self, plant: TransferFunction) -> float:
        """Of small oscillations where it hangs."""
        return sqrt(mobility(plant) * self.values["torque"] / self.values["amplitude"])

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the motion holds hardly more than a turn, and more than a small angle.

        What repeats along the way is cogging, and what hardly turns is a constant and a spring.
        """
        amplitude = self.values["amplitude"]
        return bool(LARGEST_PERIOD / (2.0 * pi) * extent.span <= amplitude <= extent.span / LEAST_ANGLE)

    @property
    def branch(self) -> tuple[Any, ...]:
        """An arm that stands is no start for one that hangs."""
        return (*super().branch, ceil(self.values["phase"] / (0.5 * pi) - 0.5) % len(QUADRANTS))

    def simplified(self) -> InputBias:
        """A constant, which it is where the arm hardly turns; a fit finds its sign, which is that of the plant, too."""
        return InputBias(bias=-self.values["torque"] * sin(self.values["phase"]))

    def scaled(self, factor: float) -> Effect:  # type: ignore[override] # in its torque, as most laws
        """Another torque; a negative one is that of an arm which stands where this one hangs."""
        return Effect.scaled(self if factor >= 0.0 else self.turned(), abs(factor))

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """About where the arm is level its torque is a constant and a square of the displacement."""
        from camid.effects.stiffness import QuadraticStiffness

        amplitude, torque, phase = self.vector.tolist()
        level = abs(sin(phase)) > LEVEL
        return (QuadraticStiffness(coefficient=-0.5 * torque * sin(phase) / amplitude**2),) if level else ()

    def turned(self) -> ArmGravity:
        """That of an arm which hangs where this one stands."""
        amplitude, torque, phase = self.vector.tolist()
        return type(self)(amplitude=amplitude, torque=torque, phase=phase - pi if phase > 0.0 else phase + pi)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """A plant with a spring of its own leaves nothing of this to be told from it."""
        return iter(())

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """As the recorded motion shows it; else from small angles to large ones, from each quarter of a turn."""
        periods = 2.0 * pi * situation.largest("recorded") / SEEN_ANGLES
        found = waves_of_force(situation, periods, BEST)
        # The torque counts with the sign of the plant's gain.
        turned = 0.0 if motion_sign(situation.plant) > 0.0 else pi
        for wave in found:
            yield cls(amplitude=wave["period"] / (2.0 * pi), torque=wave["amplitude"], phase=wave["phase"] + turned)
        if found:
            return
        torque, largest = GUESS * situation.largest("signal"), situation.largest("position")
        for angle, quadrant in product(ANGLES, QUADRANTS):
            yield cls(amplitude=largest / angle, torque=torque, phase=0.5 * pi * quadrant)
