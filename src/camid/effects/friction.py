"""Dry friction: of one level, or of a level that depends on the speed, the direction, the position or the load."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp
from typing import Any, ClassVar, Self

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.actuator import Backlash
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.dead_zone import DeadZone
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, mobility, motion_sign
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Share of the level that the first guesses add at the edge of the motion, or to one direction and take from the other.
UNEVEN = 0.6
# Share of the level at the median load that is first guessed to grow with the load.
LOADED = 0.1
# Largest load over the least one up to which all are one.
ONE_LOAD = 1.001
# Share of the break-away level that friction keeps at the speeds recorded: what falls to almost nothing is none.
LEAST_KEPT = 0.1
# First guess of the break-away level in the level at high speeds. Speed at which friction falls, in standard deviations
# of the velocity, from which on it falls over usual speeds, and what is a low one beside it.
FALL, USUAL_SPEED, LOW_SPEED = 1.6, 0.3, 0.2


class CoulombFriction(Effect):
    """Dry friction of constant size, which also holds the body at rest."""

    identifier = "coulomb-friction"
    place = "plant"
    title = "Coulomb friction"
    equation = r"f = f_c\,\mathrm{sgn}(\dot y),\quad |f| \leq f_c\ \mathrm{at\ rest}"
    reference = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30, 1083-1138"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("force", "u", "friction f_c", 0.0),)
    separated_by = (SeparatingExperiment.FREE_DECAY,)
    strength = "force"
    uses_velocity = True

    @compiled
    def friction_level(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0]

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small, and large enough that the body sticks at times."""
        for share in (GUESS, 0.1, 0.3):
            yield cls(force=share * situation.largest("signal"))
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """What bends the input nearly as it bends the motion, in some plants.

        Where the plant integrates, friction that grows with the load, too: a simulation without any friction has run
        away, and what is screened beside it says little of so small a part.
        """
        level = self.values["force"]
        found = bent_input(situation, level)
        if self.friction_level is None or situation.plant.denominator[-1] != 0.0:
            return found
        load = float(np.median(np.abs(situation.signal)))
        if LOADED * level >= load:  # no friction grows faster than the load
            return found
        return (*found, LoadDependentFriction(force=(1.0 - LOADED) * level, coefficient=LOADED * level / load))


