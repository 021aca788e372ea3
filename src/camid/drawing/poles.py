"""Poles and zeros in the complex plane with 95 % ellipses, and enlarged where an ellipse is too small to be seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from camid import plotting as style
from camid.drawing.lines import BAND_OPACITY, COLOURS, line_of, new_figure, range_of, short

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from camid.analysis.poles_and_zeros import PolesAndZeros, Root

# An ellipse smaller than this share of the map is enlarged; one that is larger than the map by this factor is cut.
SMALL_SHARE, LARGEST_SHARE = 0.03, 0.6
MOST_ENLARGED = 3
# Crosses and rings that differ from model to model, for grey print.
POLES, ZEROS = ("x", "+", "1", "2", "3", "4"), ("o", "s", "D", "^", "v", "p")
# Half width of an enlarged panel, in half axes of its largest ellipse, and within which roots share a panel.
ROOM, NEAR = 1.6, 12.0
# Names of rays that are nearer, as a share of the height, would touch.
LEAST_GAP = 0.035
DAMPING_RATIOS = (0.1, 0.3, 0.5, 0.7, 0.9)


def draw(result: PolesAndZeros) -> Figure:
    """The map, and beside it what is too small on it."""
    roots, names = result.roots, result.names
    limits = _limits(roots)
    groups = _enlarged(roots, limits)
    figure = new_figure(4.0 if groups else 4.4, style.PAGE_WIDTH if groups else 5.2)
    grid = figure.add_gridspec(max(len(groups), 1), 2 if groups else 1, width_ratios=(1.7, 1.0) if groups else None)
    axes = figure.add_subplot(grid[:, 0])
    _damping_rays(axes, limits)
    _draw_roots(axes, roots, names, label=True)
    axes.axhline(0.0, color=style.GREY, linewidth=0.6)
    axes.axvline(0.0, color=style.GREY, linewidth=0.6)
    axes.set(xlim=limits[0], ylim=limits[1], xlabel="real part, rad/s", ylabel="imaginary part, rad/s")
    known = any(r.covariance is not None for r in roots)
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=2,
        borderaxespad=0.2,
        title="with ellipses (on the real axis intervals) of 95 %" if known else None,
        alignment="left",
    )
    for row, group in enumerate(groups):
        panel = figure.add_subplot(grid[row, 1])
        _enlarge(panel, roots, names, group)
    return figure


def _limits(roots: Sequence[Root]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of the map: all roots, the origin, and ellipses that are not far larger."""
    points = np.array([0.0, *(r.value for r in roots)], dtype=complex)
    span = max(float(np.max(np.abs(points))), 1e-300)
    ellipses = [e for r in roots if (e := r.ellipse()) is not None]
    near = [e for e in ellipses if np.max(np.abs(e - e.mean())) < LARGEST_SHARE * span]
    every = np.concatenate([points, *near])
    real, imaginary = range_of([every.real], 0.12), range_of([every.imag], 0.12)
    if not np.any(points.imag):
        imaginary = (0.0, 0.0)
    wide = 0.15 * float(np.max(np.abs(points.real))) or 0.12 * span
    high = 0.12 * span
    return (min(real[0], -wide), max(real[1], wide)), (min(imaginary[0], -high), max(imaginary[1], high))


def _reach(root: Root) -> tuple[float, float]:
    """Half width and half height of a root's ellipse."""
    ellipse = root.ellipse()
    if ellipse is None:
        return 0.0, 0.0
    return float(np.max(np.abs((ellipse - root.value).real))), float(np.max(np.abs((ellipse - root.value).imag)))


def _enlarged(roots: Sequence[Root], limits: tuple[tuple[float, float], tuple[float, float]]) -> list[list[Root]]:
    """Groups of roots in the upper half plane whose ellipses are too small on the map."""
    width, height = limits[0][1] - limits[0][0], limits[1][1] - limits[1][0]
    groups: list[list[Root]] = []
    for root in roots:
        x, y = _reach(root)
        if root.value.imag < 0.0 or not 0.0 < max(x / width, y / height) < SMALL_SHARE:
            continue
        for group in groups:
            if abs(root.value - group[0].value) < NEAR * max(x, y, *(max(_reach(r)) for r in group)):
                group.append(root)
                break
        else:
            groups.append([root])
    return groups[:MOST_ENLARGED]


def _enlarge(axes: Axes, roots: Sequence[Root], names: Sequence[str], group: Sequence[Root]) -> None:
    wide, high = (ROOM * max(_reach(r)[i] for r in group) for i in (0, 1))
    high = high or wide
    low = min(r.value.real for r in group) - wide, min(r.value.imag for r in group) - high
    high_corner = max(r.value.real for r in group) + wide, max(r.value.imag for r in group) + high
    _draw_roots(axes, roots, names, label=False)
    axes.set(xlim=(low[0], high_corner[0]), ylim=(low[1], high_corner[1]))
    names_here = ", ".join(dict.fromkeys(short(r.model, 20) for r in group))
    axes.set_title(f"enlarged, rad/s: {names_here}", fontsize=7.0)
    axes.tick_params(labelsize=6.0)
    axes.locator_params(nbins=4)


def _draw_roots(axes: Axes, roots: Sequence[Root], names: Sequence[str], *, label: bool) -> None:
    """Crosses and circles with their ellipses."""
    for index, name in enumerate(names):
        colour = COLOURS[index % len(COLOURS)]
        for kind, markers in (("pole", POLES), ("zero", ZEROS)):
            marker = markers[index % len(markers)]
            own = [r for r in roots if r.model == name and r.kind == kind]
            if not own:
                continue
            values = np.array([r.value for r in own])
            axes.plot(
                values.real, values.imag, linestyle="", marker=marker, color=colour, zorder=3.0,
                markersize=6.5, markerfacecolor="none", markeredgewidth=1.3,
                label=f"{short(name)}: {kind}s" if label else None,
            )  # fmt: skip
            for root in own:
                ellipse = root.ellipse()
                if ellipse is None:
                    continue
                if root.is_real:
                    axes.plot(ellipse.real, ellipse.imag, color=colour, linewidth=3.0, alpha=0.5, zorder=2.0)
                    continue
                axes.fill(ellipse.real, ellipse.imag, color=colour, alpha=BAND_OPACITY, linewidth=0, zorder=2.0)
                axes.plot(ellipse.real, ellipse.imag, linewidth=0.9, zorder=2.2, **line_of(index))


def _damping_rays(axes: Axes, limits: tuple[tuple[float, float], tuple[float, float]]) -> None:
    """Lines of equal damping ratio, named at the edge."""
    left, top = -limits[0][0], limits[1][1]
    if limits[1][1] <= 0.2 * -limits[0][0]:
        return  # no pair of complex roots
    last = np.inf
    for ratio in DAMPING_RATIOS:
        x, y = ratio, float(np.sqrt(1.0 - ratio**2))
        size = min(left / x, top / y)
        for sign in (1.0, -1.0):
            axes.plot([0.0, -size * x], [0.0, sign * size * y], color="#D9D9D9", linewidth=0.5, zorder=0.8)
        height = 0.93 * size * y / (limits[1][1] - limits[1][0])
        if last - height < LEAST_GAP:
            continue
        last = height
        axes.annotate(
            f"ζ {ratio:g}", (-0.93 * size * x, 0.93 * size * y), fontsize=6.0, color="#505050", ha="center",
            va="center", zorder=0.9, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
        )  # fmt: skip
