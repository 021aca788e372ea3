"""Folders of PNG images as a video."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import numpy as np

from camid.errors import InputError
from camid.tracking.picture import FULL_SCALE, Picture
from camid.tracking.video import Frame

TIMESTAMPS = "timestamps.csv"


class ImageFolder:
    """PNG images in one folder, in the order of the last number in their names.

    Parameters
    ----------
    folder : path
    frame_rate : float, optional
        Frames per second. A number that is left out in the names is a frame that is missing.

    Raises
    ------
    InputError
        If there are no images, names without a number, two with the same number, neither ``timestamps.csv`` (column
        ``t`` in seconds, one row per image) nor a frame rate, or both.
    """

    def __init__(self, folder: Path, *, frame_rate: float | None = None) -> None:
        self.folder, self.name = folder, str(folder)
        self.notes: list[str] = []
        numbered = self._numbered()
        self.files = [file for _, file in numbered]
        self.expected: int | None = len(self.files)
        stamps = folder / TIMESTAMPS
        if stamps.exists() and frame_rate is not None:
            raise InputError(
                "there are time stamps beside the images", where=str(stamps), hint="leave out --frame-rate"
            )
        if stamps.exists():
            self.times = self._stamps(stamps)
        elif frame_rate is not None:
            numbers = [number for number, _ in numbered]
            step = Counter(b - a for a, b in pairwise(numbers)).most_common(1)[0][0] if len(numbers) > 1 else 1
            self.times = [(number - numbers[0]) / (step * frame_rate) for number in numbers]
        else:
            raise InputError(
                "images have no time stamps",
                where=self.name,
                hint=f"say --frame-rate, or put {TIMESTAMPS} with a column t beside them",
            )

    def _numbered(self) -> list[tuple[int, Path]]:
        files = [f for f in self.folder.iterdir() if f.suffix.lower() == ".png" and not f.name.startswith(".")]
        if not files:
            raise InputError("no PNG image in this folder", where=self.name, hint="name a video or a folder of PNG")
        numbered: dict[int, Path] = {}
        for file in sorted(files):
            found = re.findall(r"\d+", file.stem)
            if not found:
                raise InputError("no number in the name", where=str(file), hint="call the images e.g. 0001.png, …")
            number = int(found[-1])
            if number in numbered:
                raise InputError(
                    f"the same number as {numbered[number].name}", where=str(file), hint="remove or rename one"
                )
            numbered[number] = file
        return sorted(numbered.items())

    def _stamps(self, path: Path) -> list[float]:
        import pandas as pd

        try:
            table = pd.read_csv(path)
            times = table["t"].to_numpy(dtype=float)
        except (KeyError, ValueError, pd.errors.ParserError):
            raise InputError("no column t of numbers", where=str(path), hint="one row per image, in seconds") from None
        if len(times) != len(self.files):
            raise InputError(
                f"{len(times)} rows for {len(self.files)} images", where=str(path), hint="it needs one row per image"
            )
        wrong = np.flatnonzero(~np.isfinite(times) | np.append(False, np.diff(times) <= 0.0))
        if wrong.size:
            row = int(wrong[0])
            raise InputError(
                f"the time {times[row]:.6g} s does not follow the one before",
                where=f"{path}, line {row + 2}",
                hint="the times must increase",
            )
        return [float(t) for t in times]

    def frames(self, start: float | None = None, end: float | None = None) -> Iterator[Frame]:
        """Frames from ``start`` to ``end`` in seconds, both included.

        Raises
        ------
        InputError
            If an image cannot be read or is not as large as the first.
        """
        shape = None
        for number, (file, time) in enumerate(zip(self.files, self.times, strict=True)):
            if (start is not None and time < start) or (end is not None and time > end):
                continue
            picture = _read(file)
            if shape not in {None, picture.shape}:
                raise InputError(
                    f"{picture.shape[1]} × {picture.shape[0]} px where the first image has {shape[1]} × {shape[0]}",
                    where=str(file),
                    hint="all images must be of one size",
                )
            shape = picture.shape
            yield Frame(number, time, picture)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the lines to itself that libpng writes to the error stream about a damaged file."""
    kept, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


def _read(file: Path) -> Picture:
    import cv2

    try:
        with _quiet():
            image = cv2.imdecode(np.fromfile(file, np.uint8), cv2.IMREAD_UNCHANGED) if file.stat().st_size else None
    except cv2.error:  # more pixels than OpenCV takes
        image = None
    if image is None:
        raise InputError("this is not a PNG image", where=str(file), hint="remove it, or write it again")
    full_scale = FULL_SCALE if image.dtype == np.uint8 else 65535.0
    if image.ndim == 2:
        return Picture((image,), full_scale=full_scale)
    return Picture((image[:, :, 2], image[:, :, 1], image[:, :, 0]), True, full_scale)
