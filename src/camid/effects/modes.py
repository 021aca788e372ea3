"""Flexible modes that the plant lacks, in series with it or beside it."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt
from typing import Any, ClassVar

import numpy as np

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction, second_order
from camid.effects.base import Effect
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.plant_force import LEAST_FACTOR
from camid.effects.residual_spectrum import highest_lines
from camid.effects.sensor import Delay
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# First guesses of the frequency: from this share of the plant's fastest pole to this many times the Shannon limit.
LOWEST, HIGHEST = 0.3, 1.5
FREQUENCIES = 10
DAMPING_RATIOS = (0.03, 0.3)
# Lines of the residual that a mode too light for that grid may make, and the damping ratio of its guess.
LINES, LIGHT = 2, 0.01
# Damping ratio above which a mode does nearly what a delay does: it has no peak to speak of.
WELL_DAMPED = 0.3
# Damping ratio from which a mode has no peak at all.
MOST_DAMPED = sqrt(0.5)
# Fastest mode that is fitted, in Shannon limits: what of a faster one shows is a delay, a lag or a gain.
FASTEST = 5.0
# Largest share of a mode's damping that lies between, by an estimate of that: it is one at most.
MOST_LEAD = 1.5
# Static displacement of a first guess as a share of the largest displacement over the largest input.
GUESS = 0.02


def _of_lines(situation: Situation, limit: float) -> Iterator[float]:
    """Natural frequencies in rad/s of modes that make the highest lines of the residual.

    A camera shows one beyond the Shannon limit folded about that.
    """
    for frequency in highest_lines(situation, LINES):
        yield frequency
        yield 2.0 * limit - frequency
        yield 2.0 * limit + frequency


class _Mode(Effect):
    """A mode that no recording shows beyond a few times the Shannon limit."""

    def bounds(self, acquisition: Acquisition) -> list[tuple[float, float]]:
        """Those of the parameters, and a natural frequency within reach of the frames, if it was."""
        fastest = max(FASTEST * pi / acquisition.period, self.values["natural_frequency"])
        return [(p.lower, fastest if p.name == "natural_frequency" else p.upper) for p in self.numeric()]


class ExtraMode(_Mode):
    """A flexible mode in series with the plant, the paper's neglected mode."""

    identifier = "extra-mode"
    place = "plant"
    title = "Neglected flexible mode"
    drawn_against = "frequency"
    equation = r"y = \frac{\omega_1^2}{s^2 + 2\xi_1\omega_1 s + \omega_1^2}\;G(s)\,u"
    reference = "Laroche & Delavigne, equations (25) and (26)"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("natural_frequency", "rad/s", "natural frequency ω₁", 1e-300),
        Parameter("damping", "", "damping ratio ξ₁", 0.0, 5.0),
    )
    linear_dynamics = True
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)

    def after_plant(self) -> TransferFunction | None:
        """The mode, with a static gain of one."""
        return second_order(1.0, self.values["natural_frequency"], self.values["damping"])

    def scaled(self, factor: float) -> ExtraMode:
        """Both terms of the mode's denominator, s²/ω₁² and 2 ξ₁ s/ω₁, scaled."""
        root = sqrt(max(factor, LEAST_FACTOR))
        return self.with_vector(self.vector * np.array([1.0 / root, root]))

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """The same before the forces on the plant, if it has a peak; if it is damped well, the delay of slow motion."""
        frequency, damping = self.values["natural_frequency"], self.values["damping"]
        found: list[Effect] = []
        if damping < MOST_DAMPED:
            found.append(ModeOfDrive(natural_frequency=frequency, damping=damping, side="drive"))
        if damping > WELL_DAMPED:
            found.append(Delay(delay=2.0 * damping / frequency))
        return tuple(found)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Frequencies from a third of the plant's to three times the Shannon limit."""
        limit = np.pi / situation.acquisition.period
        slowest = 0.3 * min(situation.plant.fastest_pole or limit, limit)
        for frequency in np.geomspace(slowest, 3.0 * limit, 14):
            yield cls(natural_frequency=float(frequency), damping=0.05)
            yield cls(natural_frequency=float(frequency), damping=0.4)
        for frequency in _of_lines(situation, limit):
            yield cls(natural_frequency=frequency, damping=LIGHT)


