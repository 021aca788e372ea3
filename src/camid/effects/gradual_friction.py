"""Friction that turns round over a range of speeds instead of at once, as that of a lubricated contact does."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp, tanh
from typing import Any, Self

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.friction import AsymmetricFriction, CoulombFriction, StribeckFriction
from camid.effects.gradual_saturation import SHARPEST, gradually_limited
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility, motion_sign
from camid.effects.situation import Situation

# Speeds of first guesses over which the friction turns round, as shares of the standard deviation of the speed, and of
# that at which it falls.
SHARES, SHARES_OF_FALL = (0.1, 0.4), (0.06, 0.3)
# Largest rate at which such a friction brings the body to rest, in rates of the plant: beyond it turns round at once.
FASTEST = 1e3
# First guesses of levels that fall with the speed, at the speed and at rest, in that of Coulomb friction; and of the
# speed, in standard deviations of the velocity.
LEVELS = (0.7, 1.3)
VELOCITIES = (1.0, 0.3)
# First guess of half the difference of the levels in both directions, in their mean.
UNEVEN = 0.1
# Friction in one direction, as a share of that in the other, that friction, or a damper with valves, has at least.
LEAST_IN_ONE_DIRECTION = 0.15
# Least speed over which it turns round, in that of the way that a recording spans over its duration: faster is at once.
LEAST_TRANSITION = 0.02
# Sharpness of a knee: the roundest, first guesses, and from where on it is a corner.
LEAST_SHARPNESS, FIRST_SHARPNESS, CORNER = 0.5, (1.2, 4.0), 5.0
TRANSITION = Parameter("transition", "y/s", "speed v_t over which the friction turns round", 1e-300)


class GradualCoulombFriction(CoulombFriction):
    """Coulomb friction that holds nothing at rest: it is viscous at speeds below that at which it turns round."""

    title = "Coulomb friction that turns round gradually"
    equation = r"f = f_c\,\tanh(\dot y/v_t)"
    reference = "Andersson, Soderberg & Bjorklund (2007), Tribology Int. 40, 580-587"
    parameters = (*CoulombFriction.parameters, TRANSITION)
    friction_level = None  # type: ignore[assignment] # nothing holds the body

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * tanh(velocity / values[1])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Level with the sign of the plant's gain, and speed."""
        return [motion_sign(plant) * self.values["force"], self.values["transition"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Rate at which it brings a slow body to rest."""
        return _rate_at_rest(plant, self.values["force"], self.values["transition"])

    def is_plausible(self, extent: Extent) -> bool:
        """Whether it turns round within the speeds recorded: else it is viscous."""
        return bool(self.values["transition"] <= extent.speed) and super().is_plausible(extent)

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the same level."""
        return CoulombFriction(force=self.values["force"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """A knee that is rounder or sharper, and levels that are larger in one direction, or fall with the speed."""
        level, spread = self.values["force"], float(np.std(situation.velocity)) or 1.0
        low, high = (share * level for share in LEVELS)
        transition = self.values["transition"]
        falling = (
            GradualStribeckFriction(coulomb=low, breakaway=high, velocity=share * spread, transition=transition)
            for share in VELOCITIES
        )
        more, less = ((1.0 + uneven) * level for uneven in (UNEVEN, -UNEVEN))
        knees = (CoulombFrictionOfAnyKnee(**self.values, sharpness=sharpness) for sharpness in FIRST_SHARPNESS)
        return (*knees, GradualAsymmetricFriction(forward=more, backward=less, transition=transition), *falling)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Of small and of middle speeds."""
        yield from (cls(**values, transition=speed) for speed in _first_transitions(situation))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a friction that was found."""
        yield from ()


class CoulombFrictionOfAnyKnee(GradualCoulombFriction):
    """Coulomb friction that turns round gradually, with the sharpness of its knee: it may have long tails, or none.

    A hyperbolic tangent is within 4 % of a sharpness of 2.4, the square-root law v / sqrt(v² + v_t²) has that of 2, and
    an inverse tangent is near one of 1.
    """

    title = "Coulomb friction that turns round gradually, with any knee"
    equation = r"f = f_c\,\dot y\,/\,(v_t^n + |\dot y|^n)^{1/n}"
    reference = GradualCoulombFriction.reference
    parameters = (
        *GradualCoulombFriction.parameters,
        Parameter("sharpness", "", "sharpness n of the knee", LEAST_SHARPNESS, SHARPEST, scale="one"),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * gradually_limited(velocity, values[1], values[2]) / values[1]

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Level with the sign of the plant's gain, speed and sharpness."""
        return [*super().force_values(plant), self.values["sharpness"]]

    def simplified(self) -> CoulombFriction:
        """A hyperbolic tangent of the same level and speed."""
        return GradualCoulombFriction(force=self.values["force"], transition=self.values["transition"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """Levels that are larger in one direction."""
        level, knee = self.values["force"], {name: self.values[name] for name in ("transition", "sharpness")}
        more, less = ((1.0 + uneven) * level for uneven in (UNEVEN, -UNEVEN))
        return (AsymmetricFrictionOfAnyKnee(forward=more, backward=less, **knee),)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Where it ends at a corner, drag with a peak, about which it is flat and beyond which it falls."""
        if self.values["sharpness"] < CORNER:
            return super().relatives(situation)
        laws = (law for law in StribeckFriction.finer_laws if "peak" in {p.name for p in law.parameters})
        # As steep at rest.
        peak = {"peak": self.values["force"], "velocity": 2.0 * self.values["transition"]}
        return (*super().relatives(situation), *(law(**peak) for law in laws))

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """It is started from friction that turns round gradually."""
        yield from ()


class GradualAsymmetricFriction(AsymmetricFriction):
    """Dry friction of another size in each direction that holds nothing at rest.

    Nothing of it acts on a body at rest, as a bias of the input does, so that the two are told apart.
    """

    title = "Asymmetric Coulomb friction that turns round gradually"
    equation = r"f = f_+\tanh(\dot y/v_t)\ \ (\dot y > 0),\quad f = f_-\tanh(\dot y/v_t)\ \ (\dot y < 0)"
    reference = GradualCoulombFriction.reference
    parameters = (*AsymmetricFriction.parameters, TRANSITION)
    sum_of = ()
    friction_level = None  # type: ignore[assignment] # nothing holds the body

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        share = tanh(velocity / values[2])
        return values[0] * share + values[1] * abs(share)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Mean of both levels and half of their difference, with the sign of the plant's gain, and speed."""
        sign, forward, backward = motion_sign(plant), self.values["forward"], self.values["backward"]
        return [0.5 * sign * (forward + backward), 0.5 * sign * (forward - backward), self.values["transition"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Rate at which it brings a slow body to rest."""
        return _rate_at_rest(plant, max(self.values["forward"], self.values["backward"]), self.values["transition"])

    def is_plausible(self, extent: Extent) -> bool:
        """Whether there is friction in both directions, and no body sticks: else it is two common effects together."""
        smaller, larger = sorted((self.values["forward"], self.values["backward"]))
        turns_round = self.values["transition"] * extent.duration >= LEAST_TRANSITION * extent.span
        turns_round = turns_round and self.values["transition"] <= extent.speed
        return bool(turns_round and smaller >= LEAST_IN_ONE_DIRECTION * larger) and super().is_plausible(extent)

    def simplified(self) -> CoulombFriction:
        """The same of the mean level in both directions."""
        level = 0.5 * (self.values["forward"] + self.values["backward"])
        return GradualCoulombFriction(force=level, transition=self.values["transition"])

    def scaled(self, factor: float) -> Self:
        """Both levels, scaled."""
        return self.with_vector(np.concatenate([max(factor, 0.0) * self.vector[:2], self.vector[2:]]))

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """A knee that is rounder or sharper."""
        return tuple(AsymmetricFrictionOfAnyKnee(**self.values, sharpness=sharpness) for sharpness in FIRST_SHARPNESS)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Of small and of middle speeds."""
        yield from (cls(**values, transition=speed) for speed in _first_transitions(situation))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a friction that was found."""
        yield from ()


class AsymmetricFrictionOfAnyKnee(GradualAsymmetricFriction):
    """Friction of another size in each direction that turns round gradually, with any knee.

    It is the force of a shock absorber, too, whose valves open at a speed and resist the rebound more.
    """

    title = "Asymmetric friction that turns round gradually, with any knee"
    equation = r"f = f_\pm\,\dot y\,/\,(v_t^n + |\dot y|^n)^{1/n},\quad f_+\ (\dot y > 0),\quad f_-\ (\dot y < 0)"
    reference = "Dixon (2007), The Shock Absorber Handbook, 2nd ed., chapter 6"
    parameters = (*GradualAsymmetricFriction.parameters, *CoulombFrictionOfAnyKnee.parameters[-1:])

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        share = gradually_limited(velocity, values[2], values[3]) / values[2]
        return values[0] * share + values[1] * abs(share)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Mean of both levels and half of their difference, with the sign of the plant's gain, speed and sharpness."""
        return [*super().force_values(plant), self.values["sharpness"]]

    def simplified(self) -> CoulombFriction:
        """The same of the mean level in both directions."""
        level = 0.5 * (self.values["forward"] + self.values["backward"])
        knee = {name: self.values[name] for name in ("transition", "sharpness")}
        return CoulombFrictionOfAnyKnee(force=level, **knee)

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """It is started from friction that turns round gradually."""
        yield from ()


class GradualStribeckFriction(StribeckFriction):
    """Stribeck friction that holds nothing at rest: it is viscous at speeds below that at which it turns round."""

    title = "Stribeck friction that turns round gradually"
    equation = r"f = \left(f_c + (f_s - f_c)\,e^{-(\dot y/v_s)^2}\right)\tanh(\dot y/v_t)"
    reference = GradualCoulombFriction.reference
    parameters = (*StribeckFriction.parameters, TRANSITION)
    friction_level = None  # type: ignore[assignment] # nothing holds the body

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        share = velocity / values[2]
        return (values[0] + (values[1] - values[0]) * exp(-share * share)) * tanh(velocity / values[3])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Levels with the sign of the plant's gain, and speeds."""
        sign = motion_sign(plant)
        levels = [sign * self.values["coulomb"], sign * self.values["breakaway"]]
        return [*levels, self.values["velocity"], self.values["transition"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Rate at which it brings a slow body to rest, and that of its fall with the speed."""
        at_rest = _rate_at_rest(plant, self.values["breakaway"], self.values["transition"])
        return max(at_rest, super().frequency(plant))

    def is_plausible(self, extent: Extent) -> bool:
        """Whether it turns round before it falls, and within the speeds recorded."""
        return bool(self.values["transition"] <= min(self.values["velocity"], extent.speed)) and super().is_plausible(
            extent
        )

    def simplified(self) -> StribeckFriction:  # type: ignore[override] # with less detail, and not another name
        """Stribeck friction that turns round at once."""
        return StribeckFriction(**{name: self.values[name] for name in ("coulomb", "breakaway", "velocity")})

    def scaled(self, factor: float) -> GradualStribeckFriction:
        """Both levels, scaled."""
        return self.with_vector(self.vector * np.array([max(factor, 0.0), max(factor, 0.0), 1.0, 1.0]))

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """What falls to nothing may be no friction."""
        laws = (law for law in StribeckFriction.finer_laws if "peak" in {p.name for p in law.parameters})
        return tuple(start for law in laws for start in law.starts(situation, **self.values))

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Of speeds far and not so far below that of the fall."""
        yield from (cls(**values, transition=share * values["velocity"]) for share in SHARES_OF_FALL)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a friction that was found."""
        yield from ()


def _first_transitions(situation: Situation) -> list[float]:
    """First guesses of the speed over which a friction turns round."""
    spread = float(np.std(situation.velocity)) or 1.0
    return [share * spread for share in SHARES]


def _rate_at_rest(plant: TransferFunction, level: float, transition: float) -> float:
    """Rate at which a friction brings a slow body to rest."""
    rate = mobility(plant) * level / transition
    return min(rate, FASTEST * max(plant.fastest_pole, 1.0))
