"""Make ``clip.csv`` and ``drive.csv``: the slide of ``make_recording.py`` without friction, on two clocks.

The drive logs what it was told 50 times a second by its clock; the camera takes 50.02 frames a second by its own, which
started 3.2 s later and runs 80 millionths too fast. The integrator is this file's own and shares nothing with
camid. Run it in this folder: ``python make_two_clocks.py``. Its seed is fixed, so it always writes the same files.
"""

import csv
from random import Random

SEED = 20261123
PERIOD = 0.02  # s, of the drive
SAMPLES = 900
STEPS = 400  # of the integrator, per sample
LEVELS = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)  # V
SAMPLES_PER_LEVEL = 4
GAIN, DAMPING, STIFFNESS = 92.0, 2.4, 110.0  # of the position in mm: y'' = GAIN u - DAMPING y' - STIFFNESS y
NOISE = 0.02  # mm
OFFSET, SKEW = 3.2, 80e-6  # time of the drive = OFFSET + (1 + SKEW) · time of the clip
FRAME, EXPOSURE = 1.0 / 50.02, 0.008  # s by the clock of the clip, and s
FRAMES = 700


def integrals(inputs: list[float]) -> list[float]:
    """Integral of the position in mm s after each step of the integrator, of a slide that starts at rest."""
    step = PERIOD / STEPS
    position = velocity = integral = 0.0
    found = [0.0]
    for level in inputs:
        for _ in range(STEPS):
            # The midpoint rule is exact to the third order in the step of 50 µs.
            middle_velocity = velocity + 0.5 * step * (GAIN * level - DAMPING * velocity - STIFFNESS * position)
            middle = position + 0.5 * step * velocity
            velocity += step * (GAIN * level - DAMPING * middle_velocity - STIFFNESS * middle)
            position += step * middle_velocity
            integral += step * middle
            found.append(integral)
    return found


def integral_at(found: list[float], time: float) -> float:
    """Integral of the position at a time of the drive in s."""
    place = time / (PERIOD / STEPS)
    row = int(place)
    return found[row] + (place - row) * (found[row + 1] - found[row])


def main() -> None:
    """Write ``clip.csv`` and ``drive.csv`` into the current folder."""
    random = Random(SEED)
    levels = [random.choice(LEVELS) for _ in range(SAMPLES // SAMPLES_PER_LEVEL)]
    inputs = [level for level in levels for _ in range(SAMPLES_PER_LEVEL)]
    found = integrals(inputs)
    with open("drive.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time", "u"])
        writer.writerows([f"{k * PERIOD:.2f}", f"{level:g}"] for k, level in enumerate(inputs))
    with open("clip.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t", "y"])
        for frame in range(FRAMES):
            time = frame * FRAME
            delivered = OFFSET + (1.0 + SKEW) * time
            mean = (integral_at(found, delivered) - integral_at(found, delivered - EXPOSURE)) / EXPOSURE
            writer.writerow([f"{time:.6f}", f"{mean + random.gauss(0.0, NOISE):.4f}"])


if __name__ == "__main__":
    main()