class ModeOfDrive(ExtraMode):
    """A mode between the input and the forces on the plant, as a drive on a soft mount or a filter has it.

    Of a plant without other forces it is the same on either side.
    """

    title = "Neglected flexible mode of the drive"
    equation = r"u' = \frac{\omega_1^2}{s^2 + 2\xi_1\omega_1 s + \omega_1^2}\,u"
    reference = "Preumont (2018), Vibration Control of Active Structures, 4th ed., section 3.2"
    parameters = (
        *ExtraMode.parameters,
        Parameter("side", "", "where it lies: before the forces on the plant", choices=("drive",), default="drive"),
    )

    def before_plant(self) -> TransferFunction | None:
        """The mode, with a static gain of one."""
        return ExtraMode.after_plant(self)

    def after_plant(self) -> TransferFunction | None:
        """Nothing: forces on the plant act behind it."""
        return None

    def is_plausible(self, extent: Extent) -> bool:
        """Whether it has a peak: without one it is a lag of the actuator with a number more."""
        return bool(self.values["damping"] < MOST_DAMPED) and super().is_plausible(extent)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """None that the mode behind the plant has not."""
        return ()

    def simplified(self) -> ExtraMode:
        """The same behind the plant."""
        return ExtraMode(natural_frequency=self.values["natural_frequency"], damping=self.values["damping"])


