"""The picture of a design: the input, what each hypothesis predicts, and how the evidence grows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camid.experiment_design.columns import Columns
from camid.experiment_design.result import Design
from camid.number_text import printable
from camid.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Names that are drawn, and the least evidence of the axis, which is logarithmic.
MOST_DRAWN, LEAST_EVIDENCE = 4, 0.1
# Limits of the travel farther out than this many times the motion are not drawn.
NEAR = 2.0
STYLES = ("-", "--", "-.", ":")


def _draw_travel(design: Design, axes: Axes, colour: str) -> None:
    """The limits of the travel, where the motion comes near enough to them to be seen beside them."""
    travel = design.limits.travel
    if travel is None:
        return
    low, high = design.travel
    outputs = Columns.of(design.hypotheses[0].simulation).outputs
    for limit in travel:
        if abs(limit) <= NEAR * max(abs(low), abs(high)):
            axes.axhline(float(outputs.cells(np.array(limit))), color=colour, linewidth=0.6, linestyle=(0, (1, 2)))


def _label(what: str, column: str, unit: str) -> str:
    return f"{what} {printable(column)}" + ("" if unit == printable(column) else f", {unit}")


def draw_design(design: Design, target: Path) -> None:
    """Draw a design into a PNG file.

    Parameters
    ----------
    design : Design
    target : Path
    """
    from camid import plotting
    from camid.drawing.lines import legend_above

    plotting.apply()
    import matplotlib.pyplot as plt

    simulation = design.hypotheses[0].simulation
    colours = (plotting.BLUE, plotting.VERMILION, plotting.GREEN, plotting.ORANGE)
    time = design.played.period * np.arange(len(design.played.signal))
    columns = Columns.of(simulation)
    signal = columns.inputs.cells(design.played.signal)
    panels = 3 if design.growth else 2
    figure, axes = plt.subplots(panels, 1, figsize=(plotting.PAGE_WIDTH, 1.7 * panels), sharex=True)
    step = "post" if simulation.hold == "zoh" else None
    if step is None:
        axes[0].plot(time, signal, color=plotting.BLACK, linewidth=0.8)
    else:
        axes[0].step(time, signal, where="post", color=plotting.BLACK, linewidth=0.8)
    axes[0].set_ylabel(_label("input", columns.signal, columns.input_unit))
    axes[0].set_title(f"{design.kind}, {design.duration:.3g} s", loc="left")
    for i, (name, output) in enumerate(list(design.outputs.items())[:MOST_DRAWN]):
        axes[1].plot(time, columns.outputs.cells(output), STYLES[i], color=colours[i], linewidth=0.9, label=name)
    axes[1].set_ylabel(_label("predicted", columns.output, columns.output_unit))
    _draw_travel(design, axes[1], plotting.GREY)
    legend_above(axes[1])
    for i, (name, evidence) in enumerate(list(design.growth.items())[:MOST_DRAWN]):
        label = f"if {name} is right"
        shown = np.maximum(evidence, LEAST_EVIDENCE)
        axes[2].semilogy(design.growth_times, shown, STYLES[i], color=colours[i], label=label)
    if design.growth:
        axes[2].set_ylabel("ΔBIC to nearest rival")
        legend_above(axes[2])
    axes[-1].set_xlabel("time in s")
    figure.align_ylabels(axes)
    write_whole(target, lambda path: figure.savefig(path, format="png", metadata={"Software": None}))
    plt.close(figure)
