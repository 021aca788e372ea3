"""Pairs of tables of one run: the log of a drive and the clip of a camera, each on a clock of its own.

Nothing here imports camid. Time of the drive = offset + (1 + skew) time of the clip; the time stamp of a frame is the
end of its exposure.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, exp, log, pi
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .motion import Motion

Array = NDArray[np.float64]

METHODS = ("match", "simulation")
# Digits after the point of the times that are written, in s: a microsecond, as cameras and drives state it.
DECIMALS = 6
# Seconds of the rig that are simulated before and after what is recorded: any exposure lies within.
MARGIN = 1.0


@dataclass(frozen=True)
class Pair:
    """What a pair of tables is made of.

    Attributes
    ----------
    seed, number : int
    method : str
        "match" or "simulation": by what the tool is to join them.
    frequency, damping, gain : float
        Of the rig: Hz, ratio, mm/s^2 per unit of input.
    rate : float
        Samples of the drive per second.
    hold : int
        Samples for which a level of the input is held.
    frames : float
        Frames per second of the camera, by its own clock.
    exposure : float
        Seconds.
    scale, shift : float
        Reading of the camera = scale position + shift, in px.
    camera_noise, encoder_noise : float
        Standard deviations, as shares of the standard deviation of what is measured.
    lost : float
        Share of the frames that are missing.
    first, duration : float
        First time stamp of the clip and its length, s by its own clock.
    offset, skew : float
        Of the clocks: s, and without unit.
    log_start, log_end : float
        Times of the drive between which it logs, s.
    driven_before : bool
        Whether the input acts before the log begins; the rig is at rest there else.
    wrong : tuple of float
        Factors on gain, damping and stiffness by which the coefficients that a user believes are wrong.
    """

    seed: int
    number: int
    method: str
    frequency: float
    damping: float
    gain: float
    rate: float
    hold: int
    frames: float
    exposure: float
    scale: float
    shift: float
    camera_noise: float
    encoder_noise: float
    lost: float
    first: float
    duration: float
    offset: float
    skew: float
    log_start: float
    log_end: float
    driven_before: bool
    wrong: tuple[float, float, float]

    @property
    def middle(self) -> float:
        """Time of the clip in its middle, s."""
        return self.first + 0.5 * self.duration

    def to_drive(self, time: float | Array) -> Any:
        """Times of the clip (s) on the clock of the drive, in their shape."""
        return self.offset + (1.0 + self.skew) * time

    def simulation(self) -> dict[str, Any]:
        """What a user believes of the rig: wrong coefficients, in px of the camera."""
        speed = 2.0 * pi * self.frequency
        gain, damping, stiffness = self.wrong
        denominator = [1.0, 2.0 * self.damping * speed * damping, speed**2 * stiffness]
        return {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": {"transfer_function": {"numerator": [self.scale * self.gain * gain], "denominator": denominator}},
            "sensor": {"column": "x", "kind": "camera", "exposure": self.exposure, "latency": 0.0},
            "initial_state": "estimate",
        }


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Drawn evenly on a scale of ratios."""
    return exp(rng.uniform(log(low), log(high)))


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def draw(seed: int, number: int) -> Pair:
    """A pair by its number; every second one is to be joined by the same method."""
    rng = np.random.default_rng([seed, number])
    rate, frames = _between(rng, 50.0, 1000.0), _between(rng, 25.0, 120.0)
    # A whole number of samples of 20 to 60 ms: at least one.
    shortest = ceil(0.020 * rate - 1e-9)
    hold = int(rng.integers(shortest, max(int(0.060 * rate), shortest) + 1))
    first = float(rng.choice([0.0, rng.uniform(0.0, 30.0)]))
    duration = rng.uniform(10.0, 60.0)
    offset = rng.uniform(-20.0, 20.0)
    # Most clocks agree to some 1e-4; a few cameras state a frame rate that is not theirs.
    skew = rng.normal(0.0, 2e-4) if rng.random() > 0.05 else rng.uniform(-2e-3, 2e-3)
    starts = offset + (1.0 + skew) * first
    return Pair(
        seed,
        number,
        METHODS[number % 2],
        frequency=_between(rng, 0.5, 4.0),
        damping=_between(rng, 0.03, 0.5),
        gain=_between(rng, 30.0, 300.0),
        rate=rate,
        hold=hold,
        frames=frames,
        exposure=rng.uniform(0.2, 1.0) / frames,
        scale=_sign(rng) * _between(rng, 1.0, 50.0),
        shift=rng.uniform(0.0, 1000.0),
        camera_noise=_between(rng, 0.003, 0.05),
        encoder_noise=_between(rng, 0.003, 0.05),
        lost=rng.uniform(0.01, 0.05) if rng.random() < 0.25 else 0.0,
        first=first,
        duration=duration,
        offset=offset,
        skew=skew,
        log_start=starts + rng.uniform(-0.2, 0.2) * duration,
        log_end=starts + duration + rng.uniform(-0.15, 0.2) * duration,
        driven_before=bool(rng.random() < 0.5),
        wrong=(_between(rng, 0.6, 1.6), _between(rng, 0.6, 1.6), _between(rng, 0.6, 1.6)),
    )


def tables(pair: Pair) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The tables of a pair.

    Returns
    -------
    clip, drive : DataFrame
        ``t`` (s) and ``x`` (px); ``t`` (s), ``u`` and ``encoder`` (mm). After the log ends the drive is switched off.
    """
    rng = np.random.default_rng([pair.seed, pair.number, 1])
    period = 1.0 / pair.rate
    samples = int((pair.log_end - pair.log_start) * pair.rate)
    # Whole levels before the log, so that its first sample begins one.
    span = pair.log_start - min(pair.to_drive(pair.first), pair.log_start) + MARGIN
    before = ceil(span * pair.rate / pair.hold) * pair.hold
    after = ceil((max(pair.to_drive(pair.first + pair.duration) - pair.log_end, 0.0) + MARGIN) * pair.rate)
    levels = np.repeat(rng.uniform(-1.0, 1.0, ceil((before + samples) / pair.hold)), pair.hold)[: before + samples]
    if not pair.driven_before:
        levels[:before] = 0.0
    start = pair.log_start - before * period
    held = np.append(levels, np.zeros(after))
    motion = Motion(pair.frequency, pair.damping, pair.gain, held, period, start)

    logged: Array = np.asarray(pair.log_start + period * np.arange(samples), float)
    position = motion.position_at(logged)
    encoder = position + pair.encoder_noise * float(np.std(position)) * rng.standard_normal(samples)
    drive = pd.DataFrame({"t": np.round(logged, DECIMALS), "u": levels[before:], "encoder": encoder})

    stamps = pair.first + np.arange(int(pair.duration * pair.frames)) / pair.frames
    seen = pair.scale * motion.mean(pair.to_drive(stamps), pair.exposure * (1.0 + pair.skew)) + pair.shift
    seen += pair.camera_noise * float(np.std(seen)) * rng.standard_normal(len(seen))
    kept = rng.random(len(seen)) >= pair.lost
    clip = pd.DataFrame({"t": np.round(stamps, DECIMALS), "x": seen})[kept]
    return clip.reset_index(drop=True), drive
