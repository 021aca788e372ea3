"""Simulations: what the user believes of the chain, as a validated YAML file."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain import Acquisition
from camid.checked_yaml import place, read_yaml, refuse_schema_errors
from camid.errors import InputError, nearest_match
from camid.plant import TransferFunction
from camid.recording import write_whole

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DeclaredEffect:
    """An effect as the file declares it; :mod:`camid.physics` knows what it means.

    Attributes
    ----------
    identifier : str
    parameters : dict
        Values in SI units and those of u and y.
    standard_deviations : dict or None
        Of the parameters.
    where : str
        File and line, for messages.
    """

    identifier: str
    parameters: dict[str, Any]
    standard_deviations: dict[str, Any] | None = None
    where: str = "simulation"

    def to_mapping(self) -> dict[str, Any]:
        """Part of the file."""
        content: dict[str, Any] = {"id": self.identifier, "parameters": dict(self.parameters)}
        if self.standard_deviations:
            content["standard_deviations"] = dict(self.standard_deviations)
        return content


@dataclass(frozen=True)
class Simulation:
    """A believed, identified or improved chain.

    Attributes
    ----------
    time_column, output_column : str
    input_column : str or None
        None for a free decay.
    hold : {"zoh", "foh"}
    plant : TransferFunction
        As written, the leading denominator coefficient included; a python-control system is converted.
    free_numerator, free_denominator : ndarray of bool
        What may be re-estimated, in the shape of the coefficients.
    sensor : {"camera", "instant"}
    exposure : float or None
        Seconds; None means the period of the recording.
    latency : float
        Seconds.
    initial_state : {"zero", "estimate"}
    validation : tuple of float or None
        Start and end in seconds of the rows that are not fitted.
    standard_deviations : dict or None
        ``numerator`` and ``denominator``, in the shape of the coefficients.
    covariance : list of list of float or None
        Of all coefficients: numerator first, then the denominator without its leading one.
    effects : tuple of DeclaredEffect
        Beyond the linear chain.
    source : str
        Name for messages.
    """

    time_column: str
    input_column: str | None
    output_column: str
    plant: TransferFunction
    hold: str = "zoh"
    sensor: str = "camera"
    exposure: float | None = None
    latency: float = 0.0
    initial_state: str = "zero"
    validation: tuple[float, float] | None = None
    free_numerator: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    free_denominator: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    standard_deviations: dict[str, list[float]] | None = None
    covariance: list[list[float]] | None = None
    effects: tuple[DeclaredEffect, ...] = ()
    source: str = "simulation"

    def __post_init__(self) -> None:
        if not isinstance(self.plant, TransferFunction):
            object.__setattr__(self, "plant", _continuous_plant(self.plant, "simulation, plant"))
        if self.free_numerator.size == 0 and self.free_denominator.size == 0:
            for name, free in zip(("free_numerator", "free_denominator"), default_freedom(self.plant), strict=True):
                object.__setattr__(self, name, free)

    @property
    def estimates_initial_state(self) -> bool:
        """Whether the initial state is fitted."""
        return self.initial_state == "estimate"

    def acquisition(self, period: float, uncertainty: float = 0.0) -> Acquisition:
        """Hold and sensor for a recording with this period, known to an uncertainty in seconds.

        Raises
        ------
        InputError
            If the exposure is longer than the period.
        """
        exposure = self.exposure
        if exposure is not None and period < exposure <= period + uncertainty:
            exposure = period
        try:
            return Acquisition(period, self.hold, self.sensor, exposure, self.latency)
        except ValueError as error:
            raise InputError(
                str(error), where=f"{self.source}, sensor", mend="give the exposure in seconds, at most the period"
            ) from None

    def to_mapping(self) -> dict[str, Any]:
        """The file's content."""
        sensor: dict[str, Any] = {"column": self.output_column, "kind": self.sensor}
        if self.sensor == "camera" and self.exposure is not None:
            sensor["exposure"] = float(self.exposure)
        sensor["latency"] = float(self.latency)
        plant: dict[str, Any] = {
            "transfer_function": {
                "numerator": [float(c) for c in self.plant.numerator],
                "denominator": [float(c) for c in self.plant.denominator],
            }
        }
        accuracy = {"standard_deviations": self.standard_deviations, "covariance": self.covariance}
        plant.update({key: value for key, value in accuracy.items() if value is not None})
        plant["free"] = {
            "numerator": [bool(f) for f in self.free_numerator],
            "denominator": [bool(f) for f in self.free_denominator],
        }
        content: dict[str, Any] = {
            "schema": 1,
            "time": {"column": self.time_column},
            "input": None if self.input_column is None else {"column": self.input_column, "hold": self.hold},
            "plant": plant,
            "sensor": sensor,
            "initial_state": self.initial_state,
        }
        if self.validation is not None:
            content["validation"] = {"start": self.validation[0], "end": self.validation[1]}
        content["effects"] = [effect.to_mapping() for effect in self.effects]
        return content


