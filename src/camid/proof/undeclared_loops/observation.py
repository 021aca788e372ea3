"""What the camera reads of a motion at the rows' times."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from .fields import swing
from .motion import Motion
from .rigs import Array
from .setup import Setup

NODES: Array
WEIGHTS: Array
NODES, WEIGHTS = (np.asarray(values, np.float64) for values in np.polynomial.legendre.leggauss(4))


class Path:
    """Positions (y) at any times (s): cubic between the nodes, or straight lines where something follows the plant."""

    def __init__(self, motion: Motion, setup: Setup, begin: float) -> None:
        self.times = begin + motion.step * np.arange(motion.position.size)
        nodes = motion.position
        self.spline: CubicHermiteSpline | None = None
        if setup.behind is None and setup.beside is None:
            self.spline = CubicHermiteSpline(self.times, nodes, motion.velocity)
        if setup.behind is not None:
            nodes = setup.behind(nodes, motion.velocity, motion.step)
        if setup.beside is not None:
            held = np.repeat(motion.arrived, motion.substeps)
            nodes = nodes + swing(np.append(held, held[-1]), motion.step, setup.beside)
        self.nodes = nodes

    def mean(self, ends: Array, length: float) -> Array:
        """Means (y) over ``length`` (s) up to each of ``ends`` (s), of straight lines between the nodes."""
        step = self.times[1] - self.times[0]
        areas = np.concatenate(([0.0], np.cumsum(0.5 * step * (self.nodes[1:] + self.nodes[:-1]))))

        def area(moments: Array) -> Array:
            k = np.clip(((moments - self.times[0]) / step).astype(int), 0, self.nodes.size - 2)
            rest = moments - self.times[k]
            rise = np.where(rest > 0.0, (self.nodes[k + 1] - self.nodes[k]) / step, 0.0)
            return np.asarray(areas[k] + rest * (self.nodes[k] + 0.5 * rise * rest))

        return np.asarray((area(ends) - area(ends - length)) / length)

    def at(self, times: Array) -> Array:
        """Positions (y) at times (s) of any shape; those at the ends beyond them."""
        if self.spline is None:
            return np.asarray(np.interp(times, self.times, self.nodes))
        return np.asarray(self.spline(np.clip(times, self.times[0], self.times[-1])))


def observe(motion: Motion, setup: Setup, start: int, rows: int, noise: Array | None = None) -> Array:
    """Return the readings (y) of ``rows`` rows, the first at time zero; the motion began at row ``start``.

    ``noise`` (y, one for each row) adds before what happens to the readings; without it they are free of noise.
    """
    period = motion.step * motion.substeps
    path, camera = Path(motion, setup, start * period), setup.camera
    stamps: Array = period * np.arange(rows, dtype=np.float64)
    times = stamps if setup.moments is None else setup.moments(stamps)

    def seen(moment: Array) -> Array:
        late = moment - camera.latency
        if camera.exposure == 0.0:
            shown = path.at(late)
            return shown if setup.image is None else setup.image(shown)
        if path.spline is None and setup.image is None:
            return path.mean(late, camera.exposure)
        points = late[:, None] - camera.exposure * 0.5 * (1.0 - NODES)[None, :]
        shown = path.at(points)
        return np.asarray((shown if setup.image is None else setup.image(shown)) @ (0.5 * WEIGHTS))

    reading = seen(times)
    if setup.shutter != 0.0:
        for _ in range(12):
            reading = seen(times + setup.shutter * reading)
    reading = reading if noise is None else reading + noise
    if setup.readings is not None:
        reading = setup.readings(reading, stamps)
    return reading + camera.offset
