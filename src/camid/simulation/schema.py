"""The keys of a simulation file: one pydantic model per part."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, JsonValue, StrictStr, StringConstraints

from camid.simulation.plant_schema import Plant
from camid.simulation.schema_values import (
    Estimated,
    NonEmptyText,
    NonNegative,
    NonNegativeOrEstimate,
    NotNull,
    Number,
    Part,
    Positive,
    SkewOrEstimate,
    Text,
    TruthValue,
    no_truth_value,
)


class ExperimentPart(Part):
    """The column that tells several experiments in one table apart."""

    column: Text = Field(description="Name of the column.")


class RecordingPart(Part):
    """How the file of a recording is read; see docs/recordings.md."""

    separator: NotNull[Annotated[StrictStr, StringConstraints(min_length=1, max_length=1)]] = Field(
        default=None,
        description="One character between the cells of a text file; a blank matches any number of blanks.",
    )
    decimal: NotNull[Literal[".", ","]] = Field(default=None, description="Decimal mark of the numbers in a text file.")
    header: TruthValue = Field(default=True, description="true or false: whether a text file has a line with names.")
    columns: NotNull[Annotated[list[Text], Field(min_length=1)]] = Field(
        default=None, description="Names of the columns of a file without a header line; put quotes around numbers."
    )
    group: NotNull[NonEmptyText] = Field(
        default=None, description="HDF5 group, MAT structure or sheet that holds the columns; / is the whole file."
    )
    experiment: NotNull[ExperimentPart] = Field(
        default=None, description="{column: name}, which tells several experiments in one table apart."
    )
    runs: NotNull[Annotated[list[Annotated[dict[Text, NonEmptyText], Field(min_length=1)]], Field(min_length=1)]] = (
        Field(
            default=None,
            description="Runs side by side in one table: for each, {column of the simulation: column of the file}.",
        )
    )
    start: NotNull[Number] = Field(default=None, description="Seconds of the time column; earlier rows are not read.")
    end: NotNull[Number] = Field(default=None, description="Seconds of the time column; later rows are not read.")
    leave_out: NonNegative = Field(
        default=0.0, description="Seconds at the start of each experiment that are simulated but not compared."
    )
    gaps: Literal["refuse", "hold"] = Field(
        default="refuse", description="What to do where rows of a driven recording are missing."
    )
    missing: Literal["refuse", "leave-out"] = Field(
        default="refuse", description="What to do with rows without output."
    )


class TimePart(Part):
    """The time column and its unit, or the period in seconds where the file has no time column."""

    column: NotNull[Text] = Field(default=None, description="Name of the time column.")
    unit: NotNull[Text] = Field(default=None, description="Unit of the time column, seconds by default.")
    period: NotNull[Positive] = Field(
        default=None, description="Sampling period in seconds, where there is no time column."
    )


class Scaled(Part):
    """Unit and scale of a column."""

    unit: NotNull[Text] = Field(default=None, description="Unit of the cells, such as mm, deg or mV; SI by default.")
    scale: Number = Field(default=1.0, description="Factor of the cells, once they are in SI units.")


class Converted(Scaled):
    """Unit, scale and offset of a column."""

    offset: Number = Field(default=0.0, description="value = scale · (cell in SI units) + offset.")


class SensorDeviations(Part):
    """Standard deviations of the sensor's offset and latency."""

    offset: NotNull[NonNegative] = Field(default=None, description="In units of the output.")
    latency: NotNull[NonNegative] = Field(default=None, description="In seconds.")
    skew: NotNull[NonNegative] = Field(default=None, description="A pure number.")


class BiasDeviation(Part):
    """Standard deviation of the input's bias."""

    bias: NonNegative = Field(description="In units of the input.")


class AddedPart(Converted):
    """A known signal that is added to the input."""

    column: Text = Field(description="Name of the column that is added to the input.")


class InputPart(Converted):
    """The input column and its hold."""

    column: Text = Field(description="Name of the input column.")
    hold: Literal["zoh", "foh", "band-limited"] = Field(description="Intersample behaviour of the input.")
    bias: NotNull[Estimated] = Field(
        default=None,
        description="Constant that the actuator adds to the input from the first sample on. Where nothing is said it "
        "is estimated for a transfer function that integrates, and zero for others, which show it as an offset.",
    )
    standard_deviations: NotNull[BiasDeviation] = Field(default=None, description="Of the bias, as estimated.")
    added: NotNull[Annotated[list[AddedPart], Field(min_length=1)]] = Field(
        default=None,
        description="[{column: name, unit: …, scale: …}]: known signals that are added to the input, with its hold.",
    )