class ModeDampedBetween(ExtraMode):
    """A mode in series whose damper lies beside its spring, as a belt or a shaft has it.

    The speed of what is driven comes through the damper, which adds a zero; the paper's mode is damped against rest.
    """

    title = "Neglected flexible mode, damped by its spring"
    equation = r"y = \frac{\omega_1^2\,(1 + T s)}{s^2 + 2\xi_1\omega_1 s + \omega_1^2}\;G(s)\,u"
    reference = "Spong (1987), J. Dyn. Syst. Meas. Control 109, 310-319"
    parameters = (
        *ExtraMode.parameters,
        Parameter("lead", "s", "time constant T = damping over stiffness of what lies between", 0.0),
    )

    def after_plant(self) -> TransferFunction | None:
        """The mode, with a static gain of one."""
        mode = second_order(1.0, self.values["natural_frequency"], self.values["damping"])
        return TransferFunction((self.values["lead"] * mode.numerator[0], mode.numerator[0]), mode.denominator)

    def scaled(self, factor: float) -> ModeDampedBetween:
        """Both terms of the mode's denominator, and the lead."""
        root = sqrt(max(factor, LEAST_FACTOR))
        return self.with_vector(self.vector * np.array([1.0 / root, root, factor]))

    def is_plausible(self, extent: Extent) -> bool:
        """Whether no more damping lies between than there is: what comes earlier than that is no mode."""
        whole = 2.0 * self.values["damping"] / self.values["natural_frequency"]
        return bool(self.values["lead"] <= MOST_LEAD * whole) and super().is_plausible(extent)

    def simplified(self) -> ExtraMode:
        """The same, damped against rest."""
        return ExtraMode(natural_frequency=self.values["natural_frequency"], damping=self.values["damping"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """With all of the damping between the two."""
        yield cls(**{"lead": 2.0 * values["damping"] / values["natural_frequency"], **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is begun from the mode that is damped against rest."""
        return iter(())


class ParallelMode(_Mode):
    """A mode that the input excites beside the plant: a compliant arm, belt or coupling seen where it is driven.

    The sum of two modes has a pair of zeros between its resonances, which a mode in series has not.
    """

    identifier = "parallel-mode"
    place = "plant"
    title = "Mode in parallel (compliance of arm, belt or coupling)"
    drawn_against = "frequency"
    equation = r"y = \left(G(s) + \frac{g\,\omega_2^2}{s^2 + 2\xi_2\omega_2 s + \omega_2^2}\right)u"
    reference = "Ewins (2000), Modal Testing, 2nd ed., section 2.5; Spong (1987), J. Dyn. Syst. Meas. Control 109, 310"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("gain", "y/u", "static displacement g of the mode for a unit of the input"),
        Parameter("natural_frequency", "rad/s", "natural frequency ω₂", 1e-300),
        Parameter("damping", "", "damping ratio ξ₂", 0.0, 5.0),
    )
    linear_dynamics = True
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)
    strength: ClassVar[str | None] = "gain"

    def beside_plant(self) -> TransferFunction | None:
        """The mode."""
        gain = self.values["gain"]
        return second_order(gain, self.values["natural_frequency"], self.values["damping"]) if gain != 0.0 else None

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """The same mode in series."""
        return (ExtraMode(natural_frequency=self.values["natural_frequency"], damping=self.values["damping"]),)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Frequencies from a third of the plant's to beyond the Shannon limit, lightly and well damped."""
        limit = pi / situation.acquisition.period
        slowest = LOWEST * min(situation.plant.fastest_pole or limit, limit)
        gain = GUESS * situation.largest("position") / situation.largest("signal")
        for frequency in np.geomspace(slowest, HIGHEST * limit, FREQUENCIES):
            for damping in DAMPING_RATIOS:
                yield cls(gain=gain, natural_frequency=float(frequency), damping=damping)
        for frequency in _of_lines(situation, limit):
            yield cls(gain=gain, natural_frequency=frequency, damping=LIGHT)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Nothing excites it without input."""
        return None if np.any(situation.all_signals) else "without input nothing excites a mode beside the plant"


class MassBeside(ParallelMode):
    """A mass on a spring beside the one that is seen: a load that swings or sloshes, an absorber, a panel.

    It adds a resonance and, where it would move by itself with the seen one held, an antiresonance. Two modes in
    parallel are that as long as damping bends no mode into another (Caughey & O'Kelly 1965, J.
    Appl. Mech. 32, 583-588); this is it with any. The plant's coefficients are then those of the other resonance.
    """

    title = "Mass on a spring beside the one that is seen"
    equation = r"y = \frac{s^2/\omega_z^2 + 2\xi_z s/\omega_z + 1}{s^2/\omega_2^2 + 2\xi_2 s/\omega_2 + 1}\;G(s)\,u"
    reference = "Den Hartog (1956), Mechanical Vibrations, 4th ed., section 3.2"
    parameters = (
        Parameter("natural_frequency", "rad/s", "natural frequency ω₂ with both moving", 1e-300),
        Parameter("damping", "", "damping ratio ξ₂ with both moving", 0.0, 5.0),
        Parameter("own_frequency", "rad/s", "natural frequency ω_z of the unseen mass, the seen one held", 1e-300),
        Parameter("own_damping", "", "damping ratio ξ_z of the unseen mass, the seen one held", 0.0, 5.0),
    )
    strength = None

    def beside_plant(self) -> TransferFunction | None:
        """Nothing: it moves what is seen."""
        return None

    def after_plant(self) -> TransferFunction | None:
        """Antiresonance over resonance, with a static gain of one."""
        mode = second_order(1.0, self.values["natural_frequency"], self.values["damping"])
        (square,) = mode.numerator
        own = self.values["own_frequency"]
        zeros = (square / own**2, 2.0 * self.values["own_damping"] * square / own, square)
        return TransferFunction(zeros, mode.denominator)

    def said_of_coefficients(self) -> str:
        """That they are not those of the mass that is seen, and by how much that differs."""
        share = (self.values["own_frequency"] / self.values["natural_frequency"]) ** 2
        return (
            "beside a mass on a spring the plant's coefficients are those of the other resonance of both: the mass "
            f"that is seen is {share:.4g} times the one that they have, and its gain {1.0 / share:.4g} times theirs"
        )

    def scaled(self, factor: float) -> MassBeside:
        """Both frequencies, and both dampings, as much nearer to each other: what is the same does nothing."""
        frequency, damping, own_frequency, own_damping = self.vector
        ratio = (own_frequency / frequency) ** factor
        return self.with_vector(
            np.array([frequency, damping, frequency * ratio, damping + factor * (own_damping - damping)])
        )

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """None that is not found without it."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """With the zeros of plant and mode in parallel that lie nearest to the mode."""
        gain, frequency, damping = (values[name] for name in ("gain", "natural_frequency", "damping"))
        whole = situation.plant + second_order(gain, frequency, damping)
        zeros = [zero for zero in np.roots(whole.numerator) if zero.imag > 0.0 and zero.real < 0.0]
        if zeros:
            zero = min(zeros, key=lambda each: abs(abs(each) - frequency))
            own = {"own_frequency": float(abs(zero)), "own_damping": float(-zero.real / abs(zero))}
            yield cls(natural_frequency=frequency, damping=damping, **own)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is begun from the mode in parallel."""
        return iter(())
