"""Frames as their planes, and regions of them as grey levels or colour differences; no whole frame is converted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.images.centroids import RegionOfInterest

if TYPE_CHECKING:
    import av

Image = NDArray[Any]

FULL_SCALE = 255.0
NEUTRAL = 128.0
# Red, green and blue to luma and to the blue and the red colour difference (ITU-R BT.601-7, section 2.5).
LUMA = (0.299, 0.587, 0.114)
BLUE_DIFFERENCE = (-0.168736, -0.331264, 0.5)
RED_DIFFERENCE = (0.5, -0.418688, -0.081312)


@dataclass(frozen=True)
class PixelGrid:
    """Where the samples of a plane lie in the image: x = ``scale_x`` column + ``offset_x`` px, y likewise."""

    scale_x: float = 1.0
    scale_y: float = 1.0
    offset_x: float = 0.0
    offset_y: float = 0.0

    def to_image(self, x: float, y: float) -> tuple[float, float]:
        """Position in px of the image, pixel centres at integers."""
        return self.scale_x * x + self.offset_x, self.scale_y * y + self.offset_y

    def region(self, region: RegionOfInterest) -> RegionOfInterest:
        """Samples of the plane that a region of the image covers."""
        return RegionOfInterest(
            int(region.top / self.scale_y),
            int(region.left / self.scale_x),
            max(3, int(region.height / self.scale_y)),
            max(3, int(region.width / self.scale_x)),
        )


@dataclass(frozen=True)
class Picture:
    """A frame as it is stored.

    Attributes
    ----------
    planes : tuple of ndarray, each of shape (height, width) or smaller
        Luma; luma, blue and red difference; or red, green and blue, with ``is_rgb``.
    is_rgb : bool
    full_scale : float
        Largest value that a sample can have.
    """

    planes: tuple[Image, ...]
    is_rgb: bool = False
    full_scale: float = FULL_SCALE
    keep: Any = field(default=None, repr=False)  # what owns the memory of the planes

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in px."""
        height, width = self.planes[0].shape
        return height, width

    @property
    def has_colour(self) -> bool:
        """Whether there is more than grey."""
        return len(self.planes) == 3

    @property
    def first_plane(self) -> Image:
        """What is compared from frame to frame: luma, or green, most of luma."""
        return self.planes[1 if self.is_rgb else 0]

    def grey(self, region: RegionOfInterest | None = None) -> Image:
        """Grey levels of a region, 0 to 255: a view of 8-bit luma, else float32."""
        if self.is_rgb:
            return self._weighted(LUMA, region)
        view = _cut(self.planes[0], region)
        return view if view.dtype == np.uint8 else view.astype(np.float32) * np.float32(FULL_SCALE / self.full_scale)

    def colour_grid(self) -> PixelGrid:
        """PixelGrid of the colour differences, each in the middle of the pixels that share it.

        That is how JPEG and FFmpeg average colours. H.264 files may mean the left one of two pixels, which few writers
        heed and FFmpeg does not tell: x is then off by half a pixel, the same in all frames.
        """
        if self.is_rgb or not self.has_colour:
            return PixelGrid()
        height, width = self.shape
        rows, columns = self.planes[1].shape
        scale_x, scale_y = float(round(width / columns)), float(round(height / rows))
        return PixelGrid(scale_x, scale_y, 0.5 * (scale_x - 1.0), 0.5 * (scale_y - 1.0))

    def colour_differences(self, region: RegionOfInterest | None = None) -> tuple[Image, Image]:
        """Blue and red difference about zero on the `colour_grid`, float32; ``region`` counts in that grid."""
        if self.is_rgb:
            return self._weighted(BLUE_DIFFERENCE, region), self._weighted(RED_DIFFERENCE, region)
        scale = np.float32(FULL_SCALE / self.full_scale)
        neutral = np.float32(NEUTRAL if self.full_scale == FULL_SCALE else 0.5 * FULL_SCALE)
        blue, red = (_cut(plane, region).astype(np.float32) * scale - neutral for plane in self.planes[1:])
        return blue, red

    def _weighted(self, weights: tuple[float, float, float], region: RegionOfInterest | None) -> Image:
        scale = FULL_SCALE / self.full_scale
        total = np.zeros((1, 1), np.float32)
        for weight, plane in zip(weights, self.planes, strict=True):
            total = total + np.float32(scale * weight) * _cut(plane, region).astype(np.float32)
        return total


def _cut(plane: Image, region: RegionOfInterest | None) -> Image:
    if region is None:
        return plane
    return plane[region.top : region.top + region.height, region.left : region.left + region.width]


def picture_of(frame: av.VideoFrame) -> Picture:
    """Planes of a decoded frame, without a copy where the format allows it."""
    name = frame.format.name
    channels = PACKED.get(name)
    if channels is None and name not in USUAL and not _is_plain(frame):
        # Rare formats (palettes, interleaved colour): FFmpeg rewrites the frame in a plain one.
        frame = frame.reformat(format="rgb24" if frame.format.is_rgb or name == "pal8" else "yuv444p")
        name = frame.format.name
        channels = PACKED.get(name)
    if channels is not None:
        count, order = channels
        rows = np.frombuffer(memoryview(frame.planes[0]), np.uint8).reshape(-1, frame.planes[0].line_size)
        pixels = rows[: frame.height, : count * frame.width].reshape(frame.height, frame.width, count)
        return Picture(tuple(pixels[:, :, k] for k in order), True, keep=frame)
    bits = 8 if name in USUAL else frame.format.components[0].bits
    planes = [_plane(frame, k, bits) for k in range(min(len(frame.planes), 3))]
    is_rgb = name not in USUAL and frame.format.is_rgb
    if is_rgb:  # planar: green, blue, red
        planes = [planes[2], planes[0], planes[1]]
    return Picture(tuple(planes), is_rgb, float(2**bits - 1), frame)


# Plain formats of 8 bits, which need no closer look.
USUAL = frozenset({"gray", "yuv420p", "yuvj420p", "yuv422p", "yuvj422p", "yuv444p", "yuvj444p"})
# Bytes a pixel, and where red, green and blue are among them.
PACKED = {
    "rgb24": (3, (0, 1, 2)),
    "bgr24": (3, (2, 1, 0)),
    "rgba": (4, (0, 1, 2)),
    "rgb0": (4, (0, 1, 2)),
    "bgra": (4, (2, 1, 0)),
    "bgr0": (4, (2, 1, 0)),
    "argb": (4, (1, 2, 3)),
    "0rgb": (4, (1, 2, 3)),
    "abgr": (4, (3, 2, 1)),
    "0bgr": (4, (3, 2, 1)),
}


def _is_plain(frame: av.VideoFrame) -> bool:
    """Whether each component is a plane of its own, of whole bytes in the order of this machine."""
    form = frame.format
    components = form.components
    little = all(c.bits <= 8 for c in components) or not form.is_big_endian
    separate = len({c.plane for c in components}) == len(components) == len(frame.planes)
    integral = "f" not in form.name.rpartition("p")[2].rpartition("gray")[2]  # gbrpf32le, grayf32le
    return little and separate and integral and not form.is_bit_stream and not form.has_palette


def _plane(frame: av.VideoFrame, k: int, bits: int) -> Image:
    plane = frame.planes[k]
    kind = np.dtype(np.uint8 if bits <= 8 else np.uint16)
    rows = np.frombuffer(memoryview(plane), kind).reshape(-1, plane.line_size // kind.itemsize)
    return rows[: plane.height, : plane.width]
