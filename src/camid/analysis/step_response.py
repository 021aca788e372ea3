"""Step responses of models with bands: linear ones by python-control, others by the engine.

A step from rest at t = 0 goes into the plant's input; what is shown is the motion, before any sensor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from camid.analysis.linear_model import (
    NO_BAND,
    ONLY_DEVIATIONS,
    SMALL,
    UNCORRELATED,
    LinearModel,
    is_linear,
    rests_at_start,
)
from camid.analysis.spread import has_covariance, states_accuracy, varied
from camid.analysis.step_times import StepTimes, step_times
from camid.analysis.view import ShortTable, View, common_mapping
from camid.chain.plant import TransferFunction
from camid.effects.declared import effects_of
from camid.errors import InputError
from camid.fitting.simulated_output import simulated_output
from camid.identification.from_recordings import load_recordings
from camid.number_text import plain, with_deviation
from camid.physical.equations import plant_function
from camid.recording.options import Reading
from camid.simulation.declared_units import DeclaredUnits
from camid.simulation.model import Simulation
from camid.writing import without_infinities

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Of a standard deviation, what a simulation is moved by for the band.
WHOLE = 1.0
# Limits of rise and settling, as shares of the final value.
RISE, SETTLED = (0.1, 0.9), 0.02
# Of nonlinear plants, whose final value is where they have come to rest, more is shown than of linear ones.
LONGER = 1.6
# A motion whose last tenth still changes by more of its span has no final value yet.
STILL_MOVING = 0.02
# A motion that is a smaller share of the linear one is how friction and dead zones creep in the engine: none.
STILL = 1e-9
# Less than this share of the final value is rounding.
ROUNDING = 1e-6
PLACES = ("actuator", "plant")

TOO_UNCERTAIN = "without a band, as a standard deviation away from it no such plant can be run"


@dataclass(frozen=True)
class StepCurve:
    """Step response of a model.

    Attributes
    ----------
    name : str
    time : ndarray, shape (N,)
        Seconds.
    output : ndarray, shape (N,)
        In units of y.
    deviation : ndarray, shape (N,), or None
        Standard deviation.
    characteristics : dict of str to (float, float or None)
        ``final_value`` (y), ``rise_time`` (s, from 10 to 90 %), ``overshoot`` (a share), ``peak_time`` (s) and
        ``settling_time`` (s, within 2 %) with standard deviations; those that it has.
    linear : bool
        Whether it is proportional to the step.
    """

    name: str
    time: Array
    output: Array
    deviation: Array | None
    characteristics: dict[str, tuple[float, float | None]]
    linear: bool


def step_curve(model: LinearModel, times: StepTimes, amplitude: float) -> StepCurve:
    """Step response of a model at times from zero on.

    Raises
    ------
    InputError
        If the engine cannot run it.
    """
    alone = _plant_alone(model.simulation)
    if alone is None:
        return _linear(model, times, amplitude)
    physical = alone.physical
    if physical is not None and physical.equations is not None:
        equations = physical.equations
        if not plant_function(equations).depends_on(equations.input):
            raise InputError(
                "no equation depends on the input, so a step of it moves nothing",
                where=model.simulation.source,
                hint="camid compare shows how it moves by itself",
            )
    if not rests_at_start(model.simulation):
        raise InputError(
            "a step is from rest, and the plant does not rest where its equations start",
            where=model.simulation.source,
            hint="under start, give a state at which no state changes without input",
        )
    scale = float(np.max(np.abs(_by_control(model.plant, times, amplitude)[1])))

    def moved(simulation: Simulation) -> Array:
        output = times.sampled(lambda grid: _by_engine(simulation, grid, amplitude))[1]
        return output if np.max(np.abs(output)) > STILL * scale else np.zeros_like(output)

    time, output = _by_control(model.plant, times, 0.0)[0], moved(alone)
    try:
        spreads = [(moved(a), moved(b)) for a, b in varied(alone, WHOLE)]
    except (ValueError, ArithmeticError):  # a deviation away there is no such plant
        spreads = []
    return _curve(model.name, time, output, spreads, WHOLE, None, linear=False)


def _linear(model: LinearModel, times: StepTimes, amplitude: float) -> StepCurve:
    time, output = _by_control(model.plant, times, amplitude)
    spreads = []
    finals = []
    for direction in () if model.factor is None else model.factor.T:
        ends = [model.moved(direction, side * SMALL) for side in (1.0, -1.0)]
        spreads.append((_by_control(ends[0], times, amplitude)[1], _by_control(ends[1], times, amplitude)[1]))
        finals.append((amplitude * ends[0].static_gain(), amplitude * ends[1].static_gain()))
    stable = bool(np.all(model.plant.poles().real < 0.0))
    final = (amplitude * model.plant.static_gain(), finals) if stable else None
    return _curve(model.name, time, output, spreads, SMALL, final, linear=True)


def _by_control(plant: TransferFunction, times: StepTimes, amplitude: float) -> tuple[Array, Array]:
    """Times and outputs."""
    import control

    system = plant.to_control()
    return times.sampled(lambda grid: amplitude * np.asarray(control.step_response(system, grid).outputs).ravel())


def _curve(
    name: str,
    time: Array,
    output: Array,
    spreads: list[tuple[Array, Array]],
    share: float,
    final: tuple[float, list[tuple[float, float]]] | None,
    *,
    linear: bool,
) -> StepCurve:
    """The curve with its band, from the responses to both sides of each direction."""
    value = _final_value(time, output) if final is None and not linear else None if final is None else final[0]
    found = _characteristics(time, output, value, linear=linear)
    sides: list[tuple[dict[str, float], dict[str, float]]] = []
    for i, (there, back) in enumerate(spreads):
        ends = final[1][i] if final is not None else (_final_value(time, there), _final_value(time, back))
        ends = ends if value is not None else (None, None)
        curves = zip((there, back), ends, strict=True)
        first, second = (_characteristics(time, curve, end, linear=linear) for curve, end in curves)
        sides.append((first, second))
    stated: dict[str, tuple[float, float | None]] = {}
    for key, number in found.items():
        changes = [(a[key] - b[key]) / (2.0 * share) for a, b in sides if key in a and key in b]
        known = bool(changes) and len(changes) == len(sides)
        stated[key] = number, float(np.linalg.norm(changes)) if known else None
    table = np.array([(a - b) / (2.0 * share) for a, b in spreads])
    return StepCurve(name, time, output, np.sqrt(np.sum(table**2, axis=0)) if spreads else None, stated, linear)


def _final_value(time: Array, output: Array) -> float | None:
    """Where a motion has come to rest; None where it has not."""
    tail = output[time >= 0.9 * time[-1]]
    return float(tail[-1]) if np.ptp(tail) <= STILL_MOVING * max(float(np.ptp(output)), 1e-300) else None


def _characteristics(time: Array, output: Array, final: float | None, *, linear: bool) -> dict[str, float]:
    """What engineers read off a step response, between the points of its grid.

    python-control's ``step_info`` ends at points of the grid, and standard deviations may be smaller than its steps. A
    spline of a motion that sticks would swing past its kinks: of a nonlinear one it keeps the shape.
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator

    if final is None or not np.isfinite(final):
        return {}
    if final == 0.0:  # nothing is a share of it
        return {"final_value": 0.0}
    curve = (CubicSpline if linear else PchipInterpolator)(time, output / final)
    found = {"final_value": final}
    low, high = (_crossings(curve, level) for level in RISE)
    if len(low) and len(high):
        found["rise_time"] = float(high[0] - low[0])
    peaks = curve.derivative().roots(extrapolate=False)
    peaks = peaks[np.isfinite(peaks)]
    if len(peaks) and np.max(curve(peaks)) > 1.0 + ROUNDING:
        highest = int(np.argmax(curve(peaks)))
        found["overshoot"], found["peak_time"] = float(curve(peaks[highest]) - 1.0), float(peaks[highest])
    if abs(float(curve(time[-1])) - 1.0) < SETTLED:
        edges = np.concatenate([_crossings(curve, 1.0 + side * SETTLED) for side in (1.0, -1.0)])
        found["settling_time"] = float(np.max(edges, initial=0.0))
    return found


