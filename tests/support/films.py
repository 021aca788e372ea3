"""Films of a disk, rendered and encoded by the tests alone: nothing in here knows camid."""

from fractions import Fraction

import av
import numpy as np

SUPERSAMPLING = 8  # sub-pixels along each axis


def disk(height, width, centre, radius):
    """Share of each pixel that a disk covers, pixel centres at integers, by counting sub-pixels."""
    share = np.zeros((height, width))
    x, y = centre
    left, right = max(int(x - radius) - 1, 0), min(int(x + radius) + 3, width)
    top, bottom = max(int(y - radius) - 1, 0), min(int(y + radius) + 3, height)
    if left >= right or top >= bottom:
        return share
    fine = (np.arange(SUPERSAMPLING) + 0.5) / SUPERSAMPLING - 0.5
    columns = (np.arange(left, right)[:, None] + fine).ravel()
    rows = (np.arange(top, bottom)[:, None] + fine).ravel()
    inside = (columns[None, :] - x) ** 2 + (rows[:, None] - y) ** 2 <= radius**2
    inside = inside.reshape(bottom - top, SUPERSAMPLING, right - left, SUPERSAMPLING)
    share[top:bottom, left:right] = inside.mean(axis=(1, 3))
    return share


def blurred(height, width, centres, radius):
    """Mean of the disk over several positions: motion blur."""
    return np.mean([disk(height, width, c, radius) for c in centres], axis=0)


def path(count, rate=60.0, *, centre=(80.0, 60.0), reach=(45.0, 25.0), frequency=0.7):
    """Positions at the frames' times, on an ellipse, shape (count, 2)."""
    phase = 2.0 * np.pi * frequency * np.arange(count) / rate + 0.4
    return np.column_stack((centre[0] + reach[0] * np.cos(phase), centre[1] + reach[1] * np.sin(phase)))


def film(positions, *, seed, size=(120, 160), radius=8.0, background=40.0, marker=210.0, noise=2.0, blur=None):
    """Grey frames of 8 bits: a disk at each position, or moving over ``blur[k]``, in noise."""
    generator = np.random.default_rng(seed)
    frames = []
    for k, centre in enumerate(positions):
        share = disk(*size, centre, radius) if blur is None else blurred(*size, blur[k], radius)
        level = background + (marker - background) * share + noise * generator.standard_normal(size)
        frames.append(np.clip(np.round(level), 0, 255).astype(np.uint8))
    return frames


def coloured(positions, colour, *, seed, size=(120, 160), radius=8.0, background=(200.0, 200.0, 200.0), noise=2.0):
    """RGB frames of 8 bits."""
    generator = np.random.default_rng(seed)
    frames = []
    for centre in positions:
        share = disk(*size, centre, radius)[:, :, None]
        level = share * np.array(colour, float) + (1.0 - share) * np.array(background)
        level += noise * generator.standard_normal(level.shape)
        frames.append(np.clip(np.round(level), 0, 255).astype(np.uint8))
    return frames


def encode(file, frames, *, codec="ffv1", pixels="gray", rate=60, times=None, options=None, layout=None):
    """Write a video; ``times`` are pts in units of 1 ms, for containers that keep them."""
    with av.open(str(file), "w", options=layout or {}) as container:
        stream = container.add_stream(codec, rate=rate, options=options or {})
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = pixels
        base = Fraction(1, rate) if times is None else Fraction(1, 1000)
        stream.codec_context.time_base = base
        stream.codec_context.thread_count = 1
        for k, image in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(image, format="gray" if image.ndim == 2 else "rgb24")
            frame.pts = k if times is None else int(times[k])
            frame.time_base = base
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return file
