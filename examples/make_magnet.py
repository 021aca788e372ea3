"""Make ``magnet.csv`` and ``magnet_again.csv``: a slide on a spring that passes a magnet, filmed twice.

The integrator is this file's own and shares nothing with camid, so that an example proves something. Run it in this
folder: ``python make_magnet.py``. Its seeds are fixed, so it always writes the same files.
"""

import csv
from math import exp
from random import Random

SEEDS = {"magnet.csv": 20261123, "magnet_again.csv": 20261124}
PERIOD = 0.02  # s, 50 frames per second; the camera is exposed for the whole of it
FRAMES = 1500
STEPS = 20  # of the integrator, per frame
LEVELS = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)  # V
FRAMES_PER_LEVEL = 6
GAIN, DAMPING, STIFFNESS = 95.0, 4.0, 105.0  # of the position in mm: y'' = GAIN (u - pull) - DAMPING y' - STIFFNESS y
PULL, PLACE, WIDTH = 0.5, 1.8, 0.5  # V, mm, mm
NOISE = 0.01  # mm


def pull(position: float) -> float:
    """Force in V that the magnet exerts towards its place, at a position in mm."""
    away = (position - PLACE) / WIDTH
    return PULL * away * exp(-(away**2))


def acceleration(position: float, velocity: float, level: float) -> float:
    """Acceleration of the slide in mm/s²."""
    return GAIN * (level - pull(position)) - DAMPING * velocity - STIFFNESS * position


def positions(inputs: list[float]) -> list[float]:
    """Mean position over each exposure in mm, of a slide that starts at rest; Runge-Kutta steps of 1 ms."""
    h = PERIOD / STEPS
    y = v = 0.0
    means = [0.0]  # the exposure of the first frame ends when the input starts
    for level in inputs[:-1]:
        total = 0.0
        for _ in range(STEPS):
            before = y
            a1 = acceleration(y, v, level)
            y2, v2 = y + 0.5 * h * v, v + 0.5 * h * a1
            a2 = acceleration(y2, v2, level)
            y3, v3 = y + 0.5 * h * v2, v + 0.5 * h * a2
            a3 = acceleration(y3, v3, level)
            y4, v4 = y + h * v3, v + h * a3
            a4 = acceleration(y4, v4, level)
            y, v = y + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            total += 0.5 * (before + y)
        means.append(total / STEPS)
    return means


def main() -> None:
    """Write both recordings into the current folder."""
    for name, seed in SEEDS.items():
        random = Random(seed)
        levels = [random.choice(LEVELS) for _ in range(FRAMES // FRAMES_PER_LEVEL)]
        inputs = [level for level in levels for _ in range(FRAMES_PER_LEVEL)]
        with open(name, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["t", "u", "y"])
            for k, (level, position) in enumerate(zip(inputs, positions(inputs), strict=True)):
                writer.writerow([f"{k * PERIOD:.2f}", f"{level:g}", f"{position + random.gauss(0.0, NOISE):.4f}"])


if __name__ == "__main__":
    main()
