"""The configured marker, its path, and the means over an exposure that its measurement is compared with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.images.forming import FrameFormat, Marker, circular_path

Array = NDArray[np.float64]
Path = Callable[[Array], Array]

# Instants of the midpoint rule for integrals along a smooth path; the error is far below a thousandth of a pixel.
INSTANTS = 20_000


def frame_format(imaging: Mapping[str, Any]) -> FrameFormat:
    """Frame of the configuration."""
    return FrameFormat(imaging["height"], imaging["width"])


def marker(imaging: Mapping[str, Any], diameter: float | None = None) -> Marker:
    """Marker of the configuration, in three colour components."""
    red, green, blue = imaging["marker_intensity"]
    return Marker(diameter or imaging["marker_diameter"], (red, green, blue))


def configured_path(imaging: Mapping[str, Any], frequency: float) -> Path:
    """Circular path of the configuration at a frequency in Hz."""
    centre = (imaging["path_centre"][0], imaging["path_centre"][1])
    return circular_path(centre, imaging["path_diameter"], frequency, imaging["path_phase"])


def time_mean(path: Path, start: float, exposure: float) -> Array:
    """Equations (4) and (5): mean position over the exposure, shape (2,), px."""
    instants = start + exposure * (np.arange(INSTANTS) + 0.5) / INSTANTS
    return path(instants).mean(axis=0)


def arc_length_mean(path: Path, start: float, exposure: float) -> Array:
    """Equations (2) and (3): centre of mass of the curve, the mean weighted by the speed, shape (2,), px."""
    edges = path(start + exposure * np.arange(INSTANTS + 1) / INSTANTS)
    middles = path(start + exposure * (np.arange(INSTANTS) + 0.5) / INSTANTS)
    lengths = np.linalg.norm(np.diff(edges, axis=0), axis=1)
    return lengths @ middles / lengths.sum()
