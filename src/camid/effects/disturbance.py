"""Forces at the plant's input that do not depend on the motion: functions of the recorded time."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sin
from typing import ClassVar

import numpy as np

from camid.chain.companion_form import time_scale
from camid.chain.exact import sample
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.residual_spectrum import highest_lines, phasor_at
from camid.effects.sensor_shift import SensorShift
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Spectral lines of the residual, and times, that are looked into; and other times of a force that was fitted.
LINES = 4
TIMES, OTHER_TIMES = 3, 3
# Periods of a force that a recording holds at least: what has not returned may be a drift as well.
FEWEST_PERIODS = 1.5


def force_at(situation: Situation, angular: float) -> dict[str, float]:
    """Amplitude and phase at time zero of the sinusoidal force that the residual shows at an angular frequency."""
    acquisition = situation.acquisition
    exposure = float(acquisition.exposure or 0.0) if acquisition.sensor == "camera" else 0.0
    middle = situation.time - acquisition.latency - 0.5 * exposure
    phasor = phasor_at(situation, angular, middle)
    gain = complex(situation.response_to_force.frequency_response(angular)) * np.sinc(angular * exposure / (2.0 * pi))
    force = phasor / gain if abs(gain) > 0.0 else phasor
    return {"amplitude": float(abs(force)), "phase": float(np.angle(force))}


class PeriodicDisturbance(Effect):
    """A sinusoidal force."""

    identifier = "periodic-disturbance"
    place = "disturbance"
    title = "Periodic disturbance"
    equation = r"d = a\,\sin(\omega t + \varphi)"
    reference = "Bodson & Douglas (1997), Automatica 33, 2213-2221"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u", "amplitude a", 0.0),
        Parameter("frequency", "rad/s", "angular frequency ω", 0.0, scale="resolution"),
        Parameter("phase", "rad", "phase φ at time zero", scale="one"),
    )
    separated_by = (SeparatingExperiment.REPEATED_INPUT, SeparatingExperiment.HELD_POSITIONS)
    of_one_recording = True
    strength = "amplitude"
    trials = "frequencies"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return -values[0] * sin(values[1] * time + values[2])

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the recording holds enough periods: a part of one is a drift."""
        return bool(self.values["frequency"] * extent.duration >= 2.0 * pi * FEWEST_PERIODS)

    def frequency(self, plant: object) -> float:
        """Its own."""
        return float(self.values["frequency"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """The highest lines of the residual's spectrum, brought back to the plant's input."""
        for angular in highest_lines(situation, LINES):
            yield cls(frequency=angular, **force_at(situation, angular))


def explained_from_each_row(residual: Array, response: Array) -> tuple[Array, Array]:
    """What a response that starts at each row explains of a residual, and its factor there, both of shape (N,)."""
    count, size = len(residual), 2 * len(residual)
    correlation = np.fft.irfft(np.fft.rfft(residual, size) * np.conj(np.fft.rfft(response, size)), size)[:count]
    energy = np.cumsum(response**2)[::-1]  # what is left of the response before the record ends
    energy = np.maximum(energy, 1e-3 * energy[0])
    return correlation**2 / energy, correlation / energy


def _best_times(situation: Situation, response: Array) -> list[float]:
    """Times at which a response that starts there fits the residual best, in seconds."""
    count = len(situation.residual)
    score, _ = explained_from_each_row(situation.residual, response)
    times = []
    for _ in range(TIMES):
        i = int(np.argmax(score))
        times.append(float(situation.time[i]))
        score[max(i - count // 50 - 3, 0) : i + count // 50 + 4] = -1.0
    return times


def _other_times(situation: Situation, response: Array, factor: float, time: float) -> list[tuple[float, float]]:
    """Factors and times, in seconds, at which a response that was fitted at one time may do as well at another.

    What oscillates does nearly the same half a period later with the other sign, so that a sum of squares has as many
    minima; those that explain most of the residual without the response come first.
    """
    from scipy.signal import find_peaks

    row = int(np.argmin(np.abs(situation.time - time)))
    done = np.concatenate([np.zeros(row), response])[: len(response)]
    explained, factors = explained_from_each_row(situation.residual + situation.used * factor * done, response)
    peaks, _ = find_peaks(explained)
    others = sorted((int(i) for i in peaks if abs(i - row) > 1), key=lambda i: -explained[i])
    return [(float(factors[i]), float(situation.time[i])) for i in others[:OTHER_TIMES]]


class StepDisturbance(Effect):
    """A force that sets in and stays."""

    identifier = "step-disturbance"
    place = "disturbance"
    title = "Step disturbance"
    equation = r"d = s\ \ (t \geq t_0),\quad d = 0\ \ (t < t_0)"
    reference = "Basseville & Nikiforov (1993), Detection of Abrupt Changes, chapter 7"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("size", "u", "size s"),
        Parameter("time", "s", "onset t_0", scale="period"),
    )
    separated_by = (
        SeparatingExperiment.REVERSED_INPUT,
        SeparatingExperiment.REPEATED_INPUT,
        SeparatingExperiment.NO_INPUT,
    )
    of_one_recording = True
    strength = "size"
    trials = "frames"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return -values[0] if time >= values[1] else 0.0

    def breaks(self) -> tuple[float, ...]:
        """Its onset."""
        return (self.values["time"],)

    def restarts(self, situation: Situation) -> tuple[StepDisturbance, ...]:
        """Where the residual shows it as well, and half a time constant earlier and later.

        While friction holds a body it does not show when a force sets in.
        """
        shift = 0.5 * time_scale(situation.plant.monic.denominator)
        size, time = self.values["size"], self.values["time"]
        begins = [(size, time + side * shift) for side in (-1.0, 1.0)]
        begins += _other_times(situation, self._response(situation), size, time)
        return tuple(type(self)(size=size, time=time) for size, time in begins)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """A camera that is knocked at that time."""
        size = situation.response_to_force.static_gain() * self.values["size"]
        return (SensorShift(size=size, time=self.values["time"]),) if np.isfinite(size) else ()

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Where the response to a step fits the residual best, or that to a force which passes."""
        size = 0.05 * situation.largest("signal")
        for time in _best_times(situation, cls._response(situation)):
            for shift in (0.0, -0.5):
                yield cls(size=size, time=time + shift * situation.acquisition.period)
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    @staticmethod
    def _response(situation: Situation) -> Array:
        """Of the output to a force of one from the first row on."""
        return sample(situation.response_to_force, np.ones(len(situation.time)), situation.acquisition)


class ImpulseDisturbance(Effect):
    """A blow: a force that is over before the camera can follow it."""

    identifier = "impulse-disturbance"
    place = "disturbance"
    title = "Impulse disturbance"
    equation = r"d = s\,\delta(t - t_0)"
    reference = "Basseville & Nikiforov (1993), Detection of Abrupt Changes, chapter 7"
    parameters = (
        Parameter("size", "u s", "size s"),
        Parameter("time", "s", "time t_0", scale="period"),
    )
    separated_by = (SeparatingExperiment.NO_INPUT,)
    of_one_recording = True
    strength = "size"
    trials = "frames"

    def impulses(self) -> tuple[tuple[float, float], ...]:
        """The blow."""
        return ((self.values["time"], self.values["size"]),)

    def restarts(self, situation: Situation) -> tuple[ImpulseDisturbance, ...]:
        """Where the residual shows it as well."""
        period = situation.acquisition.period
        size, middle = self.values["size"] / period, self.values["time"] - 0.5 * period
        begins = _other_times(situation, self._response(situation), size, middle)
        return tuple(type(self)(size=size * period, time=time + 0.5 * period) for size, time in begins)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Where the response to a blow fits the residual best."""
        period = situation.acquisition.period
        size = 0.05 * situation.largest("signal") * period
        for time in _best_times(situation, cls._response(situation)):
            for shift in (0.5, 0.0):
                yield cls(size=size, time=time + shift * period)

    @staticmethod
    def _response(situation: Situation) -> Array:
        """Of the output to a force of one during the first period."""
        signal = np.zeros(len(situation.time))
        signal[0] = 1.0
        return sample(situation.response_to_force, signal, situation.acquisition)
