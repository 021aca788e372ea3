"""Periodic effects that are no sine: the same with one harmonic.

Poles, teeth, windings and discs are never shaped so that a pure sine results: what repeats has harmonics (Hanselman
2006, chapter 7, of the detent torque), and the second or the third is mostly the largest.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sin, sqrt
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.disturbance import PeriodicDisturbance, force_at
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.periodic_in_position import (
    LARGEST_SLOPE,
    Cogging,
    EncoderEccentricity,
    PeriodicInPosition,
    WaveRegression,
)
from camid.effects.plant_force import mobility
from camid.effects.sensor_oscillation import SensorOscillation, oscillation_at
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# Multiples of the frequency that a harmonic may have, by name.
ORDERS = {"second": 2.0, "third": 3.0}

# Largest period of a force with a harmonic as a share of the range of the motion: a force over the position that is no
# spring's may be anything, and over fewer than two and a half periods five numbers make nearly any of it.
LARGEST_PERIOD = 0.4
# Angles of a turn at which the slope of a reading is looked at.
ANGLES = 181
# What one adds along the way.
HARMONIC = r" + h\,\left(\sin(2\pi k y/p + \psi) - \sin\psi\right)"


def _harmonic_of(unit: str) -> tuple[Parameter, ...]:
    """Its parameters: which one it is, its amplitude in a unit, and its phase."""
    return (
        Parameter("harmonic", "", "which harmonic there is besides", choices=tuple(ORDERS)),
        Parameter("harmonic_amplitude", unit, "amplitude h of the harmonic", 0.0),
        Parameter("harmonic_phase", "rad", "phase ψ of the harmonic at zero", scale="one"),
    )


class WithHarmonic(Effect):
    """What all of them share."""

    @property
    def order(self) -> float:
        """Multiple of the frequency."""
        return ORDERS[self.values["harmonic"]]

    @property
    def harmonic(self) -> list[float]:
        """Amplitude, multiple of the frequency and phase of the harmonic."""
        return [self.values["harmonic_amplitude"], self.order, self.values["harmonic_phase"]]

    def scaled(self, factor: float) -> Self:
        """Both amplitudes."""
        amplitudes = {name: factor * self.values[name] for name in ("amplitude", "harmonic_amplitude")}
        return type(self)(**{**self.values, **amplitudes})

    def simplified(self) -> Effect:
        """The sine alone."""
        bases = (kind for kind in type(self).__mro__ if issubclass(kind, Effect))
        sine = next(kind for kind in bases if "identifier" in vars(kind))
        return sine(**{parameter.name: self.values[parameter.name] for parameter in sine.parameters})

    def force_values(self, plant: TransferFunction) -> list[float]:
        """The sine's numbers, and those of the harmonic."""
        return [*self.vector[:3].tolist(), *self.harmonic]

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a sine that was found."""
        yield from ()


class _OverTime(WithHarmonic):
    """What both laws over the time share."""

    @staticmethod
    def seen_at(situation: Situation, angular: float) -> dict[str, float]:
        """Amplitude and phase that the residual shows at an angular frequency in rad/s."""
        raise NotImplementedError

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From what the residual shows at each harmonic."""
        for harmonic, order in ORDERS.items():
            seen = cls.seen_at(situation, order * values["frequency"])
            shape = {"harmonic_amplitude": seen["amplitude"], "harmonic_phase": seen["phase"]}
            yield cls(**{"harmonic": harmonic, **shape, **values})


class PeriodicDisturbanceWithHarmonic(_OverTime, PeriodicDisturbance):
    """A periodic force that is no sine."""

    title = "Periodic disturbance with a harmonic"
    equation = r"d = a\,\sin(\omega t + \varphi) + h\,\sin(k\omega t + \psi)"
    parameters = (*PeriodicDisturbance.parameters, *_harmonic_of("u"))
    seen_at = staticmethod(force_at)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        first = values[0] * sin(values[1] * time + values[2])
        return -(first + values[3] * sin(values[4] * values[1] * time + values[5]))

    def frequency(self, plant: object) -> float:
        """That of the harmonic."""
        return self.order * super().frequency(plant)


class SensorOscillationWithHarmonic(_OverTime, SensorOscillation):
    """A hum that is no sine, as that of a rectifier is none."""

    title = "Oscillation of the measurement with a harmonic"
    equation = SensorOscillation.equation + r" + h\,\sin(k\omega t + \psi)"
    parameters = (*SensorOscillation.parameters, *_harmonic_of("y"))
    seen_at = staticmethod(oscillation_at)

    def observe(self, output: Array, time: Array) -> Array:
        """Add both."""
        amplitude, order, phase = self.harmonic
        return super().observe(output, time) + amplitude * np.sin(order * self.values["frequency"] * time + phase)


class _AlongTheWay(WithHarmonic, PeriodicInPosition):
    """What both laws along the way share."""

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From what the residual shows at each harmonic."""
        regression = WaveRegression(situation, cls.seen(situation))
        for harmonic, order in () if regression.fails else ORDERS.items():
            gain, amplitude, phase = (float(each[0]) for each in regression.at(np.array([values["period"] / order])))
            if gain > 0.0:
                amplitude = min(amplitude, values["amplitude"])
                shape = {"harmonic_amplitude": amplitude, "harmonic_phase": phase}
                yield cls(**{"harmonic": harmonic, **shape, **values})


class CoggingWithHarmonic(_AlongTheWay, Cogging):
    """Cogging of poles that are no sine."""

    title = "Cogging with a harmonic"
    equation = Cogging.equation + HARMONIC
    parameters = (*Cogging.parameters, *_harmonic_of("u"))

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        angle = 2.0 * pi * position / values[1]
        first = values[0] * (sin(angle + values[2]) - sin(values[2]))
        return first + values[3] * (sin(values[4] * angle + values[5]) - sin(values[5]))

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the positions hold enough periods to tell it from a spring of any shape."""
        return bool(self.values["period"] <= LARGEST_PERIOD * extent.span)

    def frequency(self, plant: TransferFunction) -> float:
        """Of small oscillations about the steepest place there may be."""
        steepness = self.values["amplitude"] + self.order * self.values["harmonic_amplitude"]
        return sqrt(mobility(plant) * steepness * 2.0 * pi / self.values["period"])


class EncoderEccentricityWithHarmonic(_AlongTheWay, EncoderEccentricity):
    """An encoder whose disc is neither centred nor round."""

    title = "Eccentricity of the encoder with a harmonic"
    equation = EncoderEccentricity.equation + HARMONIC
    parameters = (*EncoderEccentricity.parameters, *_harmonic_of("y"))

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the positions hold enough periods, and the reading still grows with the position."""
        amplitude, order, phase = self.harmonic
        turn = np.linspace(0.0, 2.0 * pi, ANGLES)
        slopes = self.values["amplitude"] * np.cos(turn + self.values["phase"])
        slopes += order * amplitude * np.cos(order * turn + phase)
        steepest = -2.0 * pi * float(np.min(slopes)) / self.values["period"]
        return PeriodicInPosition.is_plausible(self, extent) and steepest < LARGEST_SLOPE

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean of the reading over the exposure."""
        from camid.chain.motion import WEIGHTS

        mean = super().measure(motion, start, end)
        amplitude, order, phase = self.harmonic
        angle = order * 2.0 * pi * motion.points(start, end) / self.values["period"] + phase
        return np.asarray(mean + amplitude * ((np.sin(angle) - sin(phase)) @ (0.5 * WEIGHTS)))
