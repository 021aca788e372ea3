"""Pictures of laws without a name: the curve with its uncertainty. Drawing only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from camid.diagnosis.diagnosis import Diagnosis, LearnedPart
from camid.diagnosis.report.panel import Panel, inline_svg, legend_above, new_panel
from camid.number_text import printable, unit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIGNIFICANCE = 2.0
NAMES = {"position": "position", "velocity": "velocity", "input": "input", "reading": "what the sensor sees"}


def learned_pictures(diagnosis: Diagnosis) -> Iterator[Panel]:
    """A panel for each law, from the knots and values that diagnosis.json holds."""
    for part in diagnosis.learned:
        across = "force" if part.identifier == "learned-force" else "bent by"
        title = f"{part.title} over the {part.variables}"
        caption = "The band is two standard deviations. Beyond its ends the recording says nothing: the plant is alone."
        yield Panel(title, caption, inline_svg(_curve(part, across, diagnosis), title))


def _curve(part: LearnedPart, across: str, diagnosis: Diagnosis) -> Axes:
    from camid import plotting as style

    names = diagnosis.improved.symbols
    knots, values = np.array(part.knots), np.array(part.values)
    heights = values - knots if across == "bent by" else values
    band = SIGNIFICANCE * np.array(part.standard_deviations)
    axes = new_panel(top=28.0)
    axes.fill_between(knots, heights - band, heights + band, color=style.BLUE, alpha=0.25, linewidth=0, label="± 2 σ")
    axes.plot(knots, heights, "-o", color=style.BLUE, linewidth=2.0, markersize=3.5, label="learned")
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    unit, knot_unit = (printable(unit_of(u, *names)) for u in (part.unit, part.knot_unit))
    axes.set(xlim=(knots[0], knots[-1]), xlabel=f"{NAMES[part.variables]}, {knot_unit}", ylabel=f"{across}, {unit}")
    legend_above(axes, 2)
    return axes
