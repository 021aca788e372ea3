"""What the user says of a clip: what the marker looks like, where it is, and how long a pixel is."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import hypot
from typing import Any

Point = tuple[float, float]

APPEARANCES = {
    "moving": "whatever moves",
    "colour": "a colour",
    "bright": "the brightest thing",
    "dark": "the darkest thing",
}
# What a click on the image means.
CLICKS = {
    "region": "Region: two opposite corners around the marker",
    "colour": "Colour: a point on the marker",
    "scale": "Scale: two points whose distance you know",
    "origin": "Origin: the point that becomes 0, 0",
}


@dataclass
class Marker:
    """Options of ``camid track``, as they are chosen by clicks and in fields.

    Positions are in px of the image as a browser counts them: 0 is the left border of the first pixel. In camid 0 is
    its centre; :meth:`options` takes off the half.

    Attributes
    ----------
    appearance : str
        One of `APPEARANCES`.
    colour : str
        ``#rrggbb``, or a name.
    region : (int, int, int, int) or None
        Left, top, width, height.
    ends : list of (float, float)
        Of the line whose length is known: none, one or two.
    length : float or None
        Of that line, in ``unit``.
    unit : str
    origin : (float, float) or None
    upwards : bool
    start, end, frame_rate : float or None
    """

    appearance: str = "moving"
    colour: str = ""
    region: tuple[int, int, int, int] | None = None
    corner: Point | None = None
    ends: list[Point] = field(default_factory=list)
    length: float | None = None
    unit: str = "mm"
    origin: Point | None = None
    upwards: bool = False
    start: float | None = None
    end: float | None = None
    frame_rate: float | None = None

    def click(self, meaning: str, x: float, y: float, colour: str = "") -> bool:
        """Take a click on the image; whether another one is needed to complete what it began.

        Parameters
        ----------
        meaning : str
            One of `CLICKS`.
        x, y : float
            In px as a browser counts them.
        colour : str
            Of the image there, ``#rrggbb``.
        """
        if meaning == "colour":
            self.appearance, self.colour = "colour", colour
        elif meaning == "origin":
            self.origin = (x, y)
        elif meaning == "scale":
            self.ends = [*self.ends, (x, y)] if len(self.ends) == 1 else [(x, y)]
            return len(self.ends) == 1
        elif self.corner is None:
            self.corner = (x, y)
            return True
        else:
            left, right = sorted((int(self.corner[0]), int(x)))
            top, bottom = sorted((int(self.corner[1]), int(y)))
            self.region, self.corner = (left, top, right - left + 1, bottom - top + 1), None
        return False

    @property
    def pixels(self) -> float | None:
        """Length of the line in px; None without two different ends."""
        if len(self.ends) != 2:
            return None
        (x0, y0), (x1, y1) = self.ends
        return hypot(x1 - x0, y1 - y0) or None

    @property
    def scale(self) -> float | None:
        """Units of length per px; None without a line and its length."""
        return self.length / self.pixels if self.length and self.pixels else None

    def options(self) -> dict[str, Any]:
        """What is said, as :class:`camid.tracking.options.Options` and ``camid track`` name it."""
        chosen: dict[str, Any] = {}
        if self.appearance == "colour":
            chosen["colour"] = self.colour or "red"
        elif self.appearance != "moving":
            chosen[self.appearance] = True
        if self.scale is not None:
            chosen |= {"scale": float(f"{self.scale:.9g}"), "unit": self.unit}
        if self.origin is not None:
            chosen["origin"] = [round(v - 0.5, 3) for v in self.origin]
        for name in ("region", "start", "end", "frame_rate", "upwards"):
            if (value := getattr(self, name)) not in (None, False):
                chosen[name] = list(value) if isinstance(value, tuple) else value
        return chosen

    def arguments(self) -> list[str]:
        """The same as options of the command line."""
        arguments = []
        for name, value in self.options().items():
            values = [] if value is True else value if isinstance(value, list) else [value]
            arguments += [f"--{name.replace('_', '-')}", *(str(v) for v in values)]
        return arguments
