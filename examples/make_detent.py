"""Make ``detent.csv``: the slide of ``slide.csv`` with a detent beside its way, and no dry friction.

A sprung ball rolls over a notch: it pulls the slide to one place, and is nothing away from it. The integrator is this
file's own and shares nothing with camid, so that an example proves something. Run it in this folder: ``python
make_detent.py``. Its seed is fixed, so it always writes the same file.
"""

import csv
from math import exp
from random import Random

SEED = 20261123
PERIOD = 0.02  # s, 50 frames per second; the camera is exposed for the whole of it
FRAMES = 1500
STEPS = 200  # of the integrator, per frame
LEVELS = (-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5)  # V
FRAMES_PER_LEVEL = 6
GAIN, DAMPING, STIFFNESS = 92.0, 2.4, 110.0  # of the position in mm: y'' = GAIN (u - f) - DAMPING y' - STIFFNESS y
PULL, PLACE, WIDTH = 0.40, 1.20, 0.45  # V, mm, mm
NOISE = 0.01  # mm


def detent(position: float) -> float:
    """Force in V of the ball on a slide at a position in mm; positive where it pulls to smaller ones."""
    away = (position - PLACE) / WIDTH
    return PULL * away * exp(-away * away)


def positions(inputs: list[float]) -> list[float]:
    """Mean position over each exposure in mm, of a slide that starts at rest: semi-implicit Euler steps of 100 µs."""
    step = PERIOD / STEPS
    position = velocity = 0.0
    means = [0.0]  # the exposure of the first frame ends when the input starts
    for level in inputs[:-1]:
        total = 0.0
        for _ in range(STEPS):
            velocity += step * (GAIN * (level - detent(position)) - DAMPING * velocity - STIFFNESS * position)
            total += 0.5 * position
            position += step * velocity
            total += 0.5 * position
        means.append(total / STEPS)
    return means


def main() -> None:
    """Write ``detent.csv`` into the current folder."""
    random = Random(SEED)
    levels = [random.choice(LEVELS) for _ in range(FRAMES // FRAMES_PER_LEVEL)]
    inputs = [level for level in levels for _ in range(FRAMES_PER_LEVEL)]
    outputs = [mean + random.gauss(0.0, NOISE) for mean in positions(inputs)]
    with open("detent.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t", "u", "y"])
        for k, (u, y) in enumerate(zip(inputs, outputs, strict=True)):
            writer.writerow([f"{PERIOD * k:.2f}", f"{u:g}", f"{y:.4f}"])


if __name__ == "__main__":
    main()
