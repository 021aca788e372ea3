"""Simulation files: read, checked key by key, and written."""

from __future__ import annotations

import os
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camid.chain.controller import Controller
from camid.errors import InputError
from camid.number_text import printable
from camid.physical.equations import plant_function
from camid.simulation.control_systems import continuous_plant, is_control_system
from camid.simulation.declared_observer import declared_observer
from camid.simulation.declared_plant import declared_plant
from camid.simulation.declared_reading import declared_reading
from camid.simulation.model import DeclaredEffect, Simulation
from camid.simulation.refused_plant import refuse_unstable
from camid.simulation.yaml_file import Where, place, read_yaml, yaml_text
from camid.writing import write_whole

if TYPE_CHECKING:
    from camid.simulation.schema import EffectPart, SimulationFile


def load_simulation(source: str | os.PathLike[str] | Mapping[str, Any] | Simulation) -> Simulation:
    """Read and check a simulation.

    Parameters
    ----------
    source : path, mapping or Simulation
        YAML 1.2 file, or its content; there, ``plant`` or its ``transfer_function`` may be a python-control system.

    Raises
    ------
    InputError
        With file, line and key: no YAML, unknown or missing keys, values out of range, an unstable or improper plant.
    """
    from camid.simulation.refusals import validated

    if isinstance(source, Simulation):
        return source
    if is_control_system(source):
        raise InputError(
            "a plant alone says nothing about input and sensor",
            where="simulation",
            hint='write {"schema": 1, "time": …, "input": …, "plant": system, "sensor": …}',
        )
    if isinstance(source, Mapping):
        content, name = _with_coefficients(source, "simulation"), "simulation"
    else:
        content, name = read_yaml(Path(source)), str(source)
    if not isinstance(content, Mapping):
        raise InputError(
            "this is not a mapping of keys to values",
            where=name,
            hint="a simulation has the keys schema, time, input, plant and sensor",
        )
    _refuse_several(content, name)
    return _build(validated(content, name), content, name)


