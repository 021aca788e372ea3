"""A first simulation file with comments, from what the columns look like and from a fit that may stand beside it."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.draft.layout import Layout
from camid.draft.plant import Resonance, resonance_of
from camid.draft.roles import Roles, says
from camid.draft.templates import Template
from camid.recording.nature import nature_of, quantisation_step
from camid.recording.recording import Recording
from camid.recording.time_grid import LARGEST_STEP
from camid.recording.units import Conversion, is_unit, unit_in_header
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Frames per second of cameras, and how near to one the rate of a camera is.
FRAME_RATES = (23.976, 24.0, 25.0, 29.97, 30.0, 59.94, 60.0, 120.0, 240.0)
FRAME_RATE_TOLERANCE = 0.01
# An input with less than this share of its power above seven tenths of the Nyquist frequency is no staircase.
BAND, BAND_SHARE = 0.7, 1e-3
# A mean beyond this share of the spread is taken out.
OFFSET_SHARE = 0.3
MAIN_ROWS = 4000


@dataclass(frozen=True)
class Draft:
    """A first simulation and what led to it.

    Attributes
    ----------
    simulation : Simulation
    remarks : dict of str to str
        By key of the file: why it says what it says.
    resonance : Resonance
        Read off the recording.
    fit : str
        What was fitted for the coefficients, in a sentence.
    template : Template or None
        The physical plant that was asked for.
    means : (float, float)
        Of input and output.
    """

    simulation: Simulation
    remarks: dict[str, str]
    resonance: Resonance
    fit: str = ""
    template: Template | None = None
    means: tuple[float, float] = (0.0, 0.0)


def bare_simulation(layout: Layout, roles: Roles, period: float | None) -> Simulation:
    """What is needed to read the recording: columns and their units, without offsets."""
    reading = replace(
        layout.reading,
        runs=roles.runs,
        period=None if roles.time is not None else (period or roles.period or 1.0),
        time=Conversion(unit=_unit_of_time(layout, roles)),
        missing="leave-out" if _has_blanks(layout, roles) else "refuse",
        frame_time=roles.frame_time,
    )
    names = [roles.time, roles.input, roles.output]
    return Simulation(
        time_column=roles.time or ("time" if "t" in names else "t"),
        input_column=roles.input,
        output_column=roles.output,
        plant=TransferFunction((1.0,), (1.0, 1.0, 1.0)),
        sensor="instant",
        initial_state="estimate",
        reading=reading,
    )


def _has_blanks(layout: Layout, roles: Roles) -> bool:
    """Whether rows have no output; of frames with times of their own, whether frames have none."""
    blank = np.isnan(layout.columns[roles.output])
    if roles.frame_time is not None:
        blank &= ~np.isnan(layout.columns[roles.frame_time])
    return bool(np.any(blank))


def _unit_of_time(layout: Layout, roles: Roles) -> str | None:
    """Unit in the header of the time column, or that its name ends with, such as t_ms."""
    if roles.time is None or roles.time in layout.dates:
        return None
    in_header = unit_in_header(roles.time)[1]
    if in_header is not None:
        return in_header if is_unit(in_header, "[time]") else None
    match = re.search(r"(?:^|[_\s.])(ms|us|µs|ns|min|h|s|sec|millis|milliseconds|microseconds|micros)$", roles.time)
    unit = {"millis": "ms", "micros": "us", "sec": "s"}.get(match[1], match[1]) if match else None
    return unit if unit not in (None, "s") and is_unit(unit, "[time]") else None


def drafted(bare: Simulation, layout: Layout, roles: Roles, recordings: Sequence[Recording]) -> Draft:
    """Offsets, hold, sensor and a resonance from recordings that were read as the bare simulation says."""
    first = recordings[0]
    output = first.columns[bare.output_column]
    signal = None if bare.input_column is None else first.columns[bare.input_column]
    remarks: dict[str, str] = {}
    resonance = resonance_of(output, signal, first.period)
    reading = bare.reading
    spread = float(np.std(output))
    if abs(resonance.rest) > OFFSET_SHARE * spread:
        remarks["offset of y"] = f"about {_rounded(resonance.rest, spread)!r}"
    if signal is not None and abs(mean := float(np.mean(signal))) > OFFSET_SHARE * float(np.std(signal)):
        reading = replace(reading, input=replace(reading.input, offset=_rounded(-mean, float(np.std(signal)))))
        remarks["offset of u"] = "its mean: the plant is that of changes about it"
    hold = "zoh" if signal is None else _hold(signal, remarks)
    if roles.reference is not None:
        hold, remarks["hold"] = "zoh", "a guess: a controller's output is held"
    sensor = _sensor(layout, roles, first, remarks)
    remarks["time"] = _time_remark(layout, roles, first, bare.reading.period)
    simulation = replace(bare, plant=resonance.plant(), hold=hold, sensor=sensor, reading=reading)
    # The derived freedom belongs to the plant before.
    empty = np.zeros(0, bool)
    means = (0.0 if signal is None else float(np.mean(signal)), float(np.mean(output)))
    return Draft(replace(simulation, free_numerator=empty, free_denominator=empty), remarks, resonance, means=means)


def _rounded(value: float, spread: float) -> float:
    """A value with the decimals that a hundredth of the spread asks for."""
    return float(round(value, int(np.clip(2 - np.floor(np.log10(spread)), 0, 12)))) if spread > 0.0 else value


def _hold(signal: Array, remarks: dict[str, str]) -> str:
    nature = nature_of(signal)
    if nature is not None and nature.kind == "held":
        remarks["hold"] = f"a guess: {nature.words()}"
        return "zoh"
    if nature is not None and nature.kind == "smooth":
        remarks["hold"] = "a guess; it changes so slowly that the hold matters little"
        return "zoh"
    power = np.abs(np.fft.rfft((signal - np.mean(signal)) * np.hanning(len(signal)))) ** 2
    share = float(np.sum(power[int(BAND * len(power)) :]) / np.sum(power))
    if share < BAND_SHARE:
        remarks["hold"] = f"a guess: only {share:.1g} of its power lies near the Nyquist frequency; zoh for a staircase"
        return "band-limited"
    remarks["hold"] = "a guess: foh if it runs along straight lines, band-limited if it passed an analogue filter"
    return "zoh"


def _sensor(layout: Layout, roles: Roles, recording: Recording, remarks: dict[str, str]) -> str:
    output = roles.output
    rate = 1.0 / recording.period
    unit = unit_in_header(output)[1] or ""
    step = quantisation_step(layout.columns[output][np.isfinite(layout.columns[output])])
    near = next((r for r in FRAME_RATES if abs(rate - r) < FRAME_RATE_TOLERANCE * r), None)
    if roles.frame_time is not None:
        remarks["sensor"] = "a guess: frames between the samples of the input; say exposure: in s"
        return "camera"
    if "px" in (unit, output.rpartition("_")[2]) or f"{output}_std" in layout.columns:
        remarks["sensor"] = "a guess: positions in an image; say exposure: in s if it is shorter than the period"
        return "camera"
    if step is not None:
        remarks["sensor"] = f"a guess: steps of {step:.6g} as of an encoder or a counter; camera if it is filmed"
        return "instant"
    if near is not None and (roles.time is not None or recording.period != 1.0):
        remarks["sensor"] = f"a guess: {near:g} rows a second as of a camera; instant for other sensors"
        return "camera"
    remarks["sensor"] = "a guess: no steps, no frame rate; camera, with exposure: in s, if it is filmed"
    return "instant"


def _time_remark(layout: Layout, roles: Roles, recording: Recording, period: float | None) -> str:
    if roles.time is None:
        if roles.period is not None and roles.period == period:
            return "a guess: seconds, from the single value in the file"
        return "NOT IN THE FILE: write the sampling period in s" if period == 1.0 else "as given"
    if roles.frame_time is not None:
        return f"of the input, period {float(np.median(np.diff(layout.columns[roles.time]))):.6g}"
    kind = "dates; seconds after the first row, " if roles.time in layout.dates else ""
    if recording.recorded_time is recording.time:
        return f"{kind}period {recording.period:.6g} s, regular"
    steps = np.diff(recording.recorded_time)
    near = steps[steps < LARGEST_STEP * recording.period]
    jitter = 100.0 * float(np.std(near)) / recording.period
    lost = f", {len(steps) - len(near)} gaps" if len(near) < len(steps) else ""
    return f"{kind}period {recording.period:.6g} s, steps vary by {jitter:.2g} % RMS{lost}"


def quoted(name: str) -> str:
    """A name as YAML reads it back as text."""
    plain = re.fullmatch(r"[A-Za-z_][\w.\-]*", name) and name.lower() not in {
        *("y", "n", "yes", "no", "on", "off", "true", "false", "null", "nan", "inf")
    }
    return name if plain else json.dumps(name, ensure_ascii=False)


def simulation_with_comments(draft: Draft, roles: Roles, layout: Layout, files: Sequence[str], program: str) -> str:
    """The YAML file, in which each guess has a comment."""
    simulation, remarks = draft.simulation, draft.remarks
    reading = simulation.reading
    lines = [
        f"# Written by {program} after a look at {', '.join(files)}.",
        "# It is a set of guesses: correct what you know better, then run camid identify or camid diagnose.",
    ]
    if roles.unused:
        lines.append("# Not used: " + "; ".join(f"{name} ({why})" for name, why in roles.unused.items()) + ".")
    lines.append("schema: 1")
    lines += _recording_lines(simulation, layout)
    if reading.period is not None:
        lines.append(f"time: {{period: {reading.period!r}}}  # {remarks['time']}")
    else:
        unit = f", unit: {reading.time.unit}" if reading.time.unit else ""
        lines.append(f"time: {{column: {quoted(simulation.time_column)}{unit}}}  # {remarks['time']}")
    lines += _input_lines(draft, roles)
    lines += _plant_lines(draft, roles)
    lines += _sensor_lines(draft, roles)
    lines += [
        "initial_state: estimate  # zero, if everything was at rest before the first row",
        "# validation: {start: 0.0, end: 1.0}  # s; rows that are not fitted. Without it the tool chooses",
        "effects: []",
    ]
    text = "\n".join(lines).replace("\u00a0", " ")
    text = "".join(c if c.isprintable() or c == "\n" else "?" for c in text)
    return text + "\n"


def _recording_lines(simulation: Simulation, layout: Layout) -> list[str]:
    written = simulation.reading.to_mapping()
    lines = []
    if written:
        lines.append("recording:")
        for key, value in written.items():
            if key == "runs":
                lines.append(
                    "  runs:  # a guess: runs side by side, each an experiment with an initial state of its own"
                )
                lines += [f"    - {_flow(run)}" for run in value]
            else:
                lines.append(f"  {key}: {_flow(value)}{_REMARKS.get(key, '')}")
    if layout.experiments:
        shown = ", ".join(layout.experiments[:6]) + (", …" if len(layout.experiments) > 6 else "")
        lines.append(f"  # {len(layout.experiments)} experiments: {shown}")
    return lines


_REMARKS = {
    "header": "  # the file has no line with names",
    "columns": "  # names in order; give better ones, and use them below",
    "group": "  # / is the whole file",
    "missing": "  # rows without output are simulated but not compared",
}


def _flow(value: object) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{quoted(str(k))}: {_flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_flow(v) for v in value) + "]"
    return quoted(value) if isinstance(value, str) else json.dumps(value)


def _input_lines(draft: Draft, roles: Roles) -> list[str]:
    simulation, remarks = draft.simulation, draft.remarks
    if simulation.input_column is None:
        return [f"input: null  # a guess: {roles.why['input']}"]
    offset = simulation.reading.input.offset
    lines = [
        "input:",
        f"  column: {quoted(simulation.input_column)}  # a guess: {roles.why['input']}",
        f"  hold: {simulation.hold}  # {remarks['hold']}",
        *_unit_lines(simulation.input_column),
    ]
    if offset and draft.template is None:  # a plant of named constants need not be linear
        lines.append(f"  offset: {offset!r}  # {remarks['offset of u']}")
    if simulation.bias == "estimate" and draft.template is None:
        lines.append(f"  bias: estimate  # {remarks['bias of u']}")
    if roles.reference is not None:
        lines += [
            "# A closed loop: without these lines the input is taken as recorded. Write the gains of your controller:",
            f"# controller: {{reference: {quoted(roles.reference)}, position_gain: 1.0, velocity_gain: 1.0}}",
        ]
    return lines


def _unit_lines(column: str) -> list[str]:
    unit = unit_in_header(column)[1]
    if unit is not None:
        return [f"  unit: {quoted(unit)}  # from the header; the simulation is in SI units"]
    return ["  # unit: mm  # of the cells, if they are not in SI units; scale: multiplies them"]


def _plant_lines(draft: Draft, roles: Roles) -> list[str]:
    plant = draft.simulation.plant
    numerator, denominator = ([_short(c) for c in part] for part in (plant.numerator, plant.denominator))
    found = _small_motions(plant, draft.resonance)
    if draft.template is not None:
        return draft.template.lines(found, *draft.means)
    lines = [
        "plant:",
        f"  # {draft.fit}",
        f"  transfer_function: {{numerator: [{', '.join(numerator)}], denominator: [{', '.join(denominator)}]}}",
    ]
    if len(denominator) != 3 or not plant.denominator[-1]:  # nothing that swings
        return lines
    return [
        *lines,
        "  # or, for a pendulum, in place of the line above (angles in rad):",
        f"  # pendulum: {{natural_frequency: {_short(found.natural_frequency)}, damping: {_short(found.damping)}, "
        f"gain: {_short(found.gain if roles.input else 1.0)}, rest: 0.0}}",
    ]


def _small_motions(plant: TransferFunction, read_off: Resonance) -> Resonance:
    """The resonance of a plant of second order, or what was read off where it has none."""
    if len(plant.denominator) != 3:
        return read_off
    _, damping, stiffness = plant.monic.denominator
    if stiffness <= 0.0 or damping < 0.0:
        return read_off
    natural = float(np.sqrt(stiffness))
    gain = float(plant.monic.numerator[-1]) / stiffness
    return replace(read_off, natural_frequency=natural, damping=0.5 * damping / natural, gain=gain or read_off.gain)


def _short(value: float) -> str:
    return repr(float(f"{value:.5g}"))


def _sensor_lines(draft: Draft, roles: Roles) -> list[str]:
    simulation, remarks = draft.simulation, draft.remarks
    why = roles.why.get("output")
    named = quoted(simulation.output_column)
    lines = [
        "sensor:",
        f"  column: {named}" + (f"  # a guess: {why}" if why else ""),
        f"  kind: {simulation.sensor}  # {remarks['sensor']}",
        *_unit_lines(simulation.output_column),
    ]
    if roles.frame_time is not None:
        lines += [
            f"  time: {quoted(roles.frame_time)}  # a guess: when each frame was delivered; rows without one are blank",
            "  latency: 0.0  # s; after camid join say estimate, and skew: estimate",
        ]
    else:
        lines.append("  latency: 0.0  # s, between the end of a measurement and its time stamp, if it is known")
    if "offset of y" in remarks:
        lines.append(f"  offset: estimate  # {remarks['offset of y']}; a number, if the reading at rest is known")
    if says(simulation.output_column, "reference"):
        lines.append("  # Is this the reference? The output is what was measured.")
    return lines
