"""Marker positions from a video: frames per second and error, against the plain OpenCV pipeline on whole frames."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import av
import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.report import Goal, Report, number
from benchmarks.task import generator
from benchmarks.timing import alternate
from camid.images.forming import FrameFormat, Marker, circular_path, expose
from camid.tracking.options import Options
from camid.tracking.track import track_video

Array = NDArray[np.float64]

HEIGHT, WIDTH, FRAMES, RATE = 480, 640, 300, 60
CENTRE, PATH_DIAMETER, FREQUENCY, DIAMETER = (319.5, 239.5), 300.0, 0.7, 30.0
# Red, green and blue of the marker and of the wall.
MARKER, WALL, NOISE = (200.0, 30.0, 40.0), 200.0, 2.0
SUB_EXPOSURE = 0.5  # of the period
SEED_KEY = 3  # of the stream for the pixels
ROUNDS = 5
THRESHOLD, GREY_THRESHOLD = 0.2, 20.0
FASTEST_CAMERA, TIMES_FASTER = 60.0, 10.0


def render(file: Path) -> Array:
    """Write the clip as H.264 and return the mean positions over the exposures, shape (FRAMES, 2)."""
    noise = generator(SEED_KEY)
    path = circular_path(CENTRE, PATH_DIAMETER, FREQUENCY)
    exposure = SUB_EXPOSURE / RATE
    shape = FrameFormat(HEIGHT, WIDTH)
    colour = np.array(MARKER) - WALL
    with av.open(str(file), "w") as container:
        stream = container.add_stream("libx264", rate=RATE, options={"crf": "20", "preset": "medium"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for k in range(FRAMES):
            coverage = expose(path, k / RATE, exposure, Marker(DIAMETER, 1.0), shape)
            image = WALL + coverage[:, :, None] * colour
            image += NOISE * noise.standard_normal((HEIGHT, WIDTH, 3), np.float32)
            pixels = np.clip(np.rint(image), 0.0, 255.0).astype(np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        container.mux(stream.encode())
    fine = path((np.arange(FRAMES * 64) // 64 + SUB_EXPOSURE * (np.arange(FRAMES * 64) % 64 + 0.5) / 64) / RATE)
    return fine.reshape(FRAMES, 64, 2).mean(axis=1)


def by_camid(file: Path, **options: object) -> Array:
    """All of it: decoding, finding, following, both centroids, standard deviations, quality, copies."""
    return track_video(file, Options(**options)).table[["x", "y"]].to_numpy()  # type: ignore[arg-type]


def by_opencv(file: Path, measure: Callable[[NDArray[np.uint8]], dict[str, float]]) -> Array:
    """Positions of the centre of mass that ``measure`` finds in whole grey frames."""
    capture = cv2.VideoCapture(str(file), cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, 1])
    positions = []
    while True:
        read, frame = capture.read()
        if not read:
            break
        moments = measure(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
        positions.append((moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]))
    capture.release()
    return np.array(positions)


def edges(grey: NDArray[np.uint8]) -> dict[str, float]:
    """Sobel filter, threshold, moments."""
    horizontal, vertical = (cv2.Sobel(grey, cv2.CV_32F, *order) for order in ((1, 0), (0, 1)))
    gradient = cv2.magnitude(horizontal, vertical)
    limit = THRESHOLD * cv2.norm(gradient, cv2.NORM_INF)
    return cv2.moments(cv2.threshold(gradient, limit, 1.0, cv2.THRESH_BINARY)[1])


def darkness(grey: NDArray[np.uint8]) -> dict[str, float]:
    """Threshold below the wall, moments of the grey levels; the wall's level is given."""
    level = cv2.subtract(np.full_like(grey, int(WALL)), grey)
    return cv2.moments(cv2.threshold(level, GREY_THRESHOLD, 0.0, cv2.THRESH_TOZERO)[1])


def run() -> Report:
    """Measure."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "clip.mp4"
        truth = render(file)
        tools: dict[str, Callable[[], Array]] = {
            "camid --dark": lambda: by_camid(file, dark=True),
            "camid --dark --method gradient": lambda: by_camid(file, dark=True, method="gradient"),
            "camid --colour red": lambda: by_camid(file, colour="red"),
            "camid, what moves": lambda: by_camid(file),
            "OpenCV Sobel, threshold, moments": lambda: by_opencv(file, edges),
            f"OpenCV threshold {GREY_THRESHOLD:g}, moments": lambda: by_opencv(file, darkness),
        }
        times = alternate({name: lambda _round, call=call: call() for name, call in tools.items()}, ROUNDS)
        rows = []
        for name, call in tools.items():
            error = call() - truth
            rows.append(
                {
                    "tool": name,
                    "frames_per_second": FRAMES / times[name],
                    "bias": float(np.max(np.abs(error.mean(axis=0)))),
                    "rms_error": float(np.sqrt(np.mean(np.sum(np.square(error), axis=1)))),
                }
            )
    table = pd.DataFrame(rows)
    shown = pd.DataFrame(
        {
            "tool": table["tool"],
            "frames/s": [number(f) for f in table["frames_per_second"]],
            "bias in px": [number(b, 2) for b in table["bias"]],
            "RMS error in px": [number(e, 2) for e in table["rms_error"]],
        }
    )
    found = table.set_index("tool")
    plain = found.loc["OpenCV Sobel, threshold, moments"]
    needed = TIMES_FASTER * FASTEST_CAMERA
    goals = [
        Goal(
            f"{name}: {needed:g} frames/s or more of H.264, {WIDTH} × {HEIGHT} px",
            row["frames_per_second"],
            needed,
            True,
        )
        for name, row in found.iterrows()
        if str(name).startswith("camid")
    ]
    own, gradient = found.loc["camid --dark"], found.loc["camid --dark --method gradient"]
    goals += [
        Goal(
            "camid track as fast as the plain OpenCV pipeline or faster (ratio of the times)",
            plain["frames_per_second"] / own["frames_per_second"],
            1.0,
        ),
        Goal(
            "gradient centroid no worse than the plain OpenCV pipeline (ratio of the RMS errors)",
            gradient["rms_error"] / plain["rms_error"],
            1.05,
        ),
        Goal("camid --dark: RMS error of 0.1 px or less in H.264", own["rms_error"], 0.1),
    ]
    return Report(
        "tracking",
        "Positions from a video",
        f"A red disk of {DIAMETER:g} px on a circle of {PATH_DIAMETER:g} px at {FREQUENCY:g} Hz in front of a grey "
        f"wall, {FRAMES} frames of {WIDTH} × {HEIGHT} px, exposed for half of the period, noise of {NOISE:g} grey "
        f"levels, H.264 (libx264, crf 20, 4:2:0). Whole runs from the file to the positions, decoding on one thread; "
        f"the tools take turns, median over {ROUNDS} runs. RMS error: of the distance from the mean position over the "
        "exposure. OpenCV decodes with the same library, turns frames to BGR and to grey, and measures whole frames; "
        "it is told the wall's grey level, and finds neither copies nor gaps nor standard deviations. Without a "
        "choice, camid decodes the clip twice.",
        table,
        shown,
        goals,
    )