def _crossings(curve: Any, level: float) -> Array:
    """Times at which a spline crosses a level, ascending."""
    times = np.asarray(curve.solve(level, extrapolate=False), dtype=float)
    times = np.sort(times[np.isfinite(times)])
    # Where a spline is flat but for rounding, its polynomials have roots that are none.
    return times[np.abs(curve(times) - level) < ROUNDING]


def _plant_alone(simulation: Simulation) -> Simulation | None:
    """A nonlinear plant with its actuator, at rest and seen at once; None where all of it is linear."""
    kept = tuple(
        declared
        for declared, effect in zip(simulation.effects, effects_of(simulation), strict=True)
        if effect.place in PLACES and not effect.noise_like and not effect.corrects_declaration
    )
    linear = all(map(is_linear, effects_of(replace(simulation, effects=kept))))
    pendulum, physical = simulation.pendulum, simulation.physical
    if pendulum is None and (physical is None or physical.equations is None) and linear:
        return None
    return replace(
        simulation,
        time_column="t",
        input_column="u",
        output_column="y",
        output_columns=(),
        hold="zoh",
        sensor="instant",
        exposure=None,
        latency=0.0,
        skew=0.0,
        offset=None,
        bias=None,
        initial_state="zero",
        controller=None,
        observer=None,
        effects=kept,
        reading=Reading(),
        pendulum=None if pendulum is None else replace(pendulum, rest=0.0),  # angles from rest
    )


