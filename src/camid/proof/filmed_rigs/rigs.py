"""Rigs that are filmed: what is drawn of them, their equation of motion, and the log of their drive.

Nothing here imports camid. Lengths are in px of the image where the scale is one, forces in units of the input.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, copysign, exp, log, pi
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]

NOTHING = "nothing"
ROLLING_SHUTTER = "rolling-shutter"
PERSPECTIVE = "perspective"
FRICTION = "coulomb-friction"
CUBIC = "cubic-stiffness"
CONCEALED = (NOTHING, ROLLING_SHUTTER, PERSPECTIVE, FRICTION, CUBIC)
# Longest step of the integrator, s: what lies between two steps is straight to 1e-4 px.
LONGEST_STEP = 1.25e-4
# Rounds in which the cubic stiffness and the motion that it leaves are brought together.
ROUNDS = 12
# Digits after the point of the times that are written, in s.
DECIMALS = 6


@dataclass(frozen=True)
class Rig:
    """A rig, its drive and its camera.

    Attributes
    ----------
    concealed : str
        What the user knows nothing of; one of ``CONCEALED``.
    size : float
        Of it: share of a frame's period that the readout over the motion takes; relative change of the scale over the
        motion; friction as a share of the largest input; cubic force as a share of the linear one at the largest
        motion.
    frequency, damping : float
        Hz and ratio.
    motion : float
        From one end of the motion to the other, px.
    vertical : bool
        Whether it moves along the columns of the image, else along the rows.
    rate : int
        Samples of the drive per second.
    hold : int
        Samples for which a level is held.
    frame_rate : float
        Frames per second of the camera, by its own clock.
    frames : int
    exposure : float
        Seconds.
    first, lead : float
        First time stamp of the clip by its own clock, and when that is after the log's first sample at time zero, s.
    skew : float
        Time of the drive = offset + (1 + skew) time of the clip.
    radius : float
        Of the disc, px.
    bright : bool
        Whether the disc is brighter than what is behind it.
    noise : float
        Of a pixel, grey levels.
    aside : float
        Distance from the middle of the motion to the middle of the image, px.
    wrong : tuple of float
        Factors on gain, damping and stiffness that a user believes.
    """

    concealed: str
    size: float
    frequency: float
    damping: float
    motion: float
    vertical: bool
    rate: int
    hold: int
    frame_rate: float
    frames: int
    exposure: float
    first: float
    lead: float
    skew: float
    radius: float
    bright: bool
    noise: float
    aside: float
    wrong: tuple[float, float, float]

    @property
    def offset(self) -> float:
        """Of the clocks, s."""
        return self.lead - (1.0 + self.skew) * self.first

    @property
    def stamps(self) -> Array:
        """Time stamps of the frames by the camera's clock, s, shape (frames,)."""
        return self.first + np.arange(self.frames) / self.frame_rate

    def to_drive(self, time: Any) -> Any:
        """Times of the clip (s) on the clock of the drive."""
        return self.offset + (1.0 + self.skew) * time


