"""Pictures of laws without a name: the curve with its uncertainty. Drawing only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.learned_part import LearnedPart, over_visited
from camid.diagnosis.report.panel import Panel, inline_svg, legend_above, new_panel
from camid.number_text import SPACE, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIGNIFICANCE = 2.0
# Axes of a law: what it is over, and what its values are.
AXES = {
    "position": ("position", "force"),
    "velocity": ("velocity", "force"),
    "damping over position": ("position", "damping"),
    "gain over position": ("position", "loss of gain"),
    "gain over velocity": ("velocity", "loss of gain"),
    "input": ("input", "bent by"),
    "reading": ("what the sensor sees", "bent by"),
}


def learned_pictures(diagnosis: Diagnosis) -> Iterator[Panel]:
    """A panel for each law, from the knots and values that diagnosis.json holds."""
    for part in diagnosis.learned:
        title = part.name
        beyond = "the plant is alone" if part.curve is None else "the formula goes on"
        most = f"{plain(part.largest, unit=part.unit)}".replace(SPACE, " ")
        caption = (
            f"Up to {most}. The band is two standard deviations. Beyond the knots the recording says nothing: {beyond}."
        )
        if part.visited is not None:
            caption += " Drawn over the middle 98 % of the rows: at the ends hardly a row says what the law is."
        if part.drawn:
            caption += " Formulas are drawn without the straight line that the plant's coefficients hold."
            if part.drawn[0].replaces:
                caption += " Both hold what named effects of the same variable carried of the law."
        if part.description:
            caption += f" In words: {part.description}."
        yield Panel(title, caption, inline_svg(_curve(part), title))


def _curve(part: LearnedPart) -> Axes:
    from camid import plotting as style

    learned = part.learned
    knots, heights, deviations = over_visited(part.visited, learned.knots, part.heights, learned.standard_deviations)
    over, across = AXES[part.variables]
    if part.drawn and part.drawn[0].replaces:
        # The whole law, with what named effects hold of it.
        heights = heights + np.interp(knots, part.drawn[0].points, part.drawn[0].carried)
    band = SIGNIFICANCE * deviations
    axes = new_panel(top=28.0)
    axes.fill_between(knots, heights - band, heights + band, color=style.BLUE, alpha=0.25, linewidth=0, label="± 2 σ")
    axes.plot(knots, heights, "-o", color=style.BLUE, linewidth=2.0, markersize=3.5, label="learned")
    looks = ((style.VERMILION, "--"), (style.BLACK, ":"), (style.GREEN, "-."))
    for formula, (colour, dashes) in zip(part.drawn, looks, strict=False):
        label = "formula" if part.formula is not None else formula.form
        whole = np.array(formula.values) + (np.array(formula.carried) if part.drawn[0].replaces else 0.0)
        points, whole = over_visited((knots[0], knots[-1]), formula.points, whole.tolist())
        axes.plot(points, whole, linestyle=dashes, color=colour, linewidth=2.0, label=label)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    across = f"{across}, {part.unit}" if part.unit else across
    axes.set(xlim=(knots[0], knots[-1]), xlabel=f"{over}, {part.knot_unit}", ylabel=across)
    legend_above(axes, 2 + len(part.drawn))
    return axes