def remarks_of_step(model: LinearModel, curve: StepCurve) -> tuple[str, ...]:
    """What is to be known of a step response, a sentence each."""
    alone = _plant_alone(model.simulation)
    if alone is None:
        return (*model.linearised, *model.remarks)
    physical = model.simulation.physical
    equations = None if physical is None else physical.equations
    begin = "rest" if equations is None or not any(equations.start) else "the start of its equations"
    said = f"{model.name}: nonlinear, run as it is from {begin}: another amplitude has another shape"
    left_out = [e.identifier for e in model.simulation.effects if e not in alone.effects]
    said += f"; without {', '.join(left_out)}" if left_out else ""
    if not np.any(curve.output):
        said += "; this step does not move it"
    if curve.deviation is None and states_accuracy(alone):
        return said, *model.others, f"{model.name}: {TOO_UNCERTAIN if has_covariance(alone) else ONLY_DEVIATIONS}"
    if any(effect.standard_deviations for effect in alone.effects):
        return said, *model.others, f"{model.name}: {UNCORRELATED}"
    return said, *model.others, *([f"{model.name}: {NO_BAND}"] if curve.deviation is None else [])


def _by_engine(simulation: Simulation, time: Array, amplitude: float) -> Array:
    import pandas as pd

    if simulation.pendulum is not None:  # how sure its rest is does not matter to angles from it
        simulation = replace(simulation, pendulum=replace(simulation.pendulum, rest=0.0))
    table = pd.DataFrame({"t": time, "u": np.full(len(time), amplitude)})
    recording = load_recordings(table, simulation, output_needed=False)[0]
    output, _ = simulated_output(simulation, recording)
    if not np.all(np.isfinite(output)):
        raise InputError("its step response exceeds every number", where=simulation.source, hint="a smaller step?")
    return output


def times_for(models: list[LinearModel], duration: float | None) -> StepTimes:
    """Times from zero on: as long as python-control takes for the slowest model, or as asked for."""
    import control

    if duration is None:
        linear = [float(control.step_response(m.plant.to_control()).time[-1]) for m in models]
        nonlinear = any(_plant_alone(m.simulation) is not None for m in models)
        duration = max(linear) * (LONGER if nonlinear else 1.0)
    return step_times(models, duration)


@dataclass(frozen=True, repr=False)
class StepResponses(View):
    """What ``camid.step`` returns.

    Attributes
    ----------
    curves : list of StepCurve
    amplitude : float
        In SI units.
    units : DeclaredUnits
        What people read input and output in.
    remarks : tuple of str
    """

    curves: list[StepCurve]
    amplitude: float
    units: DeclaredUnits
    remarks: tuple[str, ...] = ()

    columns: ClassVar[tuple[str, ...]] = ("model", "time", "output", "output_deviation")

    @property
    def numbers(self) -> pd.DataFrame:
        """``model``, ``time`` (s), ``output`` (SI) and its standard deviation, NaN where it is not known."""
        import pandas as pd

        nothing = np.nan
        parts = [
            pd.DataFrame(
                {
                    "model": c.name,
                    "time": c.time,
                    "output": c.output,
                    "output_deviation": nothing if c.deviation is None else c.deviation,
                }
            )
            for c in self.curves
        ]
        return pd.concat(parts, ignore_index=True)

    def short_table(self) -> ShortTable:
        """What engineers read off a step response."""
        output, source = self.units.output, self.units.input
        asked = (
            ("final_value", "final value", output.symbol, 1.0 / output.factor),
            ("rise_time", "rise time, 10 to 90 %", "s", 1.0),
            ("overshoot", "overshoot", "%", 100.0),
            ("peak_time", "peak after", "s", 1.0),
            ("settling_time", "settled within 2 % after", "s", 1.0),
        )
        rows = []
        for curve in self.curves:
            label = curve.name
            for key, quantity, unit, factor in asked:
                value, deviation = curve.characteristics.get(key, (None, None))
                if value is None:
                    continue
                text = plain(factor * value, 4)
                if deviation is not None and deviation > 0.0:
                    text = with_deviation(factor * value, factor * deviation)
                rows.append((label, quantity, text, unit))
                label = ""
            if label:
                rows.append((label, "has not come to rest", "–", ""))
        size, headings = (
            plain(self.amplitude / source.factor, 4, source.symbol),
            ("model", "quantity", "value ± standard deviation", "unit"),
        )
        return ShortTable(f"Response to a step of {size}", headings, rows, texts=2)

    def said(self) -> tuple[str, ...]:
        """What is not in it."""
        return self.remarks

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        curves = [
            without_infinities(
                {
                    "name": c.name,
                    "linear": c.linear,
                    "time": c.time.tolist(),
                    "output": c.output.tolist(),
                    "output_deviation": None if c.deviation is None else c.deviation.tolist(),
                    "characteristics": {
                        key: {"value": value, "standard_deviation": deviation}
                        for key, (value, deviation) in c.characteristics.items()
                    },
                }
            )
            for c in self.curves
        ]
        return common_mapping(self, amplitude=self.amplitude, units=self.units.to_mapping(), unit="y", models=curves)

    def _draw(self) -> Figure:
        from camid.drawing.steps import draw

        return draw(self)
