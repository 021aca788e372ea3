"""The forces that real recordings show by themselves, beside the laws that a diagnosis found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camid.commands.simulate import simulate
from camid.effects.learned import LearnedForce
from camid.identification.from_recordings import load_recordings
from camid.real_recordings.results import Results
from camid.recording.recording import Recording

Array = NDArray[np.float64]

BINS = 40
FEWEST_IN_A_BIN = 10
# Highest frequency up to which the Silverbox's motion is differentiated; rows and order of the local polynomials of the
# others. The drive moves smoothly, and the encoder of the pendulum has coarse steps.
SILVERBOX_BAND = 280.0  # Hz
EMPS_FILTER = (61, 3)
PENDULUM_FILTER = (31, 4)
# Shortest way of two swings, in rad, in which the height that is lost shows beyond the encoder's steps.
SHORTEST_PATH = 0.2
EDGE = 100  # rows at each end of a recording where derivatives are bad


@dataclass(frozen=True)
class Law:
    """A force (or a residual) against what it depends on.

    Attributes
    ----------
    position, middle, low, high : ndarray, shape (n,)
        Bins or swings of the recording: abscissa, median and quartiles; without spread ``low`` and ``high`` are empty.
    curves : dict of str to (ndarray, ndarray)
        Laws by name, ``improved`` or ``refitted``, or ``named``: the improved one without the learned forces that it
        may hold.
    abscissa, ordinate, title : str
        Labels with units.
    """

    position: Array
    middle: Array
    low: Array
    high: Array
    curves: dict[str, tuple[Array, Array]]
    abscissa: str
    ordinate: str
    title: str


def law(results: Results) -> Law:
    """The law of the strongest effect of a recording, or where the remainder is."""
    return LAWS[results.name](results)


def _learned(results: Results, variable: str, values: Array) -> Array | None:
    """Sum of the learned forces over the position or the velocity, shape (n,); None where there is none."""
    forces = [e.parameters for e in results.improved.effects if e.identifier == LearnedForce.identifier]
    laws = [np.interp(values, f["knots"], f["values"]) for f in forces if f["variables"] == variable]
    return np.sum(laws, axis=0) if laws else None


def _with_learned(
    grid: Array, named: Array, learned: Array | None, unit: float = 1.0
) -> dict[str, tuple[Array, Array]]:
    """The curve of a named law and, where a force was learned beside it, that of both."""
    if learned is None:
        return {"improved": (grid, named)}
    return {"named": (grid, named), "improved": (grid, named + unit * learned)}


def _recorded(results: Results) -> Recording:
    return load_recordings(results.recording, results.improved, output_needed=True)[0]


def _binned(abscissa: Array, force: Array) -> tuple[Array, Array, Array, Array]:
    """Medians of bins of equal width, and the quartiles of the force."""
    edges = np.linspace(abscissa.min(), abscissa.max(), BINS + 1)
    members = np.digitize(abscissa, edges)
    full = [i for i in range(1, BINS + 1) if np.count_nonzero(members == i) >= FEWEST_IN_A_BIN]
    quartiles = np.array([np.quantile(force[members == i], (0.25, 0.5, 0.75)) for i in full])
    centres = np.array([np.median(abscissa[members == i]) for i in full])
    return centres, quartiles[:, 1], quartiles[:, 0], quartiles[:, 2]


def _smoothed(values: Array, window: tuple[int, int], period: float) -> list[Array]:
    """Values and their first two derivatives by local polynomials (Savitzky & Golay 1964)."""
    from scipy.signal import savgol_filter

    return [savgol_filter(values, *window, deriv=order, delta=period) for order in range(3)]


def _silverbox(results: Results) -> Law:
    """Spring force beyond the linear one, from the equation of motion with the improved coefficients."""
    recorded, improved = _recorded(results), results.improved
    count = len(recorded)
    angular = 2j * np.pi * np.fft.rfftfreq(count, recorded.period)
    band = np.abs(angular) < 2.0 * np.pi * SILVERBOX_BAND
    position = recorded.columns[improved.output_column] - improved.known_offset
    motion, driven = (np.fft.rfft(v) * band for v in (position, recorded.columns[str(improved.input_column)]))
    output, velocity, acceleration = (np.fft.irfft(motion * angular**k, count) for k in range(3))
    force = np.fft.irfft(driven, count) + results.parameter("input-bias", "bias")
    b0, a1, a0 = (results.coefficient(c, "improved")[0] for c in ("b0", "a1", "a0"))
    rest = force - (acceleration + a1 * velocity + a0 * output) / b0
    inner = slice(EDGE, -EDGE)
    points = _binned(1e3 * output[inner], 1e3 * rest[inner])
    grid = np.linspace(points[0][0], points[0][-1], 200)
    spring = results.parameter("cubic-stiffness", "coefficient") * 1e-6 * grid**3
    spring += results.parameter("cubic-stiffness", "quadratic") * 1e-3 * grid**2
    return Law(
        *points,
        _with_learned(grid, spring, _learned(results, "position", 1e-3 * grid), 1e3),
        "position V2 (mV)",
        "spring force beyond\nthe linear one (mV)",
        "the law, and what the recording says",
    )


def _emps(results: Results) -> Law:
    """Friction beyond the viscous, from the equation of motion with the improved coefficients."""
    recorded, improved = _recorded(results), results.improved
    _, velocity, acceleration = _smoothed(recorded.columns[improved.output_column], EMPS_FILTER, recorded.period)
    force = recorded.columns[str(improved.input_column)] + results.parameter("input-bias", "bias")
    (b0, _), (a1, _) = results.coefficient("b0", "improved"), results.coefficient("a1", "improved")
    friction = force - (acceleration + a1 * velocity) / b0
    inner = slice(EDGE, -EDGE)
    points = _binned(1e3 * velocity[inner], friction[inner])
    coulomb = results.parameter("coulomb-friction", "force")
    tiny = 1e-9 * points[0][-1]
    grid = np.concatenate([np.linspace(points[0][0], -tiny, 200), np.linspace(tiny, points[0][-1], 200)])
    return Law(
        *points,
        _with_learned(grid, coulomb * np.sign(grid), _learned(results, "velocity", 1e-3 * grid)),
        "velocity (mm/s)",
        "friction beyond\nthe viscous (N)",
        "the law, and what the recording says",
    )


def _stribeck(results: Results, velocity: Array) -> Array | None:
    """Friction that falls with the speed and turns round gradually; None where none is named."""
    coulomb, breakaway, falls, turns = (
        results.parameter("stribeck-friction", name) for name in ("coulomb", "breakaway", "velocity", "transition")
    )
    if not falls:
        return None
    level = coulomb + (breakaway - coulomb) * np.exp(-((velocity / falls) ** 2))
    return np.asarray(level * (np.tanh(velocity / turns) if turns else np.sign(velocity)))


def _pendulum_decay(results: Results) -> Law:
    """Mean friction of each swing, from the height lost in it, against the mean square over the mean speed.

    The height lost over the path is the mean friction: viscous damping alone is a line through the origin, and Coulomb
    friction lifts it.
    """
    from scipy.signal import find_peaks

    recorded, improved = _recorded(results), results.improved
    assert improved.pendulum is not None
    angle, velocity, _ = _smoothed(recorded.columns[improved.output_column], PENDULUM_FILTER, recorded.period)
    deflection = angle - improved.pendulum.rest
    turns = np.sort(np.concatenate([find_peaks(deflection, height=0.0)[0], find_peaks(-deflection, height=0.0)[0]]))
    heights = -np.cos(deflection[turns])
    path = np.abs(np.diff(deflection[turns]))
    swings = list(pairwise(turns))
    squared = np.array([np.sum(velocity[a:b] ** 2) * recorded.period for a, b in swings])
    # What a force over the position takes in a swing it gives back in the next.
    learned, falling = _learned(results, "velocity", velocity), _stribeck(results, velocity)
    parts = [part for part in (learned, falling) if part is not None]
    force = sum(parts) if parts else None
    power = np.zeros(len(velocity)) if force is None else force * velocity
    taken = np.array([np.sum(power[a:b]) * recorded.period for a, b in swings])
    # Two halves at a time: an angle at rest that is off by little makes one side higher and the other lower.
    path, squared, taken = (v[1:] + v[:-1] for v in (path, squared, taken))
    lost = heights[:-2] - heights[2:]
    long = path > SHORTEST_PATH
    speed, friction = (squared / path)[long], (lost / path)[long]
    curves = {}
    grid = np.array([0.0, float(speed.max())])
    for model, coulomb in (("refitted", 0.0), ("improved", results.parameter("coulomb-friction", "force"))):
        (a1, _), (a0, _) = results.coefficient("a1", model), results.coefficient("a0", model)
        curves[model] = (grid, 1e3 * (coulomb + a1 / a0 * grid))
    if force is not None:
        straight = curves.pop("improved")
        if learned is not None:
            curves["named"] = straight
        order = np.argsort(speed)
        named = np.interp(speed, *straight)
        curves["improved"] = (speed[order], (named + 1e3 * (taken / path)[long])[order])
    none = np.zeros(0)
    return Law(
        speed,
        1e3 * friction,
        none,
        none,
        curves,
        "∫v² dt / ∫|v| dt of a swing (rad/s)",
        "mean friction (10⁻³ rad)",
        "the law, and each swing",
    )


def _pendulum_clip(results: Results) -> Law:
    """Residual of the refitted simulation against the position: where the rest sits."""
    table = results.residuals
    none = np.zeros(0)
    return Law(
        table["recorded"].to_numpy(),
        table["residual_refitted"].to_numpy(),
        none,
        none,
        {},
        "recorded position x (px)",
        "residual of the\nrefitted (px)",
        "where the rest sits: even in x",
    )


def _coupled_drives(results: Results) -> Law:
    """What the counter says against the speed of the improved simulation without its last stage.

    The drives start from rest, so that the speed needs no recorded output and keeps its sign.
    """
    improved = results.improved
    before = tuple(e for e in improved.effects if e.identifier != "absolute-value")
    signed = simulate(results.recording, replace(improved, effects=before, initial_state="zero"))
    speed = signed["simulated"].to_numpy() - improved.known_offset
    ends: Array = np.array([speed.min(), 0.0, speed.max()])
    none = np.zeros(0)
    return Law(
        speed,
        signed[improved.output_column].to_numpy(),
        none,
        none,
        {"refitted": (ends[[0, -1]], ends[[0, -1]]), "improved": (ends, np.abs(ends) + improved.known_offset)},
        "speed, simulated with its sign (a.u.)",
        "speed as counted (a.u.)",
        "the law, and what the recording says",
    )


def _cascaded_tanks(results: Results) -> Law:
    """Residual of the refitted simulation against the level, in both records: where the rest sits."""
    table = results.residuals
    return Law(
        *_binned(table["recorded"].to_numpy(), table["residual_refitted"].to_numpy()),
        {},
        "recorded level (V)",
        "residual of the\nrefitted (V)",
        "where the rest sits",
    )


LAWS: dict[str, Callable[[Results], Law]] = {
    "silverbox": _silverbox,
    "emps": _emps,
    "pendulum_decay": _pendulum_decay,
    "pendulum_clip": _pendulum_clip,
    "pendulum2_decay": _pendulum_decay,
    "coupled_drives": _coupled_drives,
    "cascaded_tanks": _cascaded_tanks,
}
