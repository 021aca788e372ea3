"""Following the marker from frame to frame with a region of interest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

from camid.errors import InputError
from camid.images.centroids import MarkerNotFound, RegionOfInterest
from camid.tracking.appearance import Appearance, Moving
from camid.tracking.find import EQUALLY_LIKELY, MarkerCandidate, candidates
from camid.tracking.measure import Measurement, measure
from camid.tracking.picture import Picture, PixelGrid
from camid.tracking.video import Frame

# Room around the marker: samples, share of its size, share of its path in a frame.
MARGIN, MARGIN_SHARE, MARGIN_OF_STEP = 5, 0.3, 0.5
# How often a region is moved within a frame because the marker reaches its border.
ATTEMPTS = 4
# The sum of the grey levels of one marker stays within this factor from frame to frame, whatever the motion blur.
MASS_FACTOR = 2.5
# Weight of a new frame in the running mean of that sum.
MEMORY = 0.1
LONGEST_GAP = 30
# A marker that would be outside the image within this many frames has left it; beyond that it is a guess.
SURE_PREDICTIONS = 2


@dataclass(frozen=True)
class Position:
    """Marker in a frame, in px of the image with y down, and the region where it was measured."""

    frame: int
    time: float
    gradient: tuple[float, float]
    grey_level: tuple[float, float]
    deviation: tuple[float, float]
    region: tuple[float, float, float, float]
    mass: float
    contrast: float
    alone: float
    noise: float


class Follower:
    """Finds the marker in the first frame, then follows it.

    The region is as large as the marker and a margin, centred where it would be at constant velocity. A marker that is
    not there is looked for in a region that grows with every frame, and given up after ``longest_gap`` frames.

    Parameters
    ----------
    appearance : Appearance
    method : {"grey-level", "gradient"}
    source : str
        For messages.
    region : RegionOfInterest, optional
        In px of the image: where to find the marker in the first frame.
    longest_gap : int
        Frames without a marker.
    """

    def __init__(
        self,
        appearance: Appearance,
        method: str,
        source: str,
        region: RegionOfInterest | None = None,
        longest_gap: int = LONGEST_GAP,
    ) -> None:
        self.appearance, self.method, self.source = appearance, method, source
        self.first_region, self.longest_gap = region, longest_gap
        self._time = 0.0
        self._last: Measurement | None = None
        self._velocity: tuple[float, float] | None = None
        self._mass = 0.0
        self.lost = 0  # consecutive frames
        self._lost_since: Frame | None = None

    def step(self, frame: Frame) -> Position | None:
        """Measure the marker in the next frame; None if it is not there.

        Raises
        ------
        InputError
            If the marker is nowhere, one of several, given up, or leaves the image.
        """
        picture = frame.picture
        grid = self.appearance.grid(picture)
        found = self._find_first(frame, grid) if self._last is None else self._find_next(frame, grid)
        if found is None:
            self._count_lost(frame)
            return None
        measurement, region = found
        if self._last is not None:
            elapsed = frame.time - self._time
            old, new = _centre(self._last.box), _centre(measurement.box)
            self._velocity = ((new[0] - old[0]) / elapsed, (new[1] - old[1]) / elapsed)
            self._mass += MEMORY * (measurement.mass - self._mass)
        else:
            self._mass = measurement.mass
        self._last, self._time, self.lost, self._lost_since = measurement, frame.time, 0, None
        corner = grid.to_image(region.left - 0.5, region.top - 0.5)
        return Position(
            frame.number,
            frame.time,
            grid.to_image(*measurement.gradient),
            grid.to_image(*measurement.grey_level),
            (grid.scale_x * measurement.deviation[0], grid.scale_y * measurement.deviation[1]),
            (*corner, grid.scale_x * region.width, grid.scale_y * region.height),
            measurement.mass,
            measurement.contrast,
            measurement.alone,
            measurement.noise,
        )

    def _find_first(self, frame: Frame, grid: PixelGrid) -> tuple[Measurement, RegionOfInterest] | None:
        picture = frame.picture
        where = None if self.first_region is None else grid.region(self.first_region)
        image = self.appearance.image(picture, where)
        left, top = (0, 0) if where is None else (where.left, where.top)
        found = candidates(image, left, top)
        whole = [c for c in found if not c.at_border]
        if not whole and found:
            place = "image" if where is None else "region"
            self._refuse(
                f"what looks like the marker reaches the border of the {place} {_at(found[0], grid)}",
                frame,
                "say where it is with --region, or start later with --start",
            )
        if not whole:
            return None
        best = whole[0]
        if len(whole) > 1 and whole[1].mass > EQUALLY_LIKELY * best.mass:
            if isinstance(
                self.appearance, Moving
            ):  # where a marker is now, and where it mostly is, are not two markers
                self.appearance.signed(picture, _around(whole[0], whole[1]).clip(*image.shape))
            self._refuse(
                f"two things may be the marker: {_at(best, grid)} and {_at(whole[1], grid)}",
                frame,
                "say which with --region X Y WIDTH HEIGHT",
            )
        box = RegionOfInterest(best.top, best.left, max(3, best.height), max(3, best.width))
        if isinstance(self.appearance, Moving) and self.appearance.sign == 0:
            self.appearance = self.appearance.signed(picture, self._about(box, (0.0, 0.0)).clip(*image.shape))
        return self._measure(frame, self._about(box, (0.0, 0.0)))

    def _find_next(self, frame: Frame, grid: PixelGrid) -> tuple[Measurement, RegionOfInterest] | None:
        assert self._last is not None
        box, elapsed = self._last.box, frame.time - self._time
        if self._velocity is not None:
            step = (self._velocity[0] * elapsed, self._velocity[1] * elapsed)
            found = self._measure(frame, self._about(_moved(box, step), step))
            if found is not None and self._is_likely(found[0].mass):
                return found
        return self._search(frame, box, elapsed)

    def _search(
        self, frame: Frame, box: RegionOfInterest, elapsed: float
    ) -> tuple[Measurement, RegionOfInterest] | None:
        """Look in a region that grows; everywhere while no velocity is known."""
        shape = _shape(self.appearance, frame.picture)
        region = RegionOfInterest(0, 0, *shape)
        centre = _centre(box)
        if self._velocity is not None:
            step = (self._velocity[0] * elapsed, self._velocity[1] * elapsed)
            centre = (centre[0] + step[0], centre[1] + step[1])
            size = max(box.width, box.height)
            reach = round((1 + self.lost) * (abs(step[0]) + abs(step[1]) + size) + size)
            try:
                region = RegionOfInterest.around(centre, 2 * reach).clip(*shape)
            except ValueError:
                return None
        found = candidates(self.appearance.image(frame.picture, region), region.left, region.top)
        for c in sorted(found, key=lambda c: (c.x - centre[0]) ** 2 + (c.y - centre[1]) ** 2):
            here = RegionOfInterest(c.top, c.left, max(3, c.height), max(3, c.width))
            measured = self._measure(frame, self._about(here, (0.0, 0.0)))
            if measured is not None and self._is_likely(measured[0].mass):
                return measured
        return None

    def _measure(self, frame: Frame, region: RegionOfInterest) -> tuple[Measurement, RegionOfInterest] | None:
        """Measure in a region, moved while the marker reaches its border; None if that does not help."""
        shape = _shape(self.appearance, frame.picture)
        for _ in range(ATTEMPTS):
            try:
                region = region.clip(*shape)
                measurement = measure(self.appearance.image(frame.picture, region), region, self.method)
            except (MarkerNotFound, ValueError):
                return None
            if not any(measurement.touches):
                return measurement, region
            at_edge = (
                region.left == 0,
                region.top == 0,
                region.left + region.width == shape[1],
                region.top + region.height == shape[0],
            )
            if any(a and b for a, b in zip(measurement.touches, at_edge, strict=True)):
                if self._last is None or self._is_likely(measurement.mass):
                    self._leaves(frame)
                return None
            region = self._about(measurement.box, (0.5 * region.width, 0.5 * region.height))
        return None

    def _about(self, box: RegionOfInterest, step: tuple[float, float]) -> RegionOfInterest:
        """Region around a box with a margin for the noise and for a change of the velocity."""
        width, height = (
            size + 2 * round(MARGIN + MARGIN_SHARE * size + MARGIN_OF_STEP * abs(path))
            for size, path in ((box.width, step[0]), (box.height, step[1]))
        )
        return RegionOfInterest.around(_centre(box), height, width)

    def _is_likely(self, mass: float) -> bool:
        return self._mass / MASS_FACTOR < mass < self._mass * MASS_FACTOR

    def _count_lost(self, frame: Frame) -> None:
        self.lost += 1
        self._lost_since = self._lost_since or frame
        since = self._lost_since
        if self._last is None:
            if self.lost > self.longest_gap:
                raise nowhere(self.appearance, self.source, self.lost)
            return
        if self._velocity is not None and self.lost <= SURE_PREDICTIONS:
            elapsed = frame.time - self._time
            box = _moved(self._last.box, (self._velocity[0] * elapsed, self._velocity[1] * elapsed))
            try:
                box.clip(*_shape(self.appearance, frame.picture))
            except ValueError:
                self._leaves(since)
        if self.lost > self.longest_gap:
            self._refuse(
                f"the marker is lost and not seen again in {self.lost} frames",
                since,
                f"end the clip there with --end {self._time:.6g}, or allow a longer --longest-gap",
            )

    def _leaves(self, frame: Frame) -> NoReturn:
        hint = "start later with --start" if self._last is None else f"end the clip there with --end {self._time:.6g}"
        self._refuse("the marker leaves the image", frame, hint)

    def _refuse(self, problem: str, frame: Frame, hint: str) -> NoReturn:
        raise InputError(problem, where=f"{self.source}, t = {frame.time:.6g} s (frame {frame.number})", hint=hint)


def nowhere(appearance: Appearance, source: str, frames: int) -> InputError:
    """The error for a clip in whose first frames there is no marker."""
    if isinstance(appearance, Moving):
        problem = f"nothing moves in the first {frames} frames"
    else:
        problem = f"the marker is nowhere in the first {frames} frames ({appearance.sentence})"
    return InputError(
        problem, where=source, hint="say what it looks like with --colour, --bright or --dark, or choose --start"
    )


def _shape(appearance: Appearance, picture: Picture) -> tuple[int, int]:
    """Height and width of the appearance's whole image."""
    grid = appearance.grid(picture)
    height, width = picture.planes[1].shape if grid != PixelGrid() else picture.shape
    return height, width


def _centre(box: RegionOfInterest) -> tuple[float, float]:
    return box.left + 0.5 * (box.width - 1), box.top + 0.5 * (box.height - 1)


def _around(first: MarkerCandidate, second: MarkerCandidate) -> RegionOfInterest:
    """Smallest region with both."""
    left, top = min(first.left, second.left), min(first.top, second.top)
    right = max(first.left + first.width, second.left + second.width)
    bottom = max(first.top + first.height, second.top + second.height)
    return RegionOfInterest(top, left, max(3, bottom - top), max(3, right - left))


def _moved(box: RegionOfInterest, step: tuple[float, float]) -> RegionOfInterest:
    return RegionOfInterest(box.top + round(step[1]), box.left + round(step[0]), box.height, box.width)


def _at(candidate: MarkerCandidate, grid: PixelGrid) -> str:
    x, y = grid.to_image(candidate.x, candidate.y)
    return f"at x = {x:.0f}, y = {y:.0f} px"
