"""What the marker looks like: each choice turns a region of a picture into an image with a bright marker."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError, nearest_match
from camid.images.centroids import RegionOfInterest
from camid.tracking.picture import BLUE_DIFFERENCE, FULL_SCALE, RED_DIFFERENCE, Image, Picture, PixelGrid
from camid.tracking.video import Source

# Colour differences of black, grey and white are zero; below this (of 0.5) there is no hue to look for.
LEAST_COLOUR = 0.05
# Grey levels that a marker must stand out by: the noise of lossy codecs in a still background stays below.
LEAST_CONTRAST = 12.0
# Pictures that the background is the median of: kept between one and two times this number, spread over the clip.
BACKGROUND_PICTURES = 15
# What moves is brighter (or darker) than the background with at least this share of its difference.
ONE_SIGN = 0.6


class Appearance(Protocol):
    """How to see the marker as something bright on a darker background.

    Attributes
    ----------
    sentence : str
        For people: what is followed.
    """

    sentence: str

    def grid(self, picture: Picture) -> PixelGrid:
        """PixelGrid of the images that are made from this picture."""
        ...

    def image(self, picture: Picture, region: RegionOfInterest | None = None) -> Image:
        """Image in which the marker is bright; ``region`` counts in the grid."""
        ...


class Bright:
    """The brightest thing, by its grey levels."""

    sentence = "the brightest thing"

    def grid(self, picture: Picture) -> PixelGrid:
        """Grid of the pixels."""
        return PixelGrid()

    def image(self, picture: Picture, region: RegionOfInterest | None = None) -> Image:
        """Grey levels as they are."""
        return picture.grey(region)


class Dark:
    """The darkest thing, by its grey levels."""

    sentence = "the darkest thing"

    def grid(self, picture: Picture) -> PixelGrid:
        """Grid of the pixels."""
        return PixelGrid()

    def image(self, picture: Picture, region: RegionOfInterest | None = None) -> Image:
        """White minus the grey levels."""
        grey = picture.grey(region)
        return grey.dtype.type(FULL_SCALE) - grey


def _nearest_colours(name: str) -> str:
    """Sentence that offers the likeliest spelling of a colour, or the three nearest: there are 148 of them."""
    from matplotlib import colors

    offered = nearest_match(name, colors.CSS4_COLORS)
    if offered.startswith("did you mean"):
        return offered
    near = get_close_matches(name.lower(), list(colors.CSS4_COLORS), n=3, cutoff=0.0)
    return f"nearest are {', '.join(near)}; or say its red, green and blue, such as #ff0000"


class Colour:
    """Things of one hue, however bright.

    The likeness of a pixel is its colour difference along the wanted hue: the whole of it up to 26.6° beside the hue,
    falling to nothing at 45°, and nothing for greys. It is linear in the light mixed from marker and grey background,
    so a blurred edge counts with its share. It is made at the resolution of the colour samples, every second
    pixel for most videos.

    Parameters
    ----------
    name : str
        A CSS colour name, or #rrggbb.

    Raises
    ------
    InputError
        If the colour is not known or has no hue.
    """

    def __init__(self, name: str) -> None:
        from matplotlib import colors

        if name.lower() not in colors.CSS4_COLORS and not (name.startswith("#") and len(name) == 7):
            raise InputError(f"there is no colour '{name}'", where="--colour", hint=_nearest_colours(name))
        try:
            rgb = np.array(colors.to_rgb(name.lower()))
        except ValueError:
            raise InputError(f"'{name}' is not a colour", where="--colour", hint="say e.g. red or #ff0000") from None
        direction = np.array([rgb @ BLUE_DIFFERENCE, rgb @ RED_DIFFERENCE])
        strength = float(np.hypot(*direction))
        if strength < LEAST_COLOUR:
            raise InputError(
                f"{name} has no hue", where="--colour", hint="say --bright or --dark for white, grey and black"
            )
        self._blue, self._red = (float(v) for v in direction / strength)
        self.sentence = f"the colour {name}"

    def grid(self, picture: Picture) -> PixelGrid:
        """PixelGrid of the colour samples."""
        return picture.colour_grid()

    def image(self, picture: Picture, region: RegionOfInterest | None = None) -> Image:
        """Likeness to the hue: 0 for greys, 127 for the purest."""
        import cv2

        if not picture.has_colour:
            raise InputError("the video has no colour", hint="say --bright or --dark")
        blue, red = picture.colour_differences(region)
        along = cv2.addWeighted(blue, self._blue, red, self._red, 0.0)
        across = cv2.addWeighted(blue, -self._red, red, self._blue, 0.0)
        beside = cv2.addWeighted(along, 2.0, np.abs(across), -2.0, 0.0)
        return cv2.max(cv2.min(along, beside), 0.0)  # type: ignore[call-overload]


class Moving:
    """What differs from the background, the median of pictures spread over the clip.

    Parameters
    ----------
    background : ndarray of float32, shape (height, width)
        Grey levels.
    sign : {1, -1, 0}
        Whether the marker is brighter, darker, or (0) to be determined.
    """

    def __init__(self, background: NDArray[np.float32], sign: int = 0) -> None:
        self.background, self.sign = background, sign
        how = {1: " (brighter than what is behind it)", -1: " (darker than what is behind it)", 0: ""}
        self.sentence = f"what moves{how[sign]}"

    def grid(self, picture: Picture) -> PixelGrid:
        """Grid of the pixels."""
        return PixelGrid()

    def image(self, picture: Picture, region: RegionOfInterest | None = None) -> Image:
        """Difference from the background, with the sign that makes the marker bright."""
        import cv2

        behind = self.background
        if region is not None:
            behind = behind[region.top : region.top + region.height, region.left : region.left + region.width]
        grey = picture.grey(region)
        if self.sign == 0:
            return cv2.absdiff(grey.astype(np.float32), behind)
        first, second = (grey, behind) if self.sign > 0 else (behind, grey)
        return cv2.subtract(first, second, dtype=cv2.CV_32F)

    def signed(self, picture: Picture, region: RegionOfInterest) -> Moving:
        """The same, brighter or darker according to what is in ``region``.

        Raises
        ------
        InputError
            If it is both: it moves by less than its own size, and is part of the median as well.
        """
        behind = self.background[region.top : region.top + region.height, region.left : region.left + region.width]
        difference = picture.grey(region).astype(np.float32) - behind
        strong = difference[np.abs(difference) > 0.3 * np.abs(difference).max()]
        balance = float(strong.sum() / np.abs(strong).sum())
        if abs(balance) < ONE_SIGN:
            raise InputError(
                "what moves is both brighter and darker than the median: it moves little, or stays still for long",
                hint="say what the marker looks like: --bright, --dark or --colour",
            )
        return Moving(self.background, 1 if balance > 0.0 else -1)


def moving(
    source: Source, start: float | None, end: float | None, progress: Callable[[str], None] | None = None
) -> Moving:
    """See what moves in a clip against the median of some of its pictures.

    Raises
    ------
    InputError
        If the clip has fewer than three pictures.
    """
    kept: list[Image] = []
    stride = 1
    for count, frame in enumerate(source.frames(start, end)):
        if count % stride == 0:
            kept.append(frame.picture.grey().copy())
            if len(kept) == 2 * BACKGROUND_PICTURES:
                kept, stride = kept[::2], 2 * stride
        if progress is not None and count % 50 == 0:
            progress(f"looking for what moves, frame {frame.number}")
    if len(kept) < 3:
        raise InputError(
            f"{len(kept)} frames show no motion", where=source.name, hint="say --bright, --dark or --colour"
        )
    return Moving(_median(kept).astype(np.float32))


def _median(pictures: list[Image]) -> Image:
    """Median of an odd number of pictures (of an even one without the last), whose memory is used up.

    The larger halves are sorted to the end by whole pictures at once, ten times as fast as pixel by pixel.
    """
    pictures = pictures[: len(pictures) - 1 + len(pictures) % 2]
    middle = len(pictures) // 2
    for first in range(middle + 1):  # after this pass the pictures up to ``first`` hold the smallest values in order
        for k in range(len(pictures) - 1, first, -1):
            smaller = np.minimum(pictures[k - 1], pictures[k])
            np.maximum(pictures[k - 1], pictures[k], out=pictures[k])
            pictures[k - 1] = smaller
    return pictures[middle]
