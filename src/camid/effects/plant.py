"""Effects of the plant: forces at its input, in units of u, that depend on its motion, and dynamics that it lacks."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp, sin, sqrt
from typing import Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction, second_order
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Force of a first guess as a share of the largest input: small, but above the rounding of the integrator.
GUESS = 0.02
# Smallest factor of a change of size; the effect is then below any noise.
LEAST_FACTOR = 1e-9


def static_stiffness(plant: TransferFunction) -> float:
    """Force in units of u that holds a unit of y at rest, A(0)/B(0); 0 for an integrating plant."""
    return plant.denominator[-1] / plant.numerator[-1] if plant.numerator[-1] != 0.0 else 0.0


def static_damping(plant: TransferFunction) -> float:
    """Force in units of u for a unit of y per second: the second coefficient of A/B about s = 0."""
    numerator, denominator = plant.numerator, plant.denominator
    if numerator[-1] == 0.0 or len(denominator) < 2:
        return 0.0
    slope = numerator[-2] / numerator[-1] if len(numerator) > 1 else 0.0
    return (denominator[-2] - denominator[-1] * slope) / numerator[-1]


def mobility(plant: TransferFunction) -> float:
    """Acceleration in units of y/s² for a unit of force, for a plant with two poles more than zeros; else 0."""
    monic = plant.monic
    return abs(monic.numerator[0]) if len(monic.denominator) - len(monic.numerator) == 2 else 0.0


def motion_sign(plant: TransferFunction) -> float:
    """1 where a positive force moves the plant to positive y at first, -1 where the sign of y or u is the other way."""
    return 1.0 if plant.monic.numerator[0] > 0.0 else -1.0


class AgainstMotion(Effect):
    """A force that acts against the motion whatever the signs of input and output: its first value is signed."""

    def force_values(self, plant: TransferFunction) -> list[float]:
        """The parameters, the size of the force with the sign of the plant's gain."""
        return [motion_sign(plant) * p if i == self.signed else p for i, p in enumerate(self.vector)]

    signed: ClassVar[int] = 0


class CoulombFriction(Effect):
    """Dry friction of constant size, which also holds the body at rest."""

    identifier = "coulomb-friction"
    place = "plant"
    title = "Coulomb friction"
    equation = r"f = f_c\,\mathrm{sgn}(\dot y),\quad |f| \leq f_c\ \mathrm{at\ rest}"
    reference = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30, 1083-1138"
    parameters = (Parameter("force", "u", "friction f_c", 0.0),)
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


