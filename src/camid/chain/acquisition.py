"""Acquisition: how the input is held and how the sensor samples.

Time convention: frame k is delivered at t_k; w_k = (1/τ)∫ y dt over [t_k − ℓ − τ, t_k − ℓ] (instant sensor:
y(t_k − ℓ)); u_k is applied from t_k to t_{k+1}, held (zoh) or along a straight line to u_{k+1} (foh); before the first
sample u = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

HOLDS = ("zoh", "foh", "band-limited")
SENSORS = ("camera", "instant")
# Times that differ by less than this share of the period are the same instant.
SAME_INSTANT = 1e-9
PERIOD_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Acquisition:
    """How the input is held and how the output is sampled.

    Attributes
    ----------
    period : float
        Sampling period T in seconds.
    hold : {"zoh", "foh", "band-limited"}
        Intersample behaviour of the input. A band-limited one has passed a filter that leaves nothing above π/T; it is
        run as straight lines whose part below that is the same (:func:`straight_line_corners`).
    sensor : {"camera", "instant"}
        Mean over the exposure, or the value at one instant.
    exposure : float, optional
        τ in seconds, 0 < τ ≤ T; the period where it is not given. Ignored by an instant sensor.
    latency : float
        ℓ ≥ 0 in seconds.

    Raises
    ------
    ValueError
        If a value is outside its range.
    """

    period: float
    hold: str = "zoh"
    sensor: str = "camera"
    exposure: float | None = None
    latency: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.period) and self.period > 0.0):
            raise ValueError(f"period = {self.period} s: it must be positive")
        if self.hold not in HOLDS:
            raise ValueError(f"hold = {self.hold!r}: it must be one of {', '.join(HOLDS)}")
        if self.sensor not in SENSORS:
            raise ValueError(f"sensor = {self.sensor!r}: it must be one of {', '.join(SENSORS)}")
        if not (np.isfinite(self.latency) and self.latency >= 0.0):
            raise ValueError(f"latency = {self.latency} s: it must be zero or positive")
        exposure = self.period if self.exposure is None else self.exposure
        if not (np.isfinite(exposure) and exposure > 0.0):
            raise ValueError(f"exposure = {exposure} s: it must be positive (an instant sensor has kind: instant)")
        if exposure > self.period * (1.0 + PERIOD_TOLERANCE):
            raise ValueError(f"exposure = {exposure} s is longer than the period of {self.period:.9g} s")
        object.__setattr__(self, "exposure", min(exposure, self.period))

    def window(self) -> tuple[int, float, float, bool]:
        """Where the sensor's window lies on the grid of the input.

        Returns
        -------
        delay : int
            The window of frame k begins in the interval that starts at t_{k - delay}.
        start, length : float
            Start of the window after t_{k - delay}, and its length (0 for an instant sensor), in seconds.
        straddles : bool
            Whether it ends in the next interval of the input.
        """
        length = 0.0 if self.sensor == "instant" else float(self.exposure or 0.0)
        back = (self.latency + length) / self.period
        nearest = round(back)
        delay = nearest if abs(back - nearest) < SAME_INSTANT else ceil(back)
        start = max(delay - back, 0.0) * self.period
        if start < SAME_INSTANT * self.period:
            start = 0.0
        return delay, start, length, start + length > self.period * (1.0 + SAME_INSTANT)
