"""Effects that repeat along the way: cogging of a motor, and an encoder that is not centred on its shaft."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from math import pi, sin, sqrt
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.force_over_position import plant_beside_wave
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility
from camid.effects.recorded_force import best_pairs, best_waves, short_periods, waves_of_force
from camid.effects.residual_regression import ResidualRegression, sampled
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# Periods that the range of the motion may hold: of a force, whose response takes a simulation, and as the recorded
# motion shows it, of which the many of a motor that turns often are looked at all together; and of an error of the
# reading. A sinusoid that does not return twice is a polynomial to the data,
# and other effects name it.
SIMULATED_PERIODS, RECORDED_PERIODS = np.arange(2.0, 30.0, 0.25), np.arange(2.0, 60.0, 0.5)
MANY_PERIODS = np.arange(60.0, 600.0, 0.25)
READ_PERIODS = np.concatenate([np.arange(1.25, 2.0, 0.125), SIMULATED_PERIODS, np.arange(30.0, 120.0, 0.5)])
# Largest period as a share of the range, of a force and of a reading, in which each turn is seen as it is; a fit may
# move it a little beyond that of the first guess.
LARGEST_PERIOD, LARGEST_PERIOD_OF_A_READING = 0.6, 0.85
# Slope of an encoder's error from which it is none: from one on the reading turns round while the shaft goes on.
LARGEST_SLOPE = 0.9
# The best periods that become first guesses.
BEST = 3
# Share of the largest value within which two are the same.
SAME_VALUE = 1e-9
# Harmonics that a force may have, by their multiple of the frequency, and the constant that is added to the input.
HARMONICS, BIAS = {2: "second", 3: "third"}, "bias"
# Sinusoids that are looked at together.
TOGETHER = 32
# A period of an encoder's error holds more steps of its readings than this, and that of a force more than this: a
# lattice shows no shorter wave, and rounding itself repeats every step.
STEPS_PER_PERIOD = 5.0
STEPS_PER_PERIOD_OF_A_FORCE = 2.0


class WaveRegression(ResidualRegression):
    """Sinusoids of the position whose response explains the residual of a situation, to first order."""

    def at(self, periods: Array) -> tuple[Array, Array, Array]:
        """Gain, and the amplitude and phase at zero of sinusoids with some periods, shape (P,); zero where unseen."""
        parts = [self._some(periods[first : first + TOGETHER]) for first in range(0, len(periods), TOGETHER)]
        gains, amplitudes, phases = (np.concatenate(each) for each in zip(*parts, strict=True))
        return gains, amplitudes, phases

    def _some(self, periods: Array) -> tuple[Array, Array, Array]:
        angles = 2.0 * pi * self.situation.position[:, None] / periods
        (sines, sines_show), (cosines, cosines_show) = (self.left(wave) for wave in (np.sin(angles), np.cos(angles)))
        shares, amplitudes, phases = best_pairs(self.residual, sines, cosines)
        gains, shown = (1.0 - shares) * float(self.residual @ self.residual), sines_show & cosines_show
        return gains * shown, amplitudes * shown, phases * shown


def best_periods(situation: Situation, respond: Callable[[Array], Array], counts: Array) -> list[dict[str, float]]:
    """Amplitude, period and phase of sinusoids of the position whose response explains the residual best, in order.

    Parameters
    ----------
    situation : Situation
    respond : callable
        See :class:`camid.effects.residual_regression.ResidualRegression`.
    counts : ndarray, shape (P,)
        Periods that the range of the motion may hold.
    """
    span = float(np.ptp(situation.position))
    regression = WaveRegression(situation, respond) if span > 0.0 else None
    if regression is None or regression.fails:
        return []
    gains, amplitudes, phases = regression.at(span / counts)
    return best_waves(gains, 0.0, BEST, amplitudes, span / counts, phases)


def _least_difference(values: Array) -> float:
    """Step of a lattice on which values lie: the least difference of two that differ beyond rounding, else 0."""
    differences = np.diff(np.unique(values))
    differences = differences[differences > SAME_VALUE * float(np.max(np.abs(values), initial=0.0))]
    return float(np.min(differences, initial=np.inf)) if len(differences) else 0.0


class PeriodicInPosition(Effect):
    """An effect of which more than a period has to be seen."""

    largest_period: ClassVar[float] = LARGEST_PERIOD

    @staticmethod
    def seen(situation: Situation) -> Callable[[Array], Array]:
        """What becomes of such signals along the motion, shape (N,) or (N, c), in the recorded output."""
        raise NotImplementedError

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the positions hold enough periods."""
        return bool(self.values["period"] <= self.largest_period * extent.span)