@dataclass(frozen=True)
class Run:
    """What a rig did.

    Attributes
    ----------
    levels : ndarray, shape (M,)
        Input at the samples of the drive, the first at time zero of its clock.
    step : float
        Of ``position``, s.
    position : ndarray, shape (K,)
        From time zero of the drive, px from where the rig rests.
    gain : float
        Acceleration for a unit of input, px/s^2.
    """

    levels: Array
    step: float
    position: Array
    gain: float

    def at(self, times: Array) -> Array:
        """Position at times of the drive (s), in their shape."""
        return np.interp(times, self.step * np.arange(len(self.position)), self.position)


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Drawn evenly on a scale of ratios."""
    return exp(rng.uniform(log(low), log(high)))


SIZES = {ROLLING_SHUTTER: (0.2, 0.6), PERSPECTIVE: (0.15, 0.30), FRICTION: (0.05, 0.15), CUBIC: (0.2, 0.4)}


def draw(seed: int, number: int) -> Rig:
    """A rig by its number; what is concealed follows in turn."""
    rng = np.random.default_rng([seed, number])
    concealed = CONCEALED[number % len(CONCEALED)]
    rate = int(rng.choice([50, 100, 200, 250, 500, 1000]))
    frame_rate = float(rng.choice([50.0, 59.94, 60.0]))
    return Rig(
        concealed,
        size=rng.uniform(*SIZES.get(concealed, (0.0, 0.0))),
        frequency=_between(rng, 0.7, 3.0),
        damping=_between(rng, 0.05, 0.4),
        motion=rng.uniform(150.0, 300.0),
        # Rows are read one after the other: a shutter shows where the motion crosses them.
        vertical=bool(rng.random() < 0.5) or concealed == ROLLING_SHUTTER,
        rate=rate,
        hold=max(round(rng.uniform(0.04, 0.15) * rate), 1),
        frame_rate=frame_rate,
        frames=int(rng.integers(600, 901)),
        exposure=round(rng.uniform(0.2, 0.8) / frame_rate, 5),
        first=rng.uniform(0.0, 8.0),
        lead=rng.uniform(0.3, 2.0),
        skew=rng.normal(0.0, 1e-4),
        radius=rng.uniform(8.0, 14.0),
        bright=bool(rng.random() < 0.5),
        noise=rng.uniform(1.0, 4.0),
        aside=rng.uniform(-20.0, 20.0),
        wrong=(rng.uniform(0.8, 1.2), rng.uniform(0.8, 1.2), rng.uniform(0.8, 1.2)),
    )


def run(rig: Rig, seed: int, number: int) -> Run:
    """The motion of a rig, of the size that was drawn for it."""
    rng = np.random.default_rng([seed, number, 1])
    # The drive logs a little longer than the clip is.
    samples = ceil((rig.lead + (1.0 + rig.skew) * rig.frames / rig.frame_rate + 0.5) * rig.rate)
    levels = np.repeat(rng.uniform(-1.0, 1.0, ceil(samples / rig.hold)), rig.hold)[:samples]
    parts = ceil(1.0 / (rig.rate * LONGEST_STEP))
    friction = rig.size * float(np.max(np.abs(levels))) if rig.concealed == FRICTION else 0.0
    # With a gain of one; a motion that is larger by some factor has a cubic coefficient that is smaller by its square.
    cubic = 0.0
    for _ in range(ROUNDS if rig.concealed == CUBIC else 1):
        position = integrated(rig, levels, parts, friction, cubic)
        cubic = 0.5 * (cubic + rig.size / float(np.max(np.abs(position))) ** 2) if rig.concealed == CUBIC else 0.0
    gain = rig.motion / float(np.ptp(position))
    return Run(levels, 1.0 / (rig.rate * parts), gain * position, gain)


def integrated(rig: Rig, levels: Array, parts: int, friction: float, cubic: float) -> Array:
    """Position of y'' = u - friction sign(y') - 2 d w y' - w^2 (y + cubic y^3) from rest, shape (M parts + 1,).

    The step in which the motion stops is cut where it does: there the rig stays, or turns round.
    """
    stiffness, drag = (2.0 * pi * rig.frequency) ** 2, 4.0 * pi * rig.frequency * rig.damping
    h = 1.0 / (rig.rate * parts)
    y = v = 0.0
    positions = [y]
    for level in levels.tolist():
        for _ in range(parts):
            if friction == 0.0:
                y, v = _step(y, v, level, stiffness, drag, cubic, h)
            else:
                y, v = _step_with_friction(y, v, level, friction, stiffness, drag, h)
            positions.append(y)
    return np.array(positions)


def _step_with_friction(
    y: float, v: float, level: float, friction: float, stiffness: float, drag: float, h: float
) -> tuple[float, float]:
    """Position and velocity after a step of ``h`` seconds in which the velocity changes its sign once at most."""
    force = level - stiffness * y
    if v == 0.0 and abs(force) <= friction:
        return y, 0.0
    direction = copysign(1.0, v if v != 0.0 else force)
    after = _step(y, v, level - friction * direction, stiffness, drag, 0.0, h)
    if after[1] * direction >= 0.0:
        return after
    # Within a step the velocity is nearly straight.
    before = h * v / (v - after[1])
    y, _ = _step(y, v, level - friction * direction, stiffness, drag, 0.0, before)
    force = level - stiffness * y
    if abs(force) <= friction:
        return y, 0.0
    return _step(y, 0.0, level - copysign(friction, force), stiffness, drag, 0.0, h - before)


def _step(
    y: float, v: float, force: float, stiffness: float, drag: float, cubic: float, h: float
) -> tuple[float, float]:
    """Position and velocity after ``h`` seconds by the classic method of Runge and Kutta."""
    a1 = force - drag * v - stiffness * y * (1.0 + cubic * y * y)
    v2, y2 = v + 0.5 * h * a1, y + 0.5 * h * v
    a2 = force - drag * v2 - stiffness * y2 * (1.0 + cubic * y2 * y2)
    v3, y3 = v + 0.5 * h * a2, y + 0.5 * h * v2
    a3 = force - drag * v3 - stiffness * y3 * (1.0 + cubic * y3 * y3)
    v4, y4 = v + h * a3, y + h * v3
    a4 = force - drag * v4 - stiffness * y4 * (1.0 + cubic * y4 * y4)
    return y + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)


def drive_table(rig: Rig, motion: Run) -> pd.DataFrame:
    """What the drive logs: ``t`` (s) and ``u``."""
    return pd.DataFrame({"t": np.round(np.arange(len(motion.levels)) / rig.rate, DECIMALS), "u": motion.levels})


def simulation(rig: Rig, motion: Run) -> dict[str, Any]:
    """What a user believes of the rig: coefficients off by up to a fifth, and nothing of what is concealed."""
    gain, damping, stiffness = rig.wrong
    speed = 2.0 * pi * rig.frequency
    denominator = [1.0, 2.0 * rig.damping * speed * damping, speed**2 * stiffness]
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [motion.gain * gain], "denominator": denominator}},
        "sensor": {"column": "y" if rig.vertical else "x", "kind": "camera", "exposure": rig.exposure},
        "initial_state": "estimate",
    }