class StribeckFriction(Effect):
    """Dry friction that falls from a break-away level as the speed grows."""

    identifier = "stribeck-friction"
    place = "plant"
    title = "Stribeck friction"
    equation = r"f = \left(f_c + (f_s - f_c)\,e^{-(\dot y/v_s)^2}\right)\mathrm{sgn}(\dot y)"
    reference = "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30, 1083-1138"
    parameters = (
        Parameter("coulomb", "u", "friction f_c at high speed", 0.0),
        Parameter("breakaway", "u", "friction f_s at rest", 0.0),
        Parameter("velocity", "y/s", "Stribeck velocity v_s", 1e-300),
    )
    levels = ("coulomb", "breakaway")
    separated_by = (SeparatingExperiment.FREE_DECAY,)
    uses_velocity = True

    @compiled
    def friction_level(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        share = velocity / values[2]
        return values[0] + (values[1] - values[0]) * exp(-share * share)

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the larger of both levels."""
        return CoulombFriction(force=max(self.values["coulomb"], self.values["breakaway"]))

    def scaled(self, factor: float) -> StribeckFriction:
        """Both levels, scaled."""
        return self.with_vector(self.vector * np.array([max(factor, 0.0), max(factor, 0.0), 1.0]))

    def frequency(self, plant: TransferFunction) -> float:
        """Of the fall of friction with speed, which pushes the body."""
        slope = abs(self.values["breakaway"] - self.values["coulomb"]) / self.values["velocity"]
        return min(3.0 * mobility(plant) * slope, 1e3 * float(np.max(np.abs(plant.poles()), initial=1.0)))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Break-away at one and a half times and at four times the level, at small and middle speeds."""
        force = GUESS * situation.largest("signal")
        for speed in (0.1, 0.3, 0.8):
            velocity = speed * float(np.std(situation.velocity)) or 1.0
            for level in (1.0, 5.0):
                yield cls(coulomb=level * force, breakaway=level * 1.6 * force, velocity=velocity)


class QuadraticDrag(AgainstMotion):
    """Resistance that grows with the square of the speed."""

    identifier = "quadratic-drag"
    place = "plant"
    title = "Quadratic drag"
    equation = r"f = c\,|\dot y|\,\dot y"
    reference = "Worden & Tomlinson (2001), Nonlinearity in Structural Dynamics, chapter 1"
    parameters = (Parameter("coefficient", "u s^2/y^2", "drag c"),)
    separated_by = (SeparatingExperiment.FREE_DECAY,)
    strength = "coefficient"
    uses_velocity = True

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * abs(velocity) * velocity

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        for share in (GUESS, 0.3):
            yield cls(coefficient=share * situation.largest("signal") / situation.largest("velocity") ** 2)


class CubicStiffness(AgainstMotion):
    """A spring that hardens, or softens, with the cube of the displacement."""

    identifier = "cubic-stiffness"
    place = "plant"
    title = "Cubic stiffness"
    equation = r"f = \beta\,y^3"
    reference = "Kerschen et al. (2006), Mech. Syst. Signal Process. 20, 505-592"
    parameters = (Parameter("coefficient", "u/y^3", "stiffness β, negative where it softens"),)
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    strength = "coefficient"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * position * position * position

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        for share in (GUESS, 0.3, -0.1):
            yield cls(coefficient=share * situation.largest("signal") / situation.largest("position") ** 3)


class QuadraticStiffness(AgainstMotion):
    """A spring that is stiffer to one side than to the other."""

    identifier = "quadratic-stiffness"
    place = "plant"
    title = "Quadratic stiffness"
    equation = r"f = \gamma\,y^2"
    reference = "Kerschen et al. (2006), Mech. Syst. Signal Process. 20, 505-592"
    parameters = (Parameter("coefficient", "u/y^2", "stiffness γ"),)
    separated_by = (SeparatingExperiment.REVERSED_INPUT, SeparatingExperiment.HELD_POSITIONS)
    strength = "coefficient"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * position * position

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        for share in (GUESS, 0.2, -0.2):
            yield cls(coefficient=share * situation.largest("signal") / situation.largest("position") ** 2)


class PendulumGravity(Effect):
    """Restoring force that follows the sine of the displacement, as gravity on a pendulum does."""

    identifier = "pendulum-gravity"
    place = "plant"
    title = "Gravity on a pendulum"
    equation = r"f = k\,(A\,\sin(y/A) - y),\quad k = 1/G(0)"
    reference = "Nelson & Olsson (1986), Am. J. Phys. 54, 112-121"
    parameters = (Parameter("amplitude", "y", "displacement A of one radian", 1e-300),)
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
        """From small angles to large ones."""
        for angle in (0.15, 0.5, 1.2):
            yield cls(amplitude=situation.largest("position") / angle)


class EndStop(AgainstMotion):
    """A stop that pushes back beyond a position."""

    identifier = "end-stop"
    place = "plant"
    title = "End stop"
    equation = r"f = k_s\,\max(y - y_s,\ 0)\ \ (y_s > 0),\quad f = k_s\,\min(y - y_s,\ 0)\ \ (y_s < 0)"
    reference = "Shaw & Holmes (1983), J. Sound Vib. 90, 129-155"
    parameters = (
        Parameter("position", "y", "start y_s of the contact"),
        Parameter("stiffness", "u/y", "stiffness k_s of the contact", 0.0),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    strength = "stiffness"
    signed = 1

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        if values[0] >= 0.0:
            return values[1] * max(position - values[0], 0.0)
        return values[1] * min(position - values[0], 0.0)

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return position - values[0]

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the stop."""
        return sqrt(mobility(plant) * self.values["stiffness"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several positions on both sides, soft and hard."""
        stiffness = abs(static_stiffness(situation.plant)) or situation.largest("signal") / situation.largest(
            "position"
        )
        position = situation.position
        for share in (0.5, 0.75, 0.92):
            for edge in (np.max(position), np.min(position)):
                if share * edge != 0.0:
                    for factor in (0.3, 10.0):
                        yield cls(position=float(share * edge), stiffness=factor * stiffness)


class Hysteresis(AgainstMotion):
    """Bouc–Wen hysteresis: a force that follows the motion and saturates, whichever way it goes."""

    identifier = "hysteresis"
    place = "plant"
    title = "Hysteresis (Bouc-Wen)"
    equation = r"f = h\,z,\quad \dot z = \kappa\left(\dot y - \frac{1}{2}|\dot y|\,z - \frac{1}{2}\dot y\,|z|\right)"
    reference = "Wen (1976), J. Eng. Mech. Div. ASCE 102, 249-263"
    parameters = (
        Parameter("strength", "u", "largest hysteretic force h", 0.0),
        Parameter("shape", "1/y", "inverse κ of the displacement that saturates it", 1e-300),
    )
    levels = ("strength",)
    separated_by = (SeparatingExperiment.FREE_DECAY,)
    strength = "strength"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * memory

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        # Exact: dz/dx = κ against the present sign of z, and κ (1 - |z|) along it.
        way = values[1] * position
        side = 1.0 if way >= 0.0 else -1.0
        along, way = side * memory, side * way
        if along < 0.0:
            if way <= -along:
                return side * (along + way)
            way, along = way + along, 0.0
        return side * (1.0 - (1.0 - along) * exp(-way))

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return velocity

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the saturated force."""
        return CoulombFriction(force=self.values["strength"])

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the unsaturated hysteretic spring."""
        return sqrt(mobility(plant) * self.values["strength"] * self.values["shape"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Saturation from a small share of the motion to more than all of it."""
        force = GUESS * situation.largest("signal")
        for share in (0.04, 0.15, 0.5, 1.5):
            for level in (1.0, 8.0):
                yield cls(strength=level * force, shape=1.0 / (share * situation.largest("position")))


class ExtraMode(Effect):
    """A flexible mode in series with the plant, the paper's neglected mode."""

    identifier = "extra-mode"
    place = "plant"
    title = "Neglected flexible mode"
    equation = r"y = \frac{\omega_1^2}{s^2 + 2\xi_1\omega_1 s + \omega_1^2}\;G(s)\,u"
    reference = "Laroche & Delavigne, equations (25) and (26)"
    parameters = (
        Parameter("natural_frequency", "rad/s", "natural frequency ω₁", 1e-300),
        Parameter("damping", "", "damping ratio ξ₁", 0.0, 5.0),
    )
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)

    def after_plant(self) -> TransferFunction | None:
        """The mode, with a static gain of one."""
        return second_order(1.0, self.values["natural_frequency"], self.values["damping"])

    def scaled(self, factor: float) -> ExtraMode:
        """Both terms of the mode's denominator, s²/ω₁² and 2 ξ₁ s/ω₁, scaled."""
        root = sqrt(max(factor, LEAST_FACTOR))
        return self.with_vector(self.vector * np.array([1.0 / root, root]))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Frequencies from a third of the plant's to three times the Shannon limit."""
        limit = np.pi / situation.acquisition.period
        slowest = 0.3 * min(float(np.max(np.abs(situation.plant.poles()), initial=0.0)) or limit, limit)
        for frequency in np.geomspace(slowest, 3.0 * limit, 14):
            yield cls(natural_frequency=float(frequency), damping=0.05)
            yield cls(natural_frequency=float(frequency), damping=0.4)


class ParameterDrift(Effect):
    """A coefficient of the plant that changes in proportion to the time."""

    identifier = "parameter-drift"
    place = "plant"
    title = "Drift of a coefficient"
    equation = r"c(t) = c\,(1 + r\,t)"
    reference = "Ljung (1999), System Identification, 2nd ed., section 11.2"
    parameters = (
        Parameter("coefficient", "", "what drifts", choices=("stiffness", "damping", "gain")),
        Parameter("rate", "1/s", "relative change r per second"),
    )
    separated_by = (SeparatingExperiment.REPEATED_INPUT,)
    of_one_recording = True
    strength = "rate"

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        self.uses_velocity = self.values["coefficient"] == "damping"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * time * (values[1] * position + values[2] * velocity - values[3] * signal)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Rate, and the coefficients of position, velocity and input that drift."""
        kind = self.values["coefficient"]
        return [
            self.values["rate"],
            static_stiffness(plant) if kind == "stiffness" else 0.0,
            static_damping(plant) if kind == "damping" else 0.0,
            1.0 if kind == "gain" else 0.0,
        ]

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Each coefficient, by a twentieth over the recording."""
        for kind in ("stiffness", "damping", "gain"):
            yield cls(coefficient=kind, rate=0.05 / situation.duration)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Of a clock that began long before, the drift is another coefficient."""
        return situation.far_from_zero
