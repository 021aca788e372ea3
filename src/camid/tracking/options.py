"""What the user may ask for, checked before the first frame is decoded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from camid.errors import InputError
from camid.images.centroids import RegionOfInterest
from camid.tracking.appearance import Appearance, Bright, Colour, Dark, moving
from camid.tracking.follow import LONGEST_GAP
from camid.tracking.image_folder import ImageFolder
from camid.tracking.measure import METHODS
from camid.tracking.video import Source, VideoFile

PIXELS = "px"


@dataclass(frozen=True)
class Options:
    """See :func:`camid.track`, whose arguments these are.

    Raises
    ------
    InputError
        If they contradict each other or are out of range.
    """

    colour: str | None = None
    bright: bool = False
    dark: bool = False
    region: tuple[int, int, int, int] | None = None
    method: str = METHODS[0]
    scale: float | None = None
    unit: str | None = None
    origin: tuple[float, float] = (0.0, 0.0)
    upwards: bool = False
    frame_rate: float | None = None
    start: float | None = None
    end: float | None = None
    longest_gap: int = LONGEST_GAP
    allow_truncated: bool = False
    threads: int = 1

    def __post_init__(self) -> None:
        """Check everything that needs no video."""
        chosen = [f"--{n}" for n in ("colour", "bright", "dark") if getattr(self, n) not in {None, False}]
        if len(chosen) > 1:
            raise InputError(f"{' and '.join(chosen)} contradict each other", hint="say one of them")
        if self.method not in METHODS:
            raise InputError(f"method '{self.method}' is not known", hint=f"it must be one of {', '.join(METHODS)}")
        self._check_numbers()
        self._check_scale()
        if self.region is not None and min(self.region[2:]) < 3:
            raise InputError(f"a region of {self.region[2]} × {self.region[3]} px", hint="it must be at least 3 × 3 px")

    def _check_numbers(self) -> None:
        for name in ("scale", "frame_rate"):
            value = getattr(self, name)
            if value is not None and not (isfinite(value) and value > 0.0):
                raise InputError(f"--{name.replace('_', '-')} {value:g}", hint="it takes a positive number")
        if self.longest_gap < 0 or self.threads < 1:
            raise InputError("--longest-gap takes 0 or more frames, --threads 1 or more")
        for name in ("start", "end"):
            if getattr(self, name) is not None and not isfinite(getattr(self, name)):
                raise InputError(f"--{name} {getattr(self, name):g}", hint="it takes a number of seconds")
        if not all(isfinite(v) for v in self.origin):
            raise InputError("--origin takes two finite numbers of pixels")
        if self.start is not None and self.end is not None and self.start >= self.end:
            raise InputError(f"--start {self.start:g} is not before --end {self.end:g}", hint="change one of them")

    def _check_scale(self) -> None:
        if self.unit is not None and self.scale is None and self.unit != PIXELS:
            raise InputError(f"--unit {self.unit} without --scale", hint=f"say how many {self.unit} a pixel is")
        if self.scale is not None:
            if self.unit is None:
                raise InputError("--scale without --unit", hint="say the unit, e.g. --unit m")
            if self.unit != PIXELS:
                from camid.recording.units import si_factor

                try:
                    si_factor(self.unit, "--unit", "[length]")
                except InputError as error:
                    raise InputError(error.problem, where="--unit", hint="say m, cm, mm, inch, …") from None

    def source(self, path: Path) -> Source:
        """Open the video or the folder.

        Raises
        ------
        InputError
            If it cannot be read.
        """
        if not path.exists():
            raise InputError("no such file", where=str(path), hint="check the path")
        if path.is_dir():
            return ImageFolder(path, frame_rate=self.frame_rate)
        if not path.is_file():
            raise InputError("this is a device or a pipe", where=str(path), hint="name a file")
        return VideoFile(path, frame_rate=self.frame_rate, allow_truncated=self.allow_truncated, threads=self.threads)

    def appearance(self, source: Source, progress: Callable[[str], None] | None) -> Appearance:
        """What the marker looks like; without a choice the clip is read once for its background."""
        if self.colour is not None:
            return Colour(self.colour)
        if self.bright or self.dark:
            return Bright() if self.bright else Dark()
        return moving(source, self.start, self.end, progress)

    def first_region(self, shape: tuple[int, int], source: str) -> RegionOfInterest | None:
        """Where to look in the first frame.

        Raises
        ------
        InputError
            If it is not inside the image of ``shape`` (height, width).
        """
        if self.region is None:
            return None
        left, top, width, height = self.region
        if left < 0 or top < 0 or left + width > shape[1] or top + height > shape[0]:
            raise InputError(
                f"the region {left} {top} {width} {height} is not inside the image of {shape[1]} × {shape[0]} px",
                where=source,
                hint="--region takes X Y WIDTH HEIGHT in px from the upper left corner",
            )
        return RegionOfInterest(top, left, height, width)
