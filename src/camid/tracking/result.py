"""What tracking hands back: the recording, and what was found on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from camid.number_text import number, plain
from camid.tracking.clock import Clock, scatter
from camid.tracking.follow import Position

if TYPE_CHECKING:
    import pandas as pd

# Quality below which a warning says so.
LOW_QUALITY = 0.5
# Ratio of scatter to stated standard deviation above which a warning says so.
OVERCONFIDENT = 3.0
# Frames that a warning lists.
LISTED = 5


@dataclass(frozen=True)
class Track:
    """Positions of a marker in a clip.

    Attributes
    ----------
    table : DataFrame
        The recording, one row per frame with a marker: ``t`` in s, ``x``, ``y`` and their standard deviations
        ``x_std``, ``y_std`` in ``unit``, the other centroid (``x_gradient``, ``y_gradient`` or ``x_grey_level``,
        ``y_grey_level``), ``quality``, and ``repeated``, 1 for a copy of the frame before.

        ``quality`` is the smallest of three shares between 0 and 1: how much of the marker's contrast is above the
        threshold (noise), how much of the grey levels in the region is the marker's (other things), and the ratio of
        the marker's sum of grey levels to its median over the clip, or its inverse (hidden parts, merged things).

        The standard deviation is that of the noise of the pixels, propagated through the centroid. It holds neither
        the errors of a lossy codec, which smooths the noise, nor those of lens, light or marker.
    positions : list of Position
        The same in px of the image.
    source, marker, method, unit : str
        File, what was followed, whose centroid ``x`` and ``y`` are, unit of length.
    shape : (int, int)
        Height and width of the image in px.
    clock : Clock
        Time stamps of all frames, with or without a marker.
    without_marker : list of (int, float)
        Frames without a marker: number and time.
    notes : list of str
        What else a reader of the file should know.
    """

    table: pd.DataFrame
    positions: list[Position]
    source: str
    marker: str
    method: str
    unit: str
    shape: tuple[int, int]
    clock: Clock
    without_marker: list[tuple[int, float]]
    notes: list[str]

    @property
    def scatter(self) -> dict[str, float | None]:
        """Standard deviation in ``unit`` of what changes in x and y from frame to frame; None for too short a clip."""
        time = self.table["t"].to_numpy()
        found = {c: scatter(time, self.table[c].to_numpy(), self.clock.period) for c in "xy"}
        return {c: value if np.isfinite(value) else None for c, value in found.items()}

    def to_mapping(self) -> dict[str, Any]:
        """Summary for machines."""
        first, table = self.positions[0], self.table
        return {
            "schema": 1,
            "source": self.source,
            "marker": self.marker,
            "method": self.method,
            "unit": self.unit,
            "image": {"width": self.shape[1], "height": self.shape[0]},
            "frames": self.clock.frames,
            "rows": len(table),
            "start": float(table["t"].iloc[0]),
            "end": float(table["t"].iloc[-1]),
            "period": self.clock.period,
            "effective_rate": self.clock.effective_rate,
            "regular": self.clock.regular,
            "missing": {
                "count": self.clock.missing if self.clock.regular else None,
                "gaps": [{"after": t, "count": n} for t, n in self.clock.gaps],
            },
            "without_marker": [{"frame": k, "time": t} for k, t in self.without_marker],
            "repeated": [float(t) for t in table["t"][table["repeated"] == 1]],
            "first_region": dict(zip(("x", "y", "width", "height"), first.region, strict=True)),
            "median_standard_deviation": {c: float(np.median(table[f"{c}_std"])) for c in "xy"},
            "scatter": self.scatter,
            "pixel_noise": float(np.median([p.noise for p in self.positions])),
            "quality": {"median": float(np.median(table["quality"])), "lowest": float(table["quality"].min())},
            "warnings": self.warnings(),
        }

    def summary(self) -> list[str]:
        """Lines for people."""
        table, clock = self.table, self.clock
        x, y, width, height = (round(v) for v in self.positions[0].region)
        std = ", ".join(f"{c} {plain(np.median(table[f'{c}_std']), 2)} {self.unit}" for c in "xy")
        scattered = ", ".join(
            f"{c} –" if v is None else f"{c} {plain(v, 2)} {self.unit}" for c, v in self.scatter.items()
        )
        noise = plain(np.median([p.noise for p in self.positions]), 2)
        lowest = int(np.argmin(table["quality"]))
        missing = f"{clock.missing} missing in the file" if clock.regular else "irregular time stamps"
        return [
            f"followed: {self.marker}, first in the region {x} {y} {width} {height} px; {self.method} centroid",
            f"frames: {len(table)} with the marker of {clock.frames}; {missing}, {len(self.without_marker)} without "
            f"the marker, {int(table['repeated'].sum())} repeated",
            f"rate: {plain(clock.effective_rate, 6)} frames/s effective, {plain(1.0 / clock.period, 6)} by the median "
            f"step; t = {plain(table['t'].iloc[0], 6)} to {plain(table['t'].iloc[-1], 6)} s",
            f"standard deviation (median): {std}, from a noise of {noise} grey levels",
            f"scatter from frame to frame: {scattered}, from the fourth differences of the positions",
            f"quality: {number(np.median(table['quality']), 2)} (median), {number(table['quality'].min(), 2)} (lowest, "
            f"at t = {plain(table['t'].iloc[lowest], 6)} s)",
        ]

    def warnings(self) -> list[str]:
        """One sentence for each thing that a user of the recording has to know."""
        found = list(self.notes)
        clock, table = self.clock, self.table
        if not clock.regular:
            found.append(
                f"the time stamps are irregular (median step {plain(clock.period, 6)} s); they are kept as they are"
            )
        if clock.missing:
            where = ", ".join(f"{n} after t = {plain(t, 6)} s" for t, n in clock.gaps[:LISTED])
            more = ", …" if len(clock.gaps) > LISTED else ""
            found.append(f"{_frames(clock.missing)} missing between the time stamps: {where}{more}")
        if self.without_marker:
            found.append(
                f"{_frames(len(self.without_marker))} without the marker: "
                f"t = {_listed([t for _, t in self.without_marker])} s"
            )
        repeated = table["t"][table["repeated"] == 1].tolist()
        if repeated:
            found.append(f"{_frames(len(repeated))} repeated: t = {_listed(repeated)} s")
        for c, value in self.scatter.items():
            stated = float(np.median(table[f"{c}_std"]))
            if value is not None and value > OVERCONFIDENT * stated:
                found.append(
                    f"{c} scatters by {plain(value, 2)} {self.unit} from frame to frame, {c}_std is {plain(stated, 2)} "
                    f"{self.unit}: compression, light or a fast motion"
                )
        low = table["t"][table["quality"] < LOW_QUALITY].tolist()
        if low:
            found.append(f"{_frames(len(low))} of a quality below {plain(LOW_QUALITY)}: t = {_listed(low)} s")
        return found


def _frames(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"


def _listed(times: list[float]) -> str:
    shown = ", ".join(plain(t, 6) for t in times[:LISTED])
    return shown + (", …" if len(times) > LISTED else "")
