"""Make ``slide.csv``: a slide on a spring, driven by a motor and filmed by a camera, with dry friction in its guide.

The integrator is this file's own and shares nothing with camid, so that an example proves something. Run it in this
folder: ``python make_recording.py``. Its seed is fixed, so it always writes the same file.
"""

import csv
from math import copysign, exp
from random import Random

SEED = 20261122
PERIOD = 0.02  # s, 50 frames per second; the camera is exposed for the whole of it
FRAMES = 1500
STEPS = 400  # of the integrator, per frame
LEVELS = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)  # V
FRAMES_PER_LEVEL = 6
GAIN, DAMPING, STIFFNESS = (
    92.0,
    2.4,
    110.0,
)  # of the position in mm: y'' = GAIN (u - friction) - DAMPING y' - STIFFNESS y
COULOMB, BREAKAWAY, STRIBECK_VELOCITY = 0.30, 0.62, 2.0  # V, V, mm/s
NOISE = 0.01  # mm


def friction_at(speed: float) -> float:
    """Friction in V of a slide that moves at a speed in mm/s."""
    return COULOMB + (BREAKAWAY - COULOMB) * exp(-((speed / STRIBECK_VELOCITY) ** 2))


def positions(inputs: list[float]) -> list[float]:
    """Mean position over each exposure in mm, of a slide that starts at rest.

    Semi-implicit Euler steps of 50 µs. The slide sticks when its velocity would change sign while the other forces stay
    below the breakaway force.
    """
    step = PERIOD / STEPS
    position = velocity = 0.0
    means = [0.0]  # the exposure of the first frame ends when the input starts
    for level in inputs[:-1]:
        total = 0.0
        for _ in range(STEPS):
            drive = GAIN * level - STIFFNESS * position  # mm/s²
            if velocity == 0.0:
                sticks = abs(drive) <= GAIN * BREAKAWAY
                opposing = copysign(GAIN * BREAKAWAY, drive)
            else:
                sticks = False
                opposing = copysign(GAIN * friction_at(abs(velocity)), velocity)
            before = velocity
            velocity = 0.0 if sticks else velocity + step * (drive - DAMPING * velocity - opposing)
            if before * velocity < 0.0:
                velocity = 0.0
            total += 0.5 * position
            position += step * velocity
            total += 0.5 * position
        means.append(total / STEPS)
    return means


def main() -> None:
    """Write ``slide.csv`` into the current folder."""
    random = Random(SEED)
    levels = [random.choice(LEVELS) for _ in range(FRAMES // FRAMES_PER_LEVEL)]
    inputs = [level for level in levels for _ in range(FRAMES_PER_LEVEL)]
    with open("slide.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t", "u", "y"])
        for k, (level, position) in enumerate(zip(inputs, positions(inputs), strict=True)):
            writer.writerow([f"{k * PERIOD:.2f}", f"{level:g}", f"{position + random.gauss(0.0, NOISE):.4f}"])


if __name__ == "__main__":
    main()