def default_freedom(plant: TransferFunction) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """What may be re-estimated where the file does not say.

    Every coefficient but the leading one of the denominator, and but the zeros at the end of a polynomial: they are
    structure (an integrator, a differentiator), which a belief of exactly zero damping is not.
    """
    free_numerator, free_denominator = (np.ones(len(c), bool) for c in (plant.numerator, plant.denominator))
    for free, coefficients in ((free_numerator, plant.numerator), (free_denominator, plant.denominator)):
        for i in range(len(coefficients) - 1, -1, -1):
            if coefficients[i] != 0.0:
                break
            free[i] = False
    free_denominator[0] = False
    return free_numerator, free_denominator


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
    if _is_system(source):
        raise InputError(
            "a plant alone says nothing of input and sensor",
            where="simulation",
            mend='write {"schema": 1, "time": …, "input": …, "plant": system, "sensor": …}',
        )
    if isinstance(source, Mapping):
        content, name = _with_coefficients(source, "simulation"), "simulation"
    else:
        content, name = read_yaml(Path(source)), str(source)
    if not isinstance(content, Mapping):
        raise InputError("this is no mapping of keys to values", where=name, mend="see README.md")
    _refuse_several(content, name)
    refuse_schema_errors(content, "simulation.schema.json", name)
    for key, part in (("pendulum", content["plant"]), ("controller", content)):
        if key in part:
            raise InputError(
                f"this version does not simulate a {key}",
                where=place(name, content, ["plant", key] if key == "pendulum" else [key]),
                mend="use a transfer_function driven by a recorded input",
            )
    if "transfer_function" not in content["plant"]:
        raise InputError("the key 'transfer_function' is missing", where=place(name, content, ["plant"]), mend="add it")
    return _build(content, name)


def _is_system(value: Any) -> bool:
    """Whether this is a system of python-control (which is not loaded here: who has such a system has loaded it)."""
    library = sys.modules.get("control")
    names = ("InputOutputSystem", "FrequencyResponseData", "TransferFunction", "StateSpace")
    kinds = tuple(getattr(library, name) for name in names if hasattr(library, name))
    return isinstance(value, (TransferFunction, *kinds))


def _continuous_plant(system: Any, where: str) -> TransferFunction:
    """Plant of a python-control system; InputError if it is not continuous, proper, and of one input and output."""
    if isinstance(system, TransferFunction):
        return system
    kinds = tuple(
        getattr(sys.modules.get("control"), name, TransferFunction) for name in ("TransferFunction", "StateSpace")
    )
    if not isinstance(system, kinds):
        raise InputError(
            f"a {type(system).__name__} is no plant",
            where=where,
            mend="give a continuous-time control.TransferFunction or control.StateSpace",
        )
    try:
        return TransferFunction.from_control(system)
    except ValueError as error:
        raise InputError(str(error), where=where) from None


