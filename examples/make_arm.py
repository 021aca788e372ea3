"""Make ``arm_clip.mp4`` and ``arm_drive.csv``: a red marker on a spring arm that a motor swings, filmed.

The marker sits at the end of a leaf spring that a voice coil pushes from side to side. The drive logs the voltage by a
clock of its own, which has run before the camera starts and runs a little faster. Where the arm is guided there is dry
friction, which ``arm_simulation.yaml`` does not know. The motion is integrated here, the pictures are means over the
exposure, and nothing of camid is used. Run it in this folder: ``python make_arm.py``; it needs NumPy and PyAV
(``pip install 'camid[video]'``). Another version of the encoder may write other bytes.
"""

import csv
from math import copysign

import av
import numpy as np
from numpy.typing import NDArray

SEED = 20261125
# The drive: a voltage that is held between two entries of the log.
PERIOD, ENTRIES = 0.01, 2200  # s; 22 s
LEVELS = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)  # V
# The arm, in mm and V: y'' = GAIN (u - friction) - DAMPING y' - STIFFNESS y
GAIN, DAMPING, STIFFNESS = 600.0, 2.0, 110.0
FRICTION = 0.25  # V that the friction takes from the motor, whatever the speed
STEP = 50e-6  # s, of the integrator
# The camera: a frame is delivered when its exposure ends.
RATE, FRAMES, EXPOSURE = 50, 1000, 0.01  # 20 s
INSTANTS = 8  # of an exposure
STARTED, FASTER = 1.25, 80e-6  # time of the drive in s when the clip starts, and by how much its clock is faster
# The picture.
WIDTH, HEIGHT = 240, 80  # px
MILLIMETRES = 0.5  # per px
CENTRE, ARM, RADIUS = 119.5, 400.0, 7.0  # px: where the marker rests, the length of the arm, the radius of the marker
LOWEST = 52.0  # px from the upper edge
MARKER, WALL = (196.0, 44.0, 40.0), (206.0, 208.0, 210.0)
NOISE = 1.0  # grey levels


def positions(volts: list[float]) -> NDArray[np.float64]:
    """Position in mm after each step of the integrator, of an arm that starts at rest, at the centre.

    Semi-implicit Euler. The arm sticks when its speed would change sign while the other forces stay below the friction.
    """
    steps = round(PERIOD / STEP)
    found = np.empty(len(volts) * steps)
    position = speed = 0.0
    for k, volt in enumerate(volts):
        for j in range(steps):
            drive = GAIN * volt - STIFFNESS * position  # mm/s²
            before = speed
            if speed == 0.0 and abs(drive) <= GAIN * FRICTION:
                speed = 0.0
            else:
                opposing = copysign(GAIN * FRICTION, speed if speed != 0.0 else drive)
                speed += STEP * (drive - DAMPING * speed - opposing)
                if before * speed < 0.0:
                    speed = 0.0
            position += STEP * speed
            found[k * steps + j] = position
    return found


def picture(xs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean of the pictures with the marker at these distances from the centre in px, shape (HEIGHT, WIDTH, 3)."""
    row, column = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    covered = np.zeros((HEIGHT, WIDTH))
    for x in xs:
        y = LOWEST - (ARM - np.sqrt(ARM**2 - x**2))
        covered += np.clip(RADIUS + 0.5 - np.hypot(column - CENTRE - x, row - y), 0.0, 1.0) / len(xs)
    return np.asarray(WALL) + covered[..., None] * (np.asarray(MARKER) - np.asarray(WALL))


def main() -> None:
    """Write ``arm_clip.mp4`` and ``arm_drive.csv`` into the current folder."""
    generator = np.random.default_rng(SEED)
    volts: list[float] = []
    while len(volts) < ENTRIES:
        volts += [float(generator.choice(LEVELS))] * int(generator.integers(8, 26))
    volts = volts[:ENTRIES]
    with open("arm_drive.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time", "voltage"])
        writer.writerows([f"{k * PERIOD:.2f}", f"{volt:g}"] for k, volt in enumerate(volts))

    pixels = positions(volts) / MILLIMETRES
    times = STEP * np.arange(1, len(pixels) + 1)
    with av.open("arm_clip.mp4", "w") as container:
        # Every frame is coded by itself, or the encoder would repeat frames where the arm stands still.
        stream = container.add_stream("libx264", rate=RATE, options={"crf": "22", "x264-params": "keyint=1"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for k in range(FRAMES):
            exposed = k / RATE - EXPOSURE * (np.arange(INSTANTS) + 0.5) / INSTANTS
            xs = np.interp(STARTED + (1.0 + FASTER) * exposed, times, pixels)
            noisy = picture(xs) + NOISE * generator.standard_normal((HEIGHT, WIDTH, 1))
            frame = av.VideoFrame.from_ndarray(np.clip(np.rint(noisy), 0, 255).astype(np.uint8), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


if __name__ == "__main__":
    main()
