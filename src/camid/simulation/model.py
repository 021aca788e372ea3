"""Simulations: what the user believes of the chain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.controller import Controller
from camid.chain.observer import Observer
from camid.chain.pendulum import Pendulum
from camid.chain.plant import TransferFunction
from camid.errors import InputError
from camid.physical.plant import PhysicalPlant
from camid.recording.options import Reading
from camid.simulation.control_systems import continuous_plant
from camid.simulation.declared_units import DeclaredUnits, SignalUnit

Array = NDArray[np.float64]


def _constant(name: str, value: float | str | None, deviation: float | None) -> dict[str, Any]:
    """Part of the file that declares a constant; empty where nothing is said of it."""
    if value is None:
        return {}
    return {name: value} | ({} if deviation is None else {"standard_deviations": {name: deviation}})


@dataclass(frozen=True)
class DeclaredEffect:
    """An effect as the file declares it; :mod:`camid.effects` knows what it means.

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
    latency : float or "estimate"
        Seconds.
    skew : float or "estimate"
        Relative rate of the camera's clock: the exposure of a row at t ends skew · (t − t_0) later than t − latency,
        where t_0 is the first row.
    latency_deviation, skew_deviation : float or None
        Their standard deviations, where they were estimated.
    offset, bias : float or "estimate" or None
        What the sensor reads at the plant's zero, and what the actuator adds to the input; None where nothing is said.
    offset_deviation, bias_deviation : float or None
        Their standard deviations, where they were estimated.
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
    pendulum : Pendulum or None
        Where the plant is one; ``plant`` is then that of small motions, and the pendulum has the accuracies.
    physical : PhysicalPlant or None
        Where the plant is written by named constants; ``plant`` follows from them, and they have the accuracies.
    controller : Controller or None
        Of a closed loop; its output is the input column.
    observer : Observer or None
        What pulls the simulated motion towards the recorded one.
    remainder : float or None
        Root mean square of what an earlier diagnosis left unexplained, in units of the output (of the input in a closed
        loop): a structure no larger than that is known, and not looked for again.
    reading : Reading
        How the file of a recording is to be read, units included.
    output_columns : tuple of str
        Several columns of one sensor, ``output_column`` the first; what they read is in the plant's equations.
    """

    time_column: str
    input_column: str | None
    output_column: str
    plant: TransferFunction
    hold: str = "zoh"
    sensor: str = "camera"
    exposure: float | None = None
    latency: float | str = 0.0
    latency_deviation: float | None = None
    skew: float | str = 0.0
    skew_deviation: float | None = None
    offset: float | str | None = None
    bias: float | str | None = None
    offset_deviation: float | None = None
    bias_deviation: float | None = None
    initial_state: str = "zero"
    validation: tuple[float, float] | None = None
    free_numerator: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    free_denominator: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    standard_deviations: dict[str, list[float]] | None = None
    covariance: list[list[float]] | None = None
    effects: tuple[DeclaredEffect, ...] = ()
    source: str = "simulation"
    pendulum: Pendulum | None = None
    physical: PhysicalPlant | None = None
    controller: Controller | None = None
    observer: Observer | None = None
    remainder: float | None = None
    reading: Reading = field(default_factory=Reading)
    output_columns: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.plant, TransferFunction):
            object.__setattr__(self, "plant", continuous_plant(self.plant, "simulation, plant"))
        if self.free_numerator.size == 0 and self.free_denominator.size == 0:
            for name, free in zip(("free_numerator", "free_denominator"), default_freedom(self.plant), strict=True):
                object.__setattr__(self, name, free)

    @property
    def estimates_initial_state(self) -> bool:
        """Whether the initial state is fitted."""
        return self.initial_state == "estimate"

    @property
    def is_fitted_to_output(self) -> bool:
        """Whether a simulation run fits something to the recording: the initial state, an offset or a bias."""
        return self.estimates_initial_state or self.observer is not None or "estimate" in (self.offset, self.bias)

    @property
    def may_be_observed(self) -> bool:
        """Whether nothing holds this plant, and one output of it is linear in the input but for its effects."""
        linear = self.pendulum is None and (self.physical is None or self.physical.equations is None)
        held = self.controller is not None or self.observer is not None
        return linear and not held and self.input_column is not None and not self.output_columns

    @property
    def known_offset(self) -> float:
        """The sensor's offset, zero where it is not known, and where it is subtracted as the recording is read."""
        return self.offset if isinstance(self.offset, float) and not self.is_read_from_zero else 0.0

    @property
    def is_read_from_zero(self) -> bool:
        """Whether readings are counted from a known offset: a controller knows the position, a pendulum its angle."""
        return self.controller is not None or self.pendulum is not None

    @property
    def known_latency(self) -> float:
        """The sensor's latency in seconds, zero where it is to be estimated."""
        return self.latency if isinstance(self.latency, float | int) else 0.0

    @property
    def known_skew(self) -> float:
        """The skew of the camera's clock, zero where it is to be estimated."""
        return self.skew if isinstance(self.skew, float | int) else 0.0

    @property
    def known_bias(self) -> float:
        """The input's bias, zero where it is not known."""
        return self.bias if isinstance(self.bias, float) else 0.0

    @property
    def units(self) -> DeclaredUnits:
        """What people read values of input and output in: the units that are declared for their columns."""
        signal = SignalUnit.of("u", self.input_column, self.reading.input)
        output = SignalUnit.of("y", self.output_column, self.reading.output)
        if self.pendulum is not None and output.unit is None:  # the sine is that of an angle in radians
            output = SignalUnit("y", self.output_column, "rad", si="rad")
        return DeclaredUnits(signal, output)

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
            return Acquisition(period, self.hold, self.sensor, exposure, self.known_latency)
        except ValueError as error:
            raise InputError(
                str(error), where=f"{self.source}, sensor", hint="give the exposure in seconds, at most the period"
            ) from None

    def to_mapping(self) -> dict[str, Any]:
        """The file's content."""
        reading = self.reading
        sensor: dict[str, Any] = self._columns() | reading.output.to_mapping()
        if reading.frame_time is not None:
            sensor["time"] = reading.frame_time
        sensor["kind"] = self.sensor
        if self.sensor == "camera" and self.exposure is not None:
            sensor["exposure"] = float(self.exposure)
        sensor["latency"] = self.latency if isinstance(self.latency, str) else float(self.latency)
        sensor |= _constant("offset", self.offset, self.offset_deviation)
        if self.skew != 0.0:
            sensor["skew"] = self.skew
        for name, deviation in (("latency", self.latency_deviation), ("skew", self.skew_deviation)):
            if deviation is not None:
                sensor.setdefault("standard_deviations", {})[name] = deviation
        named = self.pendulum or self.physical
        plant = self._transfer_function() if named is None else named.to_mapping()
        time: dict[str, Any] = {"column": self.time_column, **reading.time.to_mapping()}
        driven = {"column": self.input_column, "hold": self.hold, **reading.input.to_mapping()}
        driven |= _constant("bias", self.bias, self.bias_deviation)
        if reading.added:
            driven["added"] = [{"column": c, **conversion.to_mapping()} for c, conversion in reading.added.items()]
        content: dict[str, Any] = {"schema": 1}
        if described := reading.to_mapping():
            content["recording"] = described
        content |= {
            "time": time if reading.period is None else {"period": reading.period},
            "input": None if self.input_column is None else driven,
            "plant": plant,
            "sensor": sensor,
            "initial_state": self.initial_state,
        }
        if self.validation is not None:
            content["validation"] = {"start": self.validation[0], "end": self.validation[1]}
        if self.controller is not None:
            content["controller"] = self.controller.to_mapping() | self.reading.reference.to_mapping()
        if self.observer is not None:
            content["observer"] = self.observer.to_mapping()
        if self.remainder is not None:
            content["remainder"] = float(self.remainder)
        content["effects"] = [effect.to_mapping() for effect in self.effects]
        return content

    def _columns(self) -> dict[str, Any]:
        """Which columns the sensor has, as the file says it."""
        if not self.output_columns:
            return {"column": self.output_column}
        assert self.physical is not None
        assert self.physical.equations is not None
        return {"columns": dict(zip(self.output_columns, self.physical.equations.readings, strict=True))}

    @property
    def states_characteristics(self) -> bool:
        """Whether the rows of coefficients are natural frequency and damping themselves."""
        return self.pendulum is not None

    def coefficient_rows(self) -> Iterator[tuple[str, float, float | None, str]]:
        """Name, value, standard deviation (zero where it is fixed, None where it is not known), and unit in u, y and s.

        The units of coefficients are those of a monic denominator; another one is a polynomial in s as it stands.
        """
        named = self.pendulum or self.physical
        if named is not None:
            yield from named.coefficient_rows()
            return
        order = self.plant.order if self.plant.denominator[0] == 1.0 else 0
        for name, letter, coefficients, free in (
            ("numerator", "b", self.plant.numerator, self.free_numerator),
            ("denominator", "a", self.plant.denominator, self.free_denominator),
        ):
            known = (self.standard_deviations or {}).get(name, [None] * len(coefficients))
            for i, (value, deviation, is_free) in enumerate(zip(coefficients, known, free, strict=True)):
                power = len(coefficients) - 1 - i
                symbol = {0: "", 1: " · s"}.get(power, f" · s^{power}")
                unit = _unit_of_coefficient(letter == "b", power - order)
                yield f"{letter}{power}{symbol}", value, deviation if is_free else 0.0, unit

    def unit_of_coefficient(self, name: str) -> str:
        """Unit in u, y and s of ``b0``, ``a1`` and so on of the monic plant; of a constant that has a name its own.

        A pendulum has both: constants, and the coefficients of its motion near rest.
        """
        if self.physical is not None:
            return self.physical.units.get(name, "")
        if self.pendulum is not None:
            units = {parameter: unit for parameter, _, _, unit in self.pendulum.coefficient_rows()}
            if name in units:
                return units[name]
        return _unit_of_coefficient(name[0] == "b", int(name[1:]) - self.plant.order)

    def _transfer_function(self) -> dict[str, Any]:
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
        return plant


def _unit_of_coefficient(of_numerator: bool, power: int) -> str:
    """Of a term of a transfer function in s to a power, in u, y and s."""
    seconds = "" if power == 0 else "s" if abs(power) == 1 else f"s^{abs(power)}"
    if not of_numerator:
        return f"s^{power}" if power < 0 else seconds
    above, below = ("y", seconds) if power <= 0 else (f"y {seconds}", "")
    return f"{above}/(u {below})" if below else f"{above}/u"


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
