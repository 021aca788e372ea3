"""Images by exposure: frames per second and largest pixel error, against OpenCV's anti-aliased circles."""

from __future__ import annotations

from functools import partial

import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.rendering_reference import Path, expose_reference
from benchmarks.report import Goal, Report, number
from benchmarks.task import configuration
from benchmarks.timing import alternate
from camid.images.forming import FrameFormat, Marker, circular_path, expose
from camid.paper.marker_images import configured_path

Array = NDArray[np.float64]

FULL_SCALE = 255.0
INSTANTS = 4096  # of the reference: error below 1e-5 of full scale for the longest path
SUB_INSTANTS = 256  # circles that OpenCV draws an exposure
SHIFT = 8  # binary places of OpenCV's sub-pixel coordinates
# OpenCV's anti-aliased disks are about half a pixel too large all round: it gets the radius that suits it best.
EXCESS_RADIUS = 0.5
FRAMES = 60
LARGEST_ERROR, FEWEST_FRAMES = 1e-3, 500.0
CIRCLE = "circle at 24 Hz (config.yaml)"


def straight(start: tuple[float, float], shift: tuple[float, float], exposure: float) -> Path:
    """Constant velocity from one point over ``shift`` px in an exposure."""
    return lambda time: np.asarray(start) + np.multiply.outer(np.asarray(time) / exposure, np.asarray(shift))


def with_stop(exposure: float) -> Path:
    """Back and forth along a line; stays still at 40 % of the exposure."""

    def path(time: Array) -> Array:
        phase = np.pi * (np.asarray(time) / exposure - 0.4)
        return np.stack((200.3 + 80.0 * np.cos(phase), 150.2 + 10.0 * np.cos(phase)), axis=-1)

    return path


def start_and_stop(exposure: float) -> Path:
    """Still, then 60 px within a tenth of the exposure, then still again."""

    def path(time: Array) -> Array:
        step = np.tanh((np.asarray(time) / exposure - 0.55) / 0.025)
        return np.stack((200.0 + 30.0 * step, 150.0 + 10.0 * step), axis=-1)

    return path


def paths(exposure: float) -> dict[str, Path]:
    """The paths that are rendered, each during one exposure from time 0."""
    imaging = configuration()["imaging"]
    return {
        CIRCLE: configured_path(imaging, imaging["fast_frequency"]),
        "straight line along a row, 100 px": straight((100.5, 150.5), (100.0, 0.0), exposure),
        "straight line, oblique, 118 px": straight((100.2, 80.7), (100.0, 62.0), exposure),
        "back and forth with a stop": with_stop(exposure),
        "start and stop, 63 px": start_and_stop(exposure),
        "fast: straight line, 337 px": straight((40.3, 60.1), (300.0, 153.0), exposure),
        "fast: circle at 100 Hz, two turns": circular_path((210.3, 150.7), 160.0, 100.0, 1.0),
    }


def opencv_exposure(path: Path, exposure: float, radius: float, shape: tuple[int, int]) -> NDArray[np.float32]:
    """Mean of OpenCV's anti-aliased circles over `SUB_INSTANTS` instants, grey levels."""
    centres = path(exposure * (np.arange(SUB_INSTANTS) + 0.5) / SUB_INSTANTS)
    margin = int(np.ceil(radius)) + 2
    size = 2 * margin + 1
    image = np.zeros((shape[0] + 2 * size, shape[1] + 2 * size), np.float32)
    disk = np.zeros((size, size), np.uint8)
    scale = 2**SHIFT
    length = round(scale * (radius - EXCESS_RADIUS))
    for x, y in centres.tolist():
        left, top = int(x) - margin, int(y) - margin
        disk[:] = 0
        cv2.circle(disk, (round(scale * (x - left)), round(scale * (y - top))), length, 255, -1, cv2.LINE_AA, SHIFT)
        cv2.accumulate(disk, image[top + size : top + 2 * size, left + size : left + 2 * size])
    return image[size:-size, size:-size] / np.float32(SUB_INSTANTS)


def compare(name: str, path: Path, exposure: float, diameter: float, frame: FrameFormat, frames: int) -> list[dict]:
    """Rows of both renderers for one path."""
    shape = (frame.height, frame.width)
    exact = FULL_SCALE * expose_reference(path, 0.0, exposure, 0.5 * diameter, shape, INSTANTS)
    renderers = {
        "camid": partial(expose, path, 0.0, exposure, Marker(diameter, FULL_SCALE), frame),
        f"OpenCV, {SUB_INSTANTS} circles": partial(opencv_exposure, path, exposure, 0.5 * diameter, shape),
    }
    if name == CIRCLE:
        renderers["camid, three colours"] = partial(
            expose, path, 0.0, exposure, Marker(diameter, (FULL_SCALE, FULL_SCALE, FULL_SCALE)), frame
        )
    times = alternate({tool: lambda _, call=call: call() for tool, call in renderers.items()}, frames)
    rows = []
    for tool, call in renderers.items():
        image = np.asarray(call()).reshape(*shape, -1)
        error = float(np.max(np.abs(image - exact[:, :, None]))) / FULL_SCALE
        rows.append({"path": name, "tool": tool, "frames_per_second": 1.0 / times[tool], "largest_error": error})
    return rows


def run(frames: int = FRAMES) -> Report:
    """Render every path with both, alternately."""
    imaging = configuration()["imaging"]
    frame = FrameFormat(imaging["height"], imaging["width"])
    exposure, diameter = imaging["exposure"], imaging["marker_diameter"]
    table = pd.DataFrame(
        [
            row
            for name, path in paths(exposure).items()
            for row in compare(name, path, exposure, diameter, frame, frames)
        ]
    )
    shown = pd.DataFrame(
        {
            "path": table["path"],
            "tool": table["tool"],
            "frames/s": [number(f) for f in table["frames_per_second"]],
            "largest pixel error / full scale": [number(e, 2) for e in table["largest_error"]],
        }
    )
    own = table[table["tool"].str.startswith("camid")]
    circle = own[own["path"] == CIRCLE]
    goals = [
        Goal(f"{tool}: {FEWEST_FRAMES:g} frames/s or more for the {CIRCLE}", speed, FEWEST_FRAMES, True)
        for tool, speed in zip(circle["tool"], circle["frames_per_second"], strict=True)
    ]
    worst = own.loc[own["largest_error"].idxmax()]
    text = f"camid: largest pixel error {LARGEST_ERROR:g} of full scale or less on every path (worst: {worst['path']})"
    goals.append(Goal(text, worst["largest_error"], LARGEST_ERROR))
    return Report(
        "rendering",
        "Images by exposure",
        f"One exposure of a disk of {diameter:g} px on {frame.height} × {frame.width} px, one core, the tools in "
        f"turn, median over {frames} frames. Largest pixel error: against the mean of exactly covered areas at "
        f"{INSTANTS} instants, by a program of its own. `camid.images.forming.expose` forms a grey "
        "image, or three colours; "
        f"OpenCV draws {SUB_INSTANTS} anti-aliased circles with sub-pixel coordinates, which are too large and so get "
        f"a radius smaller by {EXCESS_RADIUS:g} px.",
        table,
        shown,
        goals,
    )