class StribeckFriction(Effect):
    """Dry friction that falls from a break-away level as the speed grows."""

    identifier = "stribeck-friction"
    place = "plant"
    title = "Stribeck friction"
    equation = r"f = \left(f_c + (f_s - f_c)\,e^{-(\dot y/v_s)^2}\right)\mathrm{sgn}(\dot y)"
    reference = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30, 1083-1138"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("coulomb", "u", "friction f_c at high speed", 0.0),
        Parameter("breakaway", "u", "friction f_s at rest", 0.0),
        Parameter("velocity", "y/s", "Stribeck velocity v_s", 1e-300),
    )
    separated_by = (SeparatingExperiment.FREE_DECAY,)
    uses_velocity = True

    @compiled
    def friction_level(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        share = velocity / values[2]
        return values[0] + (values[1] - values[0]) * exp(-share * share)

    def is_plausible(self, extent: Extent) -> bool:
        """Whether it falls as the speed grows, and not to nothing at the speeds recorded.

        One that rises, or vanishes, has another cause.
        """
        coulomb, breakaway, velocity = (self.values[name] for name in ("coulomb", "breakaway", "velocity"))
        kept = coulomb + (breakaway - coulomb) * exp(-((extent.speed / velocity) ** 2))
        return bool(coulomb <= breakaway and kept >= LEAST_KEPT * breakaway)

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the larger of both levels."""
        return CoulombFriction(force=max(self.values["coulomb"], self.values["breakaway"]))

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Coulomb friction of the level at usual speeds, where nothing moves slowly enough to show the other.

        In some plants, what bends the input nearly as it bends the motion, too. Friction that falls over all speeds may
        have taken the place of what was missing then: it is begun again as one that falls at low ones.
        """
        speed = float(np.median(np.abs(situation.velocity)))
        coulomb, breakaway, velocity = (self.values[name] for name in ("coulomb", "breakaway", "velocity"))
        level = coulomb + (breakaway - coulomb) * exp(-((speed / velocity) ** 2))
        found = (CoulombFriction(force=level), *bent_input(situation, level))
        spread = float(np.std(situation.velocity))
        if velocity < USUAL_SPEED * spread:
            return found
        low = StribeckFriction(coulomb=level, breakaway=FALL * level, velocity=LOW_SPEED * min(velocity, spread))
        return (*found, low)

    def scaled(self, factor: float) -> StribeckFriction:
        """Both levels, scaled."""
        return self.with_vector(self.vector * np.array([max(factor, 0.0), max(factor, 0.0), 1.0]))

    def frequency(self, plant: TransferFunction) -> float:
        """Of the fall of friction with speed, which pushes the body."""
        slope = abs(self.values["breakaway"] - self.values["coulomb"]) / self.values["velocity"]
        return min(3.0 * mobility(plant) * slope, 1e3 * max(plant.fastest_pole, 1.0))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Break-away at one and a half times and at four times the level, at small and middle speeds."""
        force = GUESS * situation.largest("signal")
        for speed in (0.1, 0.3, 0.8):
            velocity = speed * float(np.std(situation.velocity)) or 1.0
            for level in (1.0, 5.0):
                yield cls(coulomb=level * force, breakaway=level * FALL * force, velocity=velocity)
        for law in cls.finer_laws:
            yield from law.candidates(situation)


def bent_input(situation: Situation, level: float) -> tuple[Effect, ...]:
    """What bends the input nearly as a friction bends the motion, as wide as the friction is strong.

    A plant that integrates answers a command with a speed, so that one below the friction does nothing: a dead zone. A
    plant of first order has no mass, and its input has to turn round by twice the friction before it does: a play.
    """
    if situation.plant.denominator[-1] == 0.0:
        return (DeadZone(half_width=level),)
    return (Backlash(half_width=level),) if situation.plant.order == 1 else ()


class _UnevenFriction(Effect):
    """Dry friction of two parameters, both forces or proportional to forces."""

    uses_velocity = True

    def scaled(self, factor: float) -> Self:
        """Both parameters, scaled."""
        return self.with_vector(self.vector * max(factor, 0.0))


class AsymmetricFriction(_UnevenFriction):
    """Dry friction of another size in each direction.

    It is Coulomb friction of the mean of both levels and a constant force of half their difference, at rest too, so
    that input and output cannot tell it from Coulomb friction beside a bias of the input. A diagnosis fits those two,
    of which each is common, and says that they may be this one; a simulation may declare it.
    """

    identifier = "asymmetric-friction"
    place = "plant"
    title = "Asymmetric Coulomb friction"
    equation = r"f = f_+\ \ (\dot y > 0),\quad f = -f_-\ \ (\dot y < 0),\quad -f_- \leq f \leq f_+\ \mathrm{at\ rest}"
    reference = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30, 1083-1138"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("forward", "u", "friction f₊ in the motion to larger y", 0.0),
        Parameter("backward", "u", "friction f₋ in the motion to smaller y", 0.0),
    )
    sum_of: ClassVar[tuple[str, ...]] = ("coulomb-friction", "input-bias")
    separated_by = (SeparatingExperiment.REVERSED_INPUT, SeparatingExperiment.FREE_DECAY)

    @compiled
    def friction_level(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0]

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[1]

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Mean of both levels, and half of their difference with the sign of the plant's gain."""
        forward, backward = self.values["forward"], self.values["backward"]
        return [0.5 * (forward + backward), 0.5 * motion_sign(plant) * (forward - backward)]

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the mean level."""
        return CoulombFriction(force=0.5 * (self.values["forward"] + self.values["backward"]))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Larger in either direction, small, and large enough that the body sticks at times."""
        for share in (GUESS, 0.2):
            level = share * situation.largest("signal")
            for uneven in (UNEVEN, -UNEVEN):
                yield cls(forward=(1.0 + uneven) * level, backward=(1.0 - uneven) * level)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """It has another name."""
        return "it is Coulomb friction beside a bias of the input, and these two are fitted in its place"


class PositionDependentFriction(_UnevenFriction):
    """Dry friction that grows along the way: a guide that is worn, bent or dry at one end."""

    identifier = "position-dependent-friction"
    place = "plant"
    title = "Friction that depends on the position"
    equation = r"|f| = \max(f_c + g\,y,\ 0)"
    reference = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30, 1083-1138, section 2.1"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("force", "u", "friction f_c at y = 0", 0.0),
        Parameter("gradient", "u/y", "change g of the friction with the position"),
    )
    separated_by = (SeparatingExperiment.FREE_DECAY, SeparatingExperiment.HELD_POSITIONS)

    @compiled
    def friction_level(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        # Beside other friction it may take away from it; all together are never negative.
        return values[0] + values[1] * position

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the level at y = 0."""
        return CoulombFriction(force=self.values["force"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Growing to either side, small, and large enough that the body sticks at times."""
        for share in (GUESS, 0.2):
            level = share * situation.largest("signal")
            for uneven in (UNEVEN, -UNEVEN):
                yield cls(force=level, gradient=uneven * level / situation.largest("position"))
            yield from CurvedPositionDependentFriction.starts(situation, force=level, gradient=0.0)


class CurvedPositionDependentFriction(PositionDependentFriction):
    """Dry friction that is largest, or least, somewhere along the way: a guide that is worn where it is used most."""

    title = "Friction that depends on the position, with a curvature"
    equation = r"|f| = \max(f_c + g\,y + h\,y^2,\ 0)"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        *PositionDependentFriction.parameters,
        Parameter("curvature", "u/y^2", "share h of the friction that grows with the square of the position"),
    )

    @compiled
    def friction_level(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] + (values[1] + values[2] * position) * position

    def simplified(self) -> PositionDependentFriction:  # type: ignore[override] # with less detail, no other name
        """The same that grows evenly."""
        return PositionDependentFriction(force=self.values["force"], gradient=self.values["gradient"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Larger at both ends of the way, and less."""
        for uneven in (UNEVEN, -UNEVEN):
            yield cls(**({"curvature": uneven * values["force"] / situation.largest("position") ** 2} | values))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is guessed with the friction that grows evenly."""
        yield from ()


class LoadDependentFriction(_UnevenFriction):
    """Dry friction that grows with the force that is transmitted, as in gears, screws and belts."""

    identifier = "load-dependent-friction"
    place = "plant"
    title = "Friction that depends on the load"
    equation = r"|f| = f_c + \mu\,|u'|"
    reference = "Hamon, Gautier & Garrec (2010), Proc. IEEE/RSJ IROS, 187-193"
    parameters = (
        Parameter("force", "u", "friction f_c without load", 0.0),
        Parameter("coefficient", "", "friction μ for a unit of the transmitted force", 0.0, 1.0),
    )
    separated_by = (SeparatingExperiment.MANY_LEVELS, SeparatingExperiment.FREE_DECAY)

    @compiled
    def friction_level(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] + values[1] * abs(signal)

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the level without load."""
        return CoulombFriction(force=self.values["force"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small, and large enough that the body sticks at times."""
        for share in (GUESS, 0.2):
            yield cls(force=0.3 * share * situation.largest("signal"), coefficient=share)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Without several loads it is Coulomb friction."""
        if _one_load(situation) is None:
            return None
        return "the input has one absolute value only, for which the friction is one constant"

    @classmethod
    def same_as(cls, effect: Effect, situation: Situation) -> Effect | None:
        """Coulomb friction without several loads, half of which may be that of the load."""
        load = _one_load(situation)
        if not load or type(effect) is not CoulombFriction:
            return None
        half = 0.5 * effect.values["force"]
        return cls(force=half, coefficient=half / load)


def _one_load(situation: Situation) -> float | None:
    """The only absolute value of the input; None where there are several."""
    sizes = abs(situation.all_signals)
    largest = float(sizes.max(initial=0.0))
    return None if largest > ONE_LOAD * sizes.min(initial=float("inf")) else largest
