"""Measurement of the marker's position in an image (paper section 2.1).

Positions are x, y in px of the whole image, with pixel centres at integer coordinates, x to the right and y down.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Image = NDArray[Any]
Single = NDArray[np.float32]

# A 3 × 3 Sobel filter answers with 8 to a ramp of one grey level per pixel.
SOBEL_SUM = 8.0
# Standard deviations of the noise that a pixel must stand out by, and the share of a normal variable's values that lie
# below one standard deviation.
CLEARANCE = 5.0
NORMAL_DEVIATION_RANK = 0.8413
# Gradients of whole grey levels often equal the threshold, and how a square root rounds depends on where in memory the
# image lies: what lies this near below the threshold counts as above it.
TIE = 1.0 - 1e-6
# Types that every OpenCV function used here takes as they are; others are converted to float32.
COMPONENTS = (None, 0, 1, 2)
OPENCV_TYPES = frozenset(np.dtype(name) for name in ("uint8", "uint16", "int16", "float32", "float64"))


class MarkerNotFound(ValueError):  # noqa: N818 - the name says what happened
    """No pixel of the region of interest stands out enough to be the marker."""


@dataclass(frozen=True)
class RegionOfInterest:
    """Rectangle of the image "where only one marker is to be found" (paper section 2.1).

    Attributes
    ----------
    top, left : int
        Row and column of the first pixel; may lie outside the frame until `clip`.
    height, width : int
        Number of rows and of columns, 3 (the size of the Sobel kernel) or more, ValueError otherwise.
    """

    top: int
    left: int
    height: int
    width: int

    def __post_init__(self) -> None:
        """Refuse a region too small to filter; cv2.moments would even take two columns for a list of points."""
        if self.height < 3 or self.width < 3:
            raise ValueError(f"a region of interest of {self.height} × {self.width} px; at least 3 × 3 is needed")

    @classmethod
    def around(cls, point: tuple[float, float], height: int, width: int | None = None) -> RegionOfInterest:
        """Region of ``height`` × ``width`` px (square without a width) centred on x, y to half a pixel."""
        width = height if width is None else width
        return cls(round(point[1] - 0.5 * (height - 1)), round(point[0] - 0.5 * (width - 1)), height, width)

    def clip(self, height: int, width: int) -> RegionOfInterest:
        """Part of the region inside a frame of ``height`` × ``width`` px; ValueError if that is below 3 × 3 px."""
        if 0 <= self.top <= height - self.height and 0 <= self.left <= width - self.width:
            return self
        top, left = max(self.top, 0), max(self.left, 0)
        bottom, right = min(self.top + self.height, height), min(self.left + self.width, width)
        if bottom - top < 3 or right - left < 3:
            raise ValueError(f"{self} has less than 3 × 3 px in common with the frame of {height} × {width} px")
        return RegionOfInterest(top, left, bottom - top, right - left)


class _Scratch(threading.local):
    """Buffers for one size of region and thread: fresh ones cost more in page faults than all of the filtering."""

    shape: tuple[int, ...] = ()
    buffers: tuple[Single, Single]

    def for_shape(self, shape: tuple[int, ...]) -> tuple[Single, Single]:
        if self.shape != shape:
            horizontal, vertical = np.empty((2, *shape), np.float32)
            self.shape, self.buffers = shape, (horizontal, vertical)
        return self.buffers


_scratch = _Scratch()


def gradient_image(image: Image, component: int | None = None) -> Single:
    """Magnitude of the image's gradient by a 3 × 3 Sobel filter, the first step of the paper (figure 2).

    Parameters
    ----------
    image : ndarray, shape (height, width) or (height, width, 3)
        Grey levels of an integer or floating type.
    component : int, optional
        Colour component 0, 1 or 2 of a colour image; without it the mean of the three is taken.

    Returns
    -------
    ndarray of float32, shape (height, width)
        Grey levels per pixel: a ramp of one grey level per pixel gives 1, a sharp straight edge of height h gives h/2
        on both of its sides. The image is mirrored at its borders.

    Raises
    ------
    ValueError
        If the image is neither grey nor of three components, is below 3 × 3 px, or has no such component.
    """
    view, _, _ = _select(image, None, component)
    return _unscaled_gradient(view, *np.empty((2, *view.shape), np.float32)) / np.float32(SOBEL_SUM)


def gradient_centroid(
    image: Image,
    threshold: float,
    region: RegionOfInterest | None = None,
    *,
    relative: bool = True,
    component: int | None = None,
) -> tuple[float, float]:
    """Position of the marker by the three steps of the paper: Sobel filter, threshold, centre of mass (section 2.1).

    Each pixel above the threshold counts once, however often the marker passed there: hence the paper's assumption A2.

    Parameters
    ----------
    image, component
        As in `gradient_image`.
    threshold : float
        If ``relative``, a fraction above 0 and below 1 of the largest gradient in the region; otherwise grey levels
        per pixel, 0 or more, on the scale of `gradient_image`. A pixel is selected if its gradient is larger.
    region : RegionOfInterest, optional
        Where to look, clipped to the frame; without it the whole image.
    relative : bool
        What the threshold means. A relative one finds something in any image that is not flat, noise included.

    Returns
    -------
    x, y : float, px of the whole image

    Raises
    ------
    MarkerNotFound
        If no gradient in the region is above the threshold.
    ValueError
        If the threshold is outside its range, or the image, region or component is not usable.
    """
    import cv2

    if not (0.0 < threshold < 1.0 if relative else 0.0 <= threshold < np.inf):
        raise ValueError(
            f"a threshold of {threshold}; it must lie between 0 and 1 if relative, and be 0 or more otherwise"
        )
    view, left, top = _select(image, region, component)
    horizontal, vertical = _scratch.for_shape(view.shape)
    gradient = _unscaled_gradient(view, horizontal, vertical)
    limit = TIE * threshold * (cv2.norm(gradient, cv2.NORM_INF) if relative else SOBEL_SUM)
    # A mask of 0.0 and 1.0: its plain moments are those of binaryImage=True and take a sixth of the time.
    _, mask = cv2.threshold(gradient, limit, 1.0, cv2.THRESH_BINARY, vertical)
    moments = cv2.moments(mask)
    mass = moments["m00"]
    if mass == 0.0:
        raise MarkerNotFound(f"no pixel has a gradient above {limit / SOBEL_SUM:.6g} grey levels per pixel")
    return left + moments["m10"] / mass, top + moments["m01"] / mass


def grey_level_centroid(
    image: Image,
    background: float | None = None,
    threshold: float | None = None,
    region: RegionOfInterest | None = None,
    *,
    component: int | None = None,
) -> tuple[float, float]:
    """Centre of mass of the grey levels above the background.

    With no threshold or no noise it is the time mean of the position, paper equations (4) and (5), whatever the path
    and the speed (no need of A1, A2 and A4), as long as the disk stays within the region and no pixel saturates.

    Parameters
    ----------
    image : ndarray, shape (height, width) or (height, width, 3)
        Grey levels of an integer or floating type, marker brighter than the background (for a dark marker, pass the
        white level minus the image).
    background : float, optional
        Grey level to remove; without it, the median of the region's border pixels.
    threshold : float, optional
        Grey levels above the background. At 0 nothing is cut off and noise averages out. If positive, a pixel that is
        not above it counts as zero, which keeps out the noise of a large region and noise clipped at black but also
        cuts off the faint parts of a motion blur. Without it, five standard deviations of the noise of the region's
        border pixels, hence 0 in an image without noise.
    region : RegionOfInterest, optional
        Where to look, clipped to the frame; without it the whole image.

    Returns
    -------
    x, y : float, px of the whole image

    Raises
    ------
    MarkerNotFound
        If nothing is above the threshold, or the grey levels above the background do not sum to a positive number.
    ValueError
        If the threshold is negative, or the image, region or component is not usable.
    """
    import cv2

    if threshold is not None and not 0.0 <= threshold < np.inf:
        raise ValueError(f"a threshold of {threshold} grey levels above the background; it must be finite, 0 or more")
    view, left, top = _select(image, region, component)
    height, width = view.shape
    if background is None or threshold is None:
        border = np.sort(np.concatenate((view[0], view[-1], view[1:-1, 0], view[1:-1, -1])))
        middle = 0.5 * (float(border[(border.size - 1) // 2]) + float(border[border.size // 2]))
        if threshold is None:
            # Noise clipped at black has no lower half, and a marker that touches the border is in the uppermost part.
            noise = float(border[int(NORMAL_DEVIATION_RANK * border.size)]) - middle
            # Whole grey levels hide up to half a level of the noise.
            threshold = CLEARANCE * (noise + 0.5 if noise > 0.0 and view.dtype.kind in "iu" else noise)
        background = middle if background is None else background
    # Moments are linear, so the background's are removed from them and the image need not be copied.
    count = float(height * width)
    count_x, count_y = 0.5 * (width - 1) * count, 0.5 * (height - 1) * count
    if threshold > 0.0:
        level = background + threshold
        if background != 0.0:
            moments = cv2.moments(cv2.threshold(view, level, 1.0, cv2.THRESH_BINARY)[1])
            count, count_x, count_y = moments["m00"], moments["m10"], moments["m01"]
        _, view = cv2.threshold(view, level, 0.0, cv2.THRESH_TOZERO)
    moments = cv2.moments(view)
    mass = moments["m00"] - background * count
    if mass <= 1e-9 * abs(background) * count:
        raise MarkerNotFound(f"nothing in the region is brighter than {background:.6g} + {threshold:.6g} grey levels")
    return left + (moments["m10"] - background * count_x) / mass, top + (moments["m01"] - background * count_y) / mass


def _select(image: Image, region: RegionOfInterest | None, component: int | None) -> tuple[Image, int, int]:
    """Grey image of the region in a type that OpenCV takes, copied only if it must be, and its left and top."""
    shape = image.shape
    usable = (component is None) if len(shape) == 2 else len(shape) == 3 and shape[2] == 3 and component in COMPONENTS
    if not usable or shape[0] < 3 or shape[1] < 3:
        raise ValueError(f"component {component} of an image of shape {shape}; it must be (height, width[, 3])")
    left, top = 0, 0
    if region is not None:
        region = region.clip(shape[0], shape[1])
        left, top = region.left, region.top
        image = image[top : top + region.height, left : left + region.width]
    if component is not None:
        image = np.ascontiguousarray(image[:, :, component])
    if image.dtype not in OPENCV_TYPES or (image.ndim == 3 and image.dtype != np.float64):
        image = image.astype(np.float32)
    if image.ndim == 3:
        import cv2

        image = cv2.transform(image, np.full((1, 3), 1.0 / 3.0))
    return image, left, top


def _unscaled_gradient(view: Image, horizontal: Single, vertical: Single) -> Single:
    """`SOBEL_SUM` times the gradient magnitude, in ``horizontal``; both buffers have the shape of ``view``."""
    import cv2

    if view.dtype == np.float64:
        view = view.astype(np.float32)
    cv2.Sobel(view, cv2.CV_32F, 1, 0, horizontal)
    cv2.Sobel(view, cv2.CV_32F, 0, 1, vertical)
    # Not by cv2.magnitude, whose last digits depend on where in memory the arrays begin.
    np.multiply(horizontal, horizontal, out=horizontal)
    np.multiply(vertical, vertical, out=vertical)
    np.add(horizontal, vertical, out=horizontal)
    return np.sqrt(horizontal, out=horizontal)
