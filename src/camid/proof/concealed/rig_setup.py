"""What is built into a rig for one recording: machine, input path, camera and noise, before anything is simulated."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camid.proof.concealed.machine_integrator import Segments
from camid.proof.concealed.rig import Rig

Array = NDArray[np.float64]
InputMap = Callable[[Segments, float], Segments]
# Positions in the output's units to distorted positions and their derivative.
PositionMap = Callable[[Array], tuple[Array, Array]]
# Frame values, their times in s and a source of random numbers (None: leave out what is random) to frame values.
FrameMap = Callable[[Array, Array, np.random.Generator | None], Array]
NoiseColour = Callable[[np.random.Generator, int], Array]

# Frames that are simulated after the last one, for windows that reach beyond it.
TAIL = 10
# Frames before the first, and those of a machine that is moving when the recording begins.
LEAD, MOVING_LEAD = 8, 80


@dataclass
class Setup:
    """A rig as it really is.

    Attributes
    ----------
    rig : Rig
    period : float
        s.
    frames : int
    exposure, latency : float
        True ones in s; an exposure of zero is an instant sensor, and a latency below zero one whose command is late.
    moving : bool
        Whether an input acted before the first frame.
    parameters : ndarray
        Of the integrator.
    hold : {"zoh", "foh", "band-limited"}
    transport_delay : float
        s.
    input_maps : list of callable
        Applied in turn to the pieces of the input; they also take the period.
    kicks : list of (time in s, jump of the velocity in m/s)
    rolling, skew, jitter : float
        Time per unit of the output in s, relative error of the camera's clock, standard deviation in s.
    load_map : callable, optional
        From the machine's position at every instant to that of the load which is seen.
    position_map : callable, optional
        Distortion of the position at every instant.
    speed_weight : callable, optional
        From speeds, in the output's units per second, to weights of the positions in the average.
    before_noise, after_noise : list of callable
        Applied to the frame values.
    colour : callable, optional
        Draws noise of unit variance; white without it.
    pickup : float
        Of the command in the reading, in the output's units per V.
    partial_repeats : float
        Fraction of frames that are cut short and then delivered twice.
    refinement : int
        Divides the integrator's step where a force or a reading has kinks that no step ends at.
    """

    rig: Rig
    period: float
    frames: int
    exposure: float
    latency: float
    moving: bool
    parameters: Array
    hold: str = "zoh"
    transport_delay: float = 0.0
    input_maps: list[InputMap] = field(default_factory=list)
    kicks: list[tuple[float, float]] = field(default_factory=list)
    rolling: float = 0.0
    skew: float = 0.0
    jitter: float = 0.0
    load_map: PositionMap | None = None
    position_map: PositionMap | None = None
    speed_weight: Callable[[Array], Array] | None = None
    before_noise: list[FrameMap] = field(default_factory=list)
    after_noise: list[FrameMap] = field(default_factory=list)
    colour: NoiseColour | None = None
    pickup: float = 0.0
    partial_repeats: float = 0.0
    refinement: int = 1

    @property
    def first(self) -> int:
        """The first of a command's samples that is recorded."""
        return MOVING_LEAD if self.moving else 0

    def copy(self) -> Setup:
        """A setup that can be changed without changing this one."""
        twin = copy.copy(self)
        twin.parameters = self.parameters.copy()
        for name in ("input_maps", "kicks", "before_noise", "after_noise"):
            setattr(twin, name, list(getattr(self, name)))
        return twin

    @property
    def lead(self) -> int:
        """Frames that are simulated before the first."""
        return MOVING_LEAD if self.moving else LEAD

    @property
    def input_length(self) -> int:
        """Input samples that are needed: those before the first frame only where the machine is moving."""
        return self.frames + TAIL + (MOVING_LEAD if self.moving else 0)


@dataclass(frozen=True)
class Effect:
    """A law that is built into a setup, except for its strength.

    Attributes
    ----------
    identity, place, law : str
        The law is "catalogue", or the name of another law that goes by the same identity.
    apply : callable
        Changes a setup for a strength, without unit.
    parameters : callable
        From the strength to the truth's parameters in the units of u, y and s.
    start, high : float
        First guess and largest value of the strength.
    repeatable : bool
        Whether another recording of the rig shows the same.
    noise_like : bool
        Whether its size is that of what it adds to the recording, instead of what the model cannot follow.
    fixed : bool
        Whether there is no strength to choose.
    """

    identity: str
    place: str
    law: str
    apply: Callable[[Setup, float], None]
    parameters: Callable[[float], dict[str, float | str | None]]
    start: float = 0.1
    high: float = 1e3
    repeatable: bool = True
    noise_like: bool = False
    fixed: bool = False


@dataclass(frozen=True)
class Context:
    """What an effect may know of the recording that it is built into.

    Attributes
    ----------
    rig : Rig
    period : float
        s.
    frames : int
    command : ndarray
        Input in V that will be applied.
    output : ndarray, shape (N,)
        What the camera sees without the effect, in the output's units.
    latency, exposure : float
        Declared, in s.
    """

    rig: Rig
    period: float
    frames: int
    command: Array
    output: Array
    exposure: float
    latency: float

    @property
    def stroke(self) -> float:
        """Standard deviation of the position in m."""
        return float(np.std(self.output)) / self.rig.output_scale

    @property
    def reach(self) -> float:
        """Largest distance from rest in m."""
        return float(np.max(np.abs(self.output))) / self.rig.output_scale

    @property
    def speed(self) -> float:
        """About the standard deviation of the velocity in m/s."""
        step = np.std(np.diff(self.output)) / self.period
        return float(step) / self.rig.output_scale

    @property
    def drive(self) -> float:
        """Standard deviation of the input in V."""
        return float(np.std(self.command))

    @property
    def peak(self) -> float:
        """Largest input in V, either sign."""
        return float(np.max(np.abs(self.command)))

    @property
    def duration(self) -> float:
        """Of the recording in s."""
        return self.frames * self.period
