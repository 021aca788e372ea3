"""Simulation files: read, checked key by key, and written."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.controller import Controller
from camid.errors import InputError
from camid.recording.options import reading_of
from camid.simulation.checked_yaml import place, read_yaml, refuse_schema_errors
from camid.simulation.control_systems import continuous_plant, is_control_system
from camid.simulation.declared_plant import read_plant
from camid.simulation.model import DeclaredEffect, Simulation
from camid.writing import write_whole

Array = NDArray[np.float64]


def read_simulation(source: str | os.PathLike[str] | Mapping[str, Any]) -> Simulation:
    """Simulation of a file or of its content, see :func:`camid.simulation.file.load_simulation`.

    Raises
    ------
    InputError
        With file, line and key.
    """
    if is_control_system(source):
        raise InputError(
            "a plant alone says nothing of input and sensor",
            where="simulation",
            hint='write {"schema": 1, "time": …, "input": …, "plant": system, "sensor": …}',
        )
    if isinstance(source, Mapping):
        content, name = _with_coefficients(source, "simulation"), "simulation"
    else:
        content, name = read_yaml(Path(source)), str(source)
    if not isinstance(content, Mapping):
        raise InputError("this is no mapping of keys to values", where=name, hint="see README.md")
    _refuse_several(content, name)
    refuse_schema_errors(content, "simulation.schema.json", name)
    return _build(content, name)


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
    """One clear line for lists of inputs or outputs."""
    for key, word in (("input", "input"), ("sensor", "output")):
        part = content.get(key)
        parts = part if isinstance(part, list | tuple) else [part]
        columns = [p.get("column") for p in parts if isinstance(p, Mapping)]
        if len(columns) > 1 or any(isinstance(c, list | tuple) for c in columns):
            raise InputError(
                f"camid identifies one input and one output, and here are several {word}s",
                where=place(name, content, [key]),
                hint=f"name one column, and identify one {word} at a time while the others rest",
            )


def _build(content: Mapping[str, Any], name: str) -> Simulation:
    def where(*path: Any) -> str:
        return place(name, content, list(path))

    reading = reading_of(content, where)
    plant = read_plant(content["plant"], where)
    validation = content.get("validation")
    if validation is not None and not validation["start"] < validation["end"]:
        raise InputError("start is not before end", where=where("validation"), hint="exchange them")
    sensor = content["sensor"]
    if sensor["kind"] == "instant" and "exposure" in sensor:
        raise InputError(
            "an instant sensor has no exposure", where=where("sensor", "exposure"), hint="remove it or say kind: camera"
        )
    source_input = content["input"]
    return Simulation(
        # Without a time column, what camid writes still has one.
        time_column=content["time"].get("column", "time" if sensor["column"] == "t" else "t"),
        input_column=None if source_input is None else source_input["column"],
        output_column=sensor["column"],
        hold="zoh" if source_input is None else source_input["hold"],
        sensor=sensor["kind"],
        exposure=float(sensor["exposure"]) if "exposure" in sensor else None,
        latency=float(sensor.get("latency", 0.0)),
        initial_state=content.get("initial_state", "zero"),
        validation=None if validation is None else (float(validation["start"]), float(validation["end"])),
        effects=tuple(_declared(effect, where("effects", i)) for i, effect in enumerate(content.get("effects", []))),
        controller=_controller(content, where),
        remainder=float(content["remainder"]) if "remainder" in content else None,
        source=name,
        reading=reading,
        **plant,
    )


def _controller(content: Mapping[str, Any], where: Callable[..., str]) -> Controller | None:
    """Controller of a closed loop, if there is one."""
    written = content.get("controller")
    if written is None:
        return None
    if content["input"] is None:
        raise InputError(
            "a controller, but no input column", where=where("controller"), hint="name the column of its output"
        )
    if content["input"].get("hold", "zoh") != "zoh":
        raise InputError(
            f"a controller's output is held between its samples, and hold is '{content['input']['hold']}'",
            where=where("input", "hold"),
            hint="say hold: zoh",
        )
    numbers = {key: float(written[key]) for key in ("position_gain", "velocity_gain", "limit") if key in written}
    for key in ("position_gain", "velocity_gain"):
        if numbers[key] == 0.0:
            raise InputError(f"{key} = 0 controls nothing", where=where("controller", key), hint="give the gain")
    return Controller(str(written["reference"]), **numbers)


def _declared(effect: Mapping[str, Any], where: str) -> DeclaredEffect:
    parameters, deviations = (
        {str(k): _plain(v) for k, v in effect.get(key, {}).items()} for key in ("parameters", "standard_deviations")
    )
    return DeclaredEffect(str(effect["id"]), parameters, deviations or None, where)


def _plain(value: Any) -> Any:
    """A value as Python has it, without what YAML remembers of it."""
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return value
    return str(value) if isinstance(value, str) else float(value)


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
    if isinstance(source, Simulation):
        return source
    return read_simulation(source)


def simulation_text(simulation: Simulation, comment: str = "") -> str:
    """The YAML file as text; ``comment`` goes to its head, a line each."""
    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 120
    stream = StringIO()  # YAML forbids control characters, which a file's name may hold
    stream.writelines(f"# {''.join(c if c.isprintable() else '?' for c in line)}\n" for line in comment.splitlines())
    yaml.dump(simulation.to_mapping(), stream)
    return stream.getvalue()


def write_simulation(simulation: Simulation, path: str | os.PathLike[str], comment: str = "") -> None:
    """Write the YAML file, whole or not at all; ``comment`` goes to its head, a line each."""
    content = simulation_text(simulation, comment).encode("utf-8", errors="replace")
    write_whole(path, lambda temporary: temporary.write_bytes(content))
