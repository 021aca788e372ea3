"""The whole chain of a rig: from the command, or the reference of a controller, to measured values without noise."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .integrator import integrate
from .laws import Chain, Law, Sensing, build
from .quantities import Actuator, Force
from .rigs import Matrices, Rig
from .trajectory import Trajectory

Array = np.ndarray[Any, np.dtype[np.float64]]
AFTER = 16  # samples simulated beyond the last one, for clocks that run ahead
POINTS = 32  # within an exposure, where the mean is not that of the motion itself


@dataclass(frozen=True)
class Run:
    """What one run yields: times (s), measured output without noise (y), command (u), each a value a sample."""

    time: Array
    output: Array
    command: Array
    trajectory: Trajectory
    sensing: Sensing

    def compared(self, rig: Rig) -> Array:
        """Return what a fit compares: the output, or in a closed loop the control (u)."""
        return self.command if rig.controller is not None else self.output


def _with_modes(chain: Chain, matrices: Matrices) -> Matrices:
    """Return the plant with a mode in series (before it) or in parallel."""
    system, inlet, outlet, _ = matrices
    for frequency, damping in chain.series:
        order = inlet.size
        wider = np.zeros((order + 2, order + 2))
        wider[:order, :order] = system
        wider[:order, order] = inlet * frequency**2
        wider[order, order + 1] = 1.0
        wider[order + 1, order:] = -(frequency**2), -2.0 * damping * frequency
        system, inlet = wider, np.concatenate([np.zeros(order + 1), [1.0]])
        outlet = np.concatenate([outlet, [0.0, 0.0]])
    for gain, frequency, damping in chain.parallel:
        order = inlet.size
        wider = np.zeros((order + 2, order + 2))
        wider[:order, :order] = system
        wider[order, order + 1] = 1.0
        wider[order + 1, order:] = -(frequency**2), -2.0 * damping * frequency
        system, inlet = wider, np.concatenate([inlet, [0.0, 1.0]])
        outlet = np.concatenate([outlet, [gain * frequency**2, 0.0]])
    return system, inlet, outlet, outlet @ system


def _substeps(rig: Rig, chain: Chain) -> int:
    """Return how many steps a sample takes: short beside the fastest motion."""
    fastest = 1.0 / rig.pace
    if chain.force[Force.CEILING_ON] > 0.0:
        return 32
    if "two masses" in rig.traits:
        fastest = float(np.abs(np.roots(rig.denominator)).max())
    if chain.actuator[Actuator.LAG] > 0.0:
        fastest = max(fastest, 0.5 / float(chain.actuator[Actuator.LAG]))
    if chain.force[Force.LUGRE_STIFFNESS] > 0.0:
        inertia = 1.0 / rig.numerator[0] if rig.pendulum is None else 1.0 / (rig.pendulum[2] * rig.pendulum[0] ** 2)
        fastest = max(fastest, 0.5 * float(np.sqrt(chain.force[Force.LUGRE_STIFFNESS] / inertia)))
    for mode in (*chain.series, *((frequency, damping) for _, frequency, damping in chain.parallel)):
        fastest = max(fastest, mode[0])
    return int(np.clip(np.ceil(rig.period * fastest / 0.12), 8, 100))


def _disturbance(chain: Chain, start: float, step: float, count: int) -> tuple[Array, Array]:
    """Return the disturbance (u) at start, middle and end of each step, and the impulses (u s) at their starts."""
    first = start + step * np.arange(count)
    times = first[:, None] + step * np.array([0.0, 0.5, 1.0])
    force = np.zeros((count, 3))
    for amplitude, frequency, phase in chain.periodic:
        force += amplitude * np.sin(frequency * times + phase)
    for size, onset, rise in chain.steps:
        if rise > 0.0:
            force += size * np.clip((times - onset) / rise, 0.0, 1.0)
        else:
            # whole steps, so that a step never begins within one of the integration
            force += size * (first >= onset - 0.5 * step)[:, None]
    # nothing acts before the first sample
    force[first < chain.rig.start - 0.5 * step] = 0.0
    impulses = np.zeros(count)
    for size, time in chain.impulses:
        impulses[round((time - start) / step)] += size
    return force, impulses


def substep(rig: Rig) -> float:
    """Return the time (s) between two steps of the integration of a rig without modes."""
    return rig.period / _substeps(rig, build(rig, []))


def _given(chain: Chain, drive: Array) -> Array:
    """Return command or reference of all samples that are simulated: zero before the first, held after the last."""
    values = drive.copy()
    share, seed = chain.missed
    if share > 0.0:
        heard = np.random.default_rng(seed).random(values.size) >= share
        heard[0] = True
        values = values[np.maximum.accumulate(np.where(heard, np.arange(values.size), 0))]
    lead = 0 if chain.rig.controller is not None else chain.rig.lead
    return np.concatenate([np.zeros(lead), values, np.full(AFTER, values[-1])])


def run(rig: Rig, laws: list[Law], drive: Array) -> Run:
    """Run a rig with laws; ``drive`` is its command (u), or the reference (y) of its controller, one value a sample."""
    chain = build(rig, laws)
    substeps = _substeps(rig, chain)
    values = _given(chain, drive)
    lead = values.size - drive.size - AFTER
    start = rig.start - lead * rig.period
    matrices, through = rig.matrices()
    matrices = _with_modes(chain, matrices)
    initial = np.zeros(matrices[1].size)
    initial[: rig.order] = rig.state()
    disturbance, impulses = _disturbance(chain, start, rig.period / substeps, values.size * substeps)
    closed = rig.controller is not None
    plant = np.vstack(matrices)
    motion, command = integrate(
        start, rig.period, substeps, np.zeros(values.size) if closed else values, lead, chain.straight,
        values if closed else np.zeros(0), np.array(rig.controller or ()), disturbance, impulses, initial,
        plant, through, chain.actuator, chain.force, chain.friction,
    )  # fmt: skip
    trajectory = Trajectory(start, rig.period / substeps, motion)
    time: Array = rig.start + rig.period * np.arange(drive.size, dtype=np.float64)
    return Run(time, observe(trajectory, time, chain.sensing), command[lead:-AFTER], trajectory, chain.sensing)


def _imaged(position: Array, sensing: Sensing, time: Array) -> Array:
    """Return where positions (y) appear at times (s)."""
    amplitude, period, phase, second = sensing.eccentricity
    if amplitude != 0.0:
        angle = 2.0 * np.pi * position / period
        wave = np.sin(angle + phase) - np.sin(phase)
        wave = wave + second * (np.sin(2.0 * (angle + phase)) - np.sin(2.0 * phase))
        position = position + amplitude * wave
    if sensing.obliqueness != (0.0, 0.0):
        position = position / (1.0 + sensing.obliqueness[0] * position + sensing.obliqueness[1] * position**2)
    if sensing.radial != (0.0, 0.0):
        squared = position * position
        position = position * (1.0 + squared * (sensing.radial[0] + sensing.radial[1] * squared))
    if sensing.breathing[0] != 0.0:
        position = position * (1.0 + sensing.breathing[0] * np.sin(sensing.breathing[1] * time))
    return np.asarray(position)


def _seen(trajectory: Trajectory, end: Array, sensing: Sensing) -> Array:
    """Return what exposures that end at times (s) see (y), before the offset."""
    bent = sensing.breathing[0] != 0.0 or sensing.eccentricity[0] != 0.0
    bent = bent or sensing.radial != (0.0, 0.0) or sensing.obliqueness != (0.0, 0.0)
    if not bent and not sensing.speed_weighted:
        return trajectory.mean(end, sensing.exposure)
    times = trajectory.within(end, sensing.exposure, POINTS)
    seen = _imaged(trajectory.position(times), sensing, times)
    if sensing.speed_weighted and sensing.exposure > 0.0:
        weights = np.abs(trajectory.velocity(times))
        total = weights.sum(axis=1)
        # a body that does not move is seen where it is
        weighted = (weights * seen).sum(axis=1) / np.where(total > 0.0, total, 1.0)
        return np.asarray(np.where(total > 0.0, weighted, seen[:, -1]))
    return np.asarray(seen.mean(axis=1))


def observe(trajectory: Trajectory, time: Array, sensing: Sensing, jitter: Array | None = None) -> Array:
    """Return the values (y) that a sensor delivers at times (s), without noise; ``jitter`` (s) shifts the exposures."""
    end = time * (1.0 + sensing.skew) - sensing.latency
    if jitter is not None:
        end = end + jitter
    seen = _seen(trajectory, end, sensing)
    if sensing.rolling != 0.0:
        # the marker's own position says when its row is read
        for _ in range(12):
            seen = _seen(trajectory, end + sensing.rolling * seen, sensing)
    rate, memory = sensing.drift
    elapsed = time if memory <= 0.0 else memory * (1.0 - np.exp(-time / memory))
    seen = seen + sensing.offset + rate * elapsed + sensing.bump[0] * (time >= sensing.bump[1])
    if sensing.absolute:
        # the sensor measures, and then loses the sign: the distance from its own zero, which is not that of the rig
        seen = np.abs(seen)
    return np.asarray(np.clip(seen, *sensing.clipping))