def _with_coefficients(content: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The mapping with the coefficients of a python-control system in place of the system."""
    part = content.get("plant")
    if _is_system(part):
        part = {"transfer_function": part}
    if not isinstance(part, Mapping) or not _is_system(part.get("transfer_function")):
        return content
    plant = _continuous_plant(part["transfer_function"], f"{name}, plant.transfer_function")
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
                mend=f"name one column, and identify one {word} at a time while the others rest",
            )


def _build(content: Mapping[str, Any], name: str) -> Simulation:
    def where(*path: Any) -> str:
        return place(name, content, list(path))

    written = content["plant"]["transfer_function"]
    raw = {k: np.array([float(c) for c in written[k]]) for k in ("numerator", "denominator")}
    if raw["denominator"][0] == 0.0:
        raise InputError(
            "the first coefficient is zero", where=where("plant", "transfer_function", "denominator"), mend="remove it"
        )
    try:
        plant = TransferFunction(tuple(raw["numerator"]), tuple(raw["denominator"]))
        _ = plant.monic  # refuses a leading coefficient so small that the others overflow
    except ValueError as error:
        raise InputError(
            str(error), where=where("plant", "transfer_function"), mend="coefficients stand in descending powers of s"
        ) from None
    unstable = plant.unstable_poles()
    if unstable.size:
        shown = ", ".join(f"{p.real:.4g}{p.imag:+.4g}j" if p.imag else f"{p.real:.4g}" for p in unstable)
        raise InputError(
            f"the transfer function is unstable: poles at {shown} rad/s",
            where=where("plant", "transfer_function", "denominator"),
            mend="all poles need a real part of at most zero; check the signs",
        )
    leading_zeros = len(raw["numerator"]) - len(plant.numerator)
    free_numerator, free_denominator = default_freedom(plant)
    if "free" in content["plant"]:
        given = content["plant"]["free"]
        _check_shape(given, raw, where("plant", "free"))
        free_numerator = np.array(given["numerator"], bool)[leading_zeros:]
        free_denominator = np.array(given["denominator"], bool)
        free_denominator[0] = False
    deviations = content["plant"].get("standard_deviations")
    if deviations is not None:
        _check_shape(deviations, raw, where("plant", "standard_deviations"))
        deviations = {k: [float(v) for v in deviations[k]] for k in ("numerator", "denominator")}
        deviations["numerator"] = deviations["numerator"][leading_zeros:]
    covariance = content["plant"].get("covariance")
    if covariance is not None:
        size = sum(len(c) for c in raw.values()) - 1
        if [len(row) for row in covariance] != [size] * size:
            raise InputError(
                f"this is no table of {size} by {size} numbers",
                where=where("plant", "covariance"),
                mend="it has a row a coefficient, but for the leading one of the denominator",
            )
        covariance = [[float(v) for v in row[leading_zeros:]] for row in covariance[leading_zeros:]]
    validation = content.get("validation")
    if validation is not None and not validation["start"] < validation["end"]:
        raise InputError("start is not before end", where=where("validation"), mend="exchange them")
    sensor = content["sensor"]
    if sensor["kind"] == "instant" and "exposure" in sensor:
        raise InputError(
            "an instant sensor has no exposure", where=where("sensor", "exposure"), mend="remove it or say kind: camera"
        )
    source_input = content["input"]
    return Simulation(
        time_column=content["time"]["column"],
        input_column=None if source_input is None else source_input["column"],
        output_column=sensor["column"],
        plant=plant,
        hold="zoh" if source_input is None else source_input["hold"],
        sensor=sensor["kind"],
        exposure=float(sensor["exposure"]) if "exposure" in sensor else None,
        latency=float(sensor.get("latency", 0.0)),
        initial_state=content.get("initial_state", "zero"),
        validation=None if validation is None else (float(validation["start"]), float(validation["end"])),
        free_numerator=free_numerator,
        free_denominator=free_denominator,
        standard_deviations=deviations,
        covariance=covariance,
        effects=tuple(_declared(effect, where("effects", i)) for i, effect in enumerate(content.get("effects", []))),
        source=name,
    )


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


def _check_shape(given: Mapping[str, Any], raw: Mapping[str, Array], where: str) -> None:
    for key in given:
        if key not in raw:
            raise InputError(f"unknown key '{key}'", where=where, mend=nearest_match(key, raw))
    for key, coefficients in raw.items():
        if key not in given:
            raise InputError(f"the key '{key}' is missing", where=where, mend="give one value a coefficient")
        if not isinstance(given[key], list | tuple) or len(given[key]) != len(coefficients):
            raise InputError(
                f"'{key}' has not the {len(coefficients)} entries of the transfer function",
                where=where,
                mend="give one value a coefficient",
            )


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