class SensorPart(Scaled):
    """The output column and the sensor that measures it."""

    column: NotNull[Text] = Field(
        default=None, description="Name of the output column, which reads the plant's output."
    )
    columns: NotNull[Annotated[dict[Text, NonEmptyText], Field(min_length=2)]] = Field(
        default=None,
        description="Several columns of one sensor, each with what it reads: an expression of the states and constants "
        "of a plant of equations.",
    )
    time: NotNull[Text] = Field(
        default=None,
        description="Name of the column with the times at which frames were delivered, in seconds of the time column, "
        "where these lie between the samples of the input; rows without a frame are blank there.",
    )
    kind: Literal["camera", "instant"] = Field(description="Mean over the exposure, or the value at one instant.")
    exposure: NotNull[Positive] = Field(
        default=None, description="τ in seconds, at most the period, which is the default."
    )
    latency: NonNegativeOrEstimate = Field(
        default=0.0, description="ℓ in seconds, default 0; estimate: fitted by identify and diagnose."
    )
    skew: SkewOrEstimate = Field(
        default=0.0,
        description="Relative rate of the camera's clock, default 0: the exposure of a row at t ends skew · (t − t_0) "
        "later than t − latency, with t_0 the first row; estimate: fitted by identify and diagnose.",
    )
    offset: NotNull[Estimated] = Field(
        default=None,
        description="Reading at the plant's zero: scale · (cell in SI units) = y + offset. Where nothing is said "
        "identify, order and diagnose estimate it, and simulate takes zero; with estimate, simulate fits it, too.",
    )
    standard_deviations: NotNull[SensorDeviations] = Field(default=None, description="As estimated.")


class ControllerPart(Converted):
    """Closed loop: u = clip(velocity_gain (position_gain (reference − y) − ẏ))."""

    reference: Text = Field(description="Name of the reference column.")
    position_gain: Number = Field(description="kp in 1/s.")
    velocity_gain: Number = Field(description="kv in units of u per (unit of y per second).")
    limit: NotNull[Positive] = Field(default=None, description="Largest |u|.")


class ObserverPart(Part):
    """An acceleration 2 w (ẏ_k − ẏ) + w² (y_k − y), which pulls the simulated motion towards the recorded one."""

    rate: Positive = Field(description="w in rad/s: the lowest with which the simulation does not run away.")
    gain: NotNull[Number] = Field(
        default=None,
        description="Acceleration in units of y per unit of u and s² that the pull is divided by; without it that of "
        "the plant.",
    )


class Validation(Part):
    """Rows that are not fitted."""

    start: Number = Field(description="First time, in seconds.")
    end: Number = Field(description="Last time, in seconds.")


class EffectPart(Part):
    """An effect beyond the linear chain."""

    id: Text = Field(description="Identifier from the catalogue.")
    parameters: dict[str, JsonValue] = Field(
        default={}, description="Values in SI units, by name; an effect without parameters needs none."
    )
    standard_deviations: NotNull[dict[str, JsonValue]] = Field(
        default=None, description="Standard deviations of the parameters, by name."
    )


class SimulationFile(Part):
    """What the user believes of the chain of hold, actuator, plant and sensor. SI units."""

    version: Annotated[Literal[1], BeforeValidator(no_truth_value)] = Field(
        alias="schema", description="Version of this format."
    )
    recording: NotNull[RecordingPart] = Field(
        default=None, description="How the file of a recording is read; see docs/recordings.md."
    )
    time: TimePart = Field(
        description="The time column and its unit, or the period in seconds where the file has no time column."
    )
    input: InputPart | None = Field(description="The input column and its hold; null for a free decay.")
    plant: Plant = Field(
        description="Exactly one of transfer_function, pendulum and physical, and what is known of its accuracy."
    )
    controller: NotNull[ControllerPart] = Field(
        default=None, description="Closed loop: u = clip(velocity_gain (position_gain (reference − y) − ẏ))."
    )
    observer: NotNull[ObserverPart] = Field(
        default=None,
        description="Pulls the simulated motion towards the recorded one, where only a controller that is not declared "
        "keeps the plant from running away.",
    )
    sensor: SensorPart = Field(description="The output column and the sensor that measures it.")
    initial_state: Literal["zero", "estimate"] = Field(
        default="zero",
        description="zero: at rest, u = 0 before the first sample (default); estimate: fitted to the recorded output.",
    )
    validation: NotNull[Validation] = Field(default=None, description="Rows that are not fitted, by time in seconds.")
    remainder: NotNull[Positive] = Field(
        default=None,
        description="Root mean square, in units of the output (of the input in a closed loop), of what an earlier "
        "diagnosis left unexplained.",
    )
    effects: list[EffectPart] = Field(default=[], description="Effects beyond the linear chain.")
