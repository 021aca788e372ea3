"""Make ``pendulum.mp4``: a red ball on a string that swings past a wall, with dry friction where the string is held.

The motion is exact between the turning points, the pictures are means over the exposure, and nothing of camid is used.
Run it in this folder: ``python make_clip.py``; it needs NumPy and PyAV (``pip install 'camid[video]'``). Another
version of the encoder may write other bytes.
"""

from math import exp, pi, sqrt

import av
import numpy as np
from numpy.typing import NDArray

SEED = 20261122
WIDTH, HEIGHT = 240, 96  # px
FRAMES, RATE = 360, 30  # 12 s
INSTANTS = 16  # of an exposure, which lasts for the whole frame
CENTRE, STRING, RADIUS = 119.5, 420.0, 8.0  # px: the ball's rest, the length of its string, its radius
LOWEST = 74.0  # px from the upper edge
FREQUENCY, DAMPING = 4.1, 0.006  # natural frequency in rad/s and damping ratio
FRICTION = 1.1  # px that the friction can hold the ball beside its rest
START = 88.0  # px from its rest at time zero, let go
BALL, WALL = (196.0, 44.0, 40.0), (206.0, 208.0, 210.0)
NOISE = 1.2  # grey levels


def displacements(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of the ball from its rest in px, at times in s.

    Between two turning points dry friction is a constant force: the ball swings about a rest that is moved by
    FRICTION, with viscous damping, until a turning point lies so near that the friction holds it.
    """
    damped = FREQUENCY * sqrt(1.0 - DAMPING**2)
    half = pi / damped
    result = np.empty_like(times)
    edge, begun = START, 0.0
    while begun <= times[-1]:
        inside = (times >= begun) & (times < begun + half)
        since = times[inside] - begun
        rest = FRICTION if edge > 0.0 else -FRICTION
        if abs(edge) <= FRICTION:
            result[times >= begun] = edge
            break
        phase = DAMPING * FREQUENCY / damped
        swing = np.cos(damped * since) + phase * np.sin(damped * since)
        result[inside] = rest + (edge - rest) * np.exp(-DAMPING * FREQUENCY * since) * swing
        edge = rest - (edge - rest) * exp(-DAMPING * FREQUENCY * half)
        begun += half
    return result


def picture(xs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean of the pictures with the ball at these positions, shape (HEIGHT, WIDTH, 3)."""
    row, column = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    covered = np.zeros((HEIGHT, WIDTH))
    for x in xs:
        y = LOWEST - (STRING - sqrt(STRING**2 - x**2))
        distance = np.hypot(column - CENTRE - x, row - y)
        covered += np.clip(RADIUS + 0.5 - distance, 0.0, 1.0) / len(xs)
    return np.asarray(WALL) + covered[..., None] * (np.asarray(BALL) - np.asarray(WALL))


def main() -> None:
    """Write ``pendulum.mp4`` into the current folder."""
    generator = np.random.default_rng(SEED)
    # A frame is delivered when its exposure ends.
    instants = (np.arange(FRAMES)[:, None] + (np.arange(INSTANTS) + 0.5) / INSTANTS) / RATE
    xs = displacements(instants.ravel()).reshape(instants.shape)
    with av.open("pendulum.mp4", "w") as container:
        # Every frame is coded by itself, or the encoder would repeat frames where the ball turns round.
        stream = container.add_stream("libx264", rate=RATE, options={"crf": "22", "x264-params": "keyint=1"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for k in range(FRAMES):
            noisy = picture(xs[k]) + NOISE * generator.standard_normal((HEIGHT, WIDTH, 1))
            frame = av.VideoFrame.from_ndarray(np.clip(np.rint(noisy), 0, 255).astype(np.uint8), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


if __name__ == "__main__":
    main()