def _with_coefficients(content: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The mapping with the coefficients of a python-control system in place of the system."""
    part = content.get("plant")
    if is_control_system(part):
        part = {"transfer_function": part}
    if not isinstance(part, Mapping) or not is_control_system(part.get("transfer_function")):
        return content
    plant = continuous_plant(part["transfer_function"], f"{name}, plant.transfer_function")
    written = {"numerator": list(plant.numerator), "denominator": list(plant.denominator)}
    return {**content, "plant": {**part, "transfer_function": written}}


def _refuse_several(content: Mapping[str, Any], name: str) -> None:
    """One clear line for lists of inputs or outputs, and for two plants."""
    from camid.simulation.plant_schema import PLANTS

    for key, word in (("input", "input"), ("sensor", "output")):
        part = content.get(key)
        parts = part if isinstance(part, list | tuple) else [part]
        columns = [p.get("column") for p in parts if isinstance(p, Mapping)]
        if len(columns) > 1 or any(isinstance(c, list | tuple) for c in columns):
            raise InputError(
                f"camid identifies one input and one output, and here are several {word}s",
                where=place(name, content, [key]),
                hint=f"name one column, and identify one {word} at a time with the others at zero",
            )
    plant = content.get("plant")
    kinds = [kind for kind in PLANTS if isinstance(plant, Mapping) and kind in plant]
    if len(kinds) > 1:
        both = " and ".join(kinds)
        raise InputError(f"the plant is declared twice: {both}", where=place(name, content, ["plant"]), hint="keep one")


def _build(file: SimulationFile, content: Mapping[str, Any], name: str) -> Simulation:
    def where(*path: Any) -> str:
        return place(name, content, list(path))

    reading = declared_reading(file, where)
    output = _output_column(file, where)
    plant = declared_plant(file.plant, where, file.sensor.columns)
    observer = declared_observer(file, plant, where)
    if file.controller is None and observer is None:
        _refuse_unstable(plant, where)
    validation, driven, sensor = file.validation, file.input, file.sensor
    if validation is not None and not validation.start < validation.end:
        raise InputError("start is not before end", where=where("validation"), hint="swap them")
    if sensor.kind == "instant" and sensor.exposure is not None:
        raise InputError(
            "an instant sensor has no exposure", where=where("sensor", "exposure"), hint="remove it or say kind: camera"
        )
    _refuse_unused_input(plant, driven is not None, where)
    _refuse_unknown_constants(file, where)
    # Without a time column, what camid writes still has one.
    time_column = file.time.column
    if time_column is None:
        time_column = "time" if output == "t" else "t"
    return Simulation(
        time_column=time_column,
        input_column=None if driven is None else driven.column,
        output_column=output,
        output_columns=tuple(sensor.columns or ()),
        hold="zoh" if driven is None else driven.hold,
        sensor=sensor.kind,
        exposure=sensor.exposure,
        latency=_plain(sensor.latency),
        latency_deviation=None if sensor.standard_deviations is None else sensor.standard_deviations.latency,
        skew=_plain(sensor.skew),
        skew_deviation=None if sensor.standard_deviations is None else sensor.standard_deviations.skew,
        offset=_plain(sensor.offset),
        offset_deviation=None if sensor.standard_deviations is None else sensor.standard_deviations.offset,
        bias=None if driven is None else _plain(driven.bias),
        bias_deviation=None
        if driven is None or driven.standard_deviations is None
        else driven.standard_deviations.bias,
        initial_state=file.initial_state,
        validation=None if validation is None else (validation.start, validation.end),
        effects=tuple(_declared(effect, where("effects", i)) for i, effect in enumerate(file.effects)),
        controller=_controller(file, where),
        observer=observer,
        remainder=file.remainder,
        source=name,
        reading=reading,
        **plant,
    )


def _refuse_unstable(plant: Mapping[str, Any], where: Where) -> None:
    """Of a linear plant that no controller holds; a pendulum and equations are linearised only where they start."""
    physical = plant.get("physical")
    if "pendulum" in plant or (physical is not None and physical.equations is not None):
        return
    poles = ("plant", "transfer_function", "denominator") if physical is None else ("plant", "physical")
    refuse_unstable(plant["plant"], where(*poles))


def _output_column(file: SimulationFile, where: Where) -> str:
    """The output column, or the first of several; InputError where none is named, or several cannot be."""
    sensor = file.sensor
    if (sensor.column is None) == (sensor.columns is None):
        said = "no column is named" if sensor.column is None else "column and columns are both given"
        raise InputError(said, where=where("sensor"), hint="say column: y, or columns: {x: …, y: …}")
    if sensor.column is not None:
        return str(sensor.column)
    if sensor.offset not in (None, 0.0):
        raise InputError(
            "an offset of several columns",
            where=where("sensor", "offset"),
            hint="write a constant for each into what they read, such as x0 + length * sin(angle)",
        )
    if file.controller is not None:
        raise InputError(
            "a controller has one position, and the sensor several columns",
            where=where("sensor", "columns"),
            hint="name the column that it controls",
        )
    return str(next(iter(sensor.columns or ())))


def _refuse_unused_input(plant: Mapping[str, Any], driven: bool, where: Where) -> None:
    """Refuse an input column that no equation of the plant depends on."""
    physical = plant.get("physical")
    equations = None if physical is None else physical.equations
    if driven and equations is not None and not plant_function(equations).depends_on(equations.input):
        raise InputError(
            f"no equation depends on the input '{equations.input}'",
            where=where("plant", "physical", "equations"),
            hint="use it, or say input: null for a free decay",
        )


def _refuse_unknown_constants(file: SimulationFile, where: Where) -> None:
    """Refuse constants that are to be estimated where nothing can tell them from others."""
    pendulum = "pendulum" in type(file.plant).model_fields
    hint = "give a number, or leave it out"
    if file.sensor.offset == "estimate":
        if file.controller is not None:
            raise InputError(
                "in a closed loop the sensor's offset looks like one of the reference",
                where=where("sensor", "offset"),
                hint=hint,
            )
        if pendulum:
            raise InputError(
                "a pendulum's offset is the angle at which it hangs still",
                where=where("sensor", "offset"),
                hint="leave it out: rest is estimated",
            )
    for key in ("latency", "skew"):
        if getattr(file.sensor, key) == "estimate" and (file.controller is not None or file.input is None):
            why = "without input it shows nowhere" if file.controller is None else "in a closed loop it does not show"
            raise InputError(why, where=where("sensor", key), hint="give a number, or leave it out")
    bias = None if file.input is None else file.input.bias
    if bias is not None and file.controller is not None:
        raise InputError(
            "in a closed loop the input column is what the controller puts out",
            where=where("input", "bias"),
            hint="declare the bias among the effects, as input-bias",
        )
    if bias == "estimate" and pendulum:
        raise InputError("a pendulum's bias is not estimated", where=where("input", "bias"), hint=hint)


def _controller(file: SimulationFile, where: Where) -> Controller | None:
    """Controller of a closed loop, if there is one."""
    written = file.controller
    if written is None:
        return None
    if file.input is None:
        raise InputError(
            "a controller, but no input column", where=where("controller"), hint="name the column of its output"
        )
    if file.input.hold != "zoh":
        raise InputError(
            f"a controller's output is held between its samples, and hold is '{file.input.hold}'",
            where=where("input", "hold"),
            hint="say hold: zoh",
        )
    for key in ("position_gain", "velocity_gain"):
        if getattr(written, key) == 0.0:
            raise InputError(f"{key} = 0 controls nothing", where=where("controller", key), hint="give the gain")
    limit = {} if written.limit is None else {"limit": written.limit}
    return Controller(written.reference, written.position_gain, written.velocity_gain, **limit)


def _declared(effect: EffectPart, where: str) -> DeclaredEffect:
    parameters, deviations = (
        {name: _plain(value) for name, value in (given or {}).items()}
        for given in (effect.parameters, effect.standard_deviations)
    )
    return DeclaredEffect(effect.id, parameters, deviations or None, where)


def _plain(value: Any) -> Any:
    """A value as Python has it, without what YAML remembers of it."""
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return value
    return str(value) if isinstance(value, str) else float(value)


def simulation_text(simulation: Simulation, comment: str = "") -> str:
    """The YAML file as text; ``comment`` goes to its head, line by line."""
    stream = StringIO()  # YAML forbids control characters, which a file's name may hold
    stream.writelines(f"# {printable(line)}\n" for line in comment.splitlines())
    stream.write(yaml_text(simulation.to_mapping()))
    return stream.getvalue()


def write_simulation(simulation: Simulation, path: str | os.PathLike[str], comment: str = "") -> None:
    """Write the YAML file, whole or not at all; ``comment`` goes to its head, line by line."""
    content = simulation_text(simulation, comment).encode("utf-8", errors="replace")
    write_whole(path, lambda temporary: temporary.write_bytes(content))