class Cogging(PeriodicInPosition):
    """A force that pulls the motor to its nearest pole, whatever the input: it repeats along the way.

    Positions count from rest, where the force is in balance.
    """

    identifier = "cogging"
    place = "plant"
    title = "Cogging (detent force)"
    equation = r"f = a\,\left(\sin(2\pi y/p + \varphi) - \sin\varphi\right)"
    reference = "Hanselman (2006), Brushless Permanent Magnet Motor Design, 2nd ed., chapter 7"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u", "amplitude a of the force", 0.0),
        Parameter("period", "y", "distance p of two poles", 1e-300),
        Parameter("phase", "rad", "phase φ at y = 0", scale="one"),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    strength = "amplitude"
    trials = "frequencies"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * (sin(2.0 * pi * position / values[1] + values[2]) - sin(values[2]))

    @staticmethod
    def seen(situation: Situation) -> Callable[[Array], Array]:
        """The plant's response to a force against the motion."""
        joined = replace(situation.acquisition, hold="foh")
        return lambda force: sampled(situation.plant, -force, joined)

    def frequency(self, plant: TransferFunction) -> float:
        """Of small oscillations about a pole."""
        return sqrt(mobility(plant) * self.values["amplitude"] * 2.0 * pi / self.values["period"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """The periods that explain best what moves the plant as it was recorded, and the residual, to first order."""
        step = _least_difference(situation.recorded)
        guesses = _forces(situation, BEST)
        # In few rows, or noisy ones, waves of the recorded motion are chance.
        guesses += best_periods(situation, cls.seen(situation), SIMULATED_PERIODS)
        largest = situation.largest("signal")
        for guess in guesses:
            if guess["period"] > STEPS_PER_PERIOD_OF_A_FORCE * step:
                yield cls(**{**guess, "amplitude": min(guess["amplitude"], largest)})

    @classmethod
    def with_plant(
        cls, situation: Situation, constants: Mapping[str, float]
    ) -> tuple[Effect, TransferFunction, dict[str, float]] | None:
        """Beside the plant that the recorded motion shows with it, and with a harmonic where that shows, too."""
        guesses = _forces(situation, 1)
        found = plant_beside_wave(situation, guesses[0]["period"], tuple(HARMONICS)) if guesses else None
        if found is None:
            return None
        (amplitude, phase), *more = found.waves
        values: dict[str, Any] = {"amplitude": amplitude, "period": found.period, "phase": phase}
        law: type[Effect] = cls
        for size, angle in more:
            law = cls.with_keys(["harmonic"])
            values |= {
                "harmonic": HARMONICS[found.order],
                "harmonic_amplitude": size,
                "harmonic_phase": angle,
            }
        # The force counts from the zero of the position, where it is none.
        bias = found.bias - sum(size * sin(angle) for size, angle in found.waves)
        return law(**values), found.plant, dict.fromkeys(constants.keys() & {BIAS}, bias)


def _forces(situation: Situation, most: int) -> list[dict[str, float]]:
    """The waves along the way that explain best what moves the plant as it was recorded."""
    span = float(np.ptp(situation.recorded))
    if span == 0.0:
        return []
    short = short_periods(situation, span / MANY_PERIODS, most)
    return waves_of_force(situation, np.concatenate([span / RECORDED_PERIODS, short]), most)


class CoggingAboutAnyZero(Cogging):
    """Cogging that pulls at the zero of the position, too: an encoder's zero is where it was switched on.

    Dry friction holds the motor there, or a constant input does.
    """

    equation = r"f = a\,\sin(2\pi y/p + \varphi)"
    parameters = (
        *Cogging.parameters,
        Parameter("zero", "", "what the zero of the position is", choices=("anywhere",), default="anywhere"),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * sin(2.0 * pi * position / values[1] + values[2])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from cogging that was found."""
        return iter(())


class EncoderEccentricity(PeriodicInPosition):
    """An encoder whose disc is not centred on the shaft, or a screw whose pitch wobbles: it errs once a period.

    Its zero is where the plant rests; an offset is another effect.
    """

    identifier = "encoder-eccentricity"
    place = "sensor"
    title = "Eccentricity of the encoder"
    equation = r"w = y + e\,\left(\sin(2\pi y/p + \varphi) - \sin\varphi\right)"
    reference = "Hanselman (1990), IEEE Trans. Ind. Electron. 37, 556-561 (errors that are periodic in the position)"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "y", "amplitude e of the error", 0.0),
        Parameter("period", "y", "displacement p of a turn", 1e-300),
        Parameter("phase", "rad", "phase φ at y = 0", scale="one"),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS, SeparatingExperiment.SCALE_IN_THE_IMAGE)
    strength = "amplitude"
    trials = "frequencies"
    largest_period = LARGEST_PERIOD_OF_A_READING

    @staticmethod
    def seen(situation: Situation) -> Callable[[Array], Array]:
        """The error itself."""
        return lambda error: error

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the positions hold enough periods, and the reading still grows with the position."""
        slope = 2.0 * pi * self.values["amplitude"] / self.values["period"]
        return super().is_plausible(extent) and slope < LARGEST_SLOPE

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean of the reading over the exposure."""
        from camid.chain.motion import WEIGHTS

        points = motion.points(start, end)
        angle = 2.0 * pi * points / self.values["period"] + self.values["phase"]
        error = self.values["amplitude"] * (np.sin(angle) - sin(self.values["phase"]))
        return np.asarray((points + error) @ (0.5 * WEIGHTS))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """The periods that explain the residual best, to first order."""
        step = _least_difference(situation.recorded)
        largest = situation.largest("position")
        for guess in best_periods(situation, cls.seen(situation), READ_PERIODS):
            # What quantisation adds repeats along the way, too.
            if guess["period"] > STEPS_PER_PERIOD * step:
                yield cls(**{**guess, "amplitude": min(guess["amplitude"], largest)})
