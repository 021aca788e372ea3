"""The keys of a simulation file: one pydantic model per part."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    JsonValue,
    StrictBool,
    StrictStr,
    StringConstraints,
    Tag,
)
from pydantic_core import CoreSchema

from camid.simulation.yaml_file import plain_truth_value

Value = TypeVar("Value")


class _NotNull:
    """A key that may be left out, and whose value is None then; writing null is an error."""

    @staticmethod
    def __get_pydantic_core_schema__(source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema: Any = handler(source)
        inner: CoreSchema = schema["schema"] if schema["type"] == "nullable" else schema
        return inner


def _no_truth_value(value: Any) -> Any:
    """The value; to Python, and so to pydantic, true is the number 1."""
    if isinstance(plain_truth_value(value), bool):
        raise ValueError
    return value


def _number_or_text(value: Any) -> str:
    """Which of the two an expression is; its errors are those of text."""
    plain = plain_truth_value(value)
    return "number" if isinstance(plain, int | float) and not isinstance(plain, bool) else "text"


NotNull = Annotated[Value | None, _NotNull]
Text = StrictStr
NonEmptyText = Annotated[StrictStr, StringConstraints(min_length=1)]
_PLAIN = BeforeValidator(plain_truth_value)
Number = Annotated[float, Field(strict=True, allow_inf_nan=False), _PLAIN]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0), _PLAIN]
Skew = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-0.1, le=0.1), _PLAIN]
TruthValue = Annotated[StrictBool, _PLAIN]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0), _PLAIN]
Estimated = Number | Literal["estimate"]
NonNegativeOrEstimate = Annotated[
    Annotated[NonNegative, Tag("number")] | Annotated[Literal["estimate"], Tag("text")],
    Discriminator(_number_or_text),
]
SkewOrEstimate = Annotated[
    Annotated[Skew, Tag("number")] | Annotated[Literal["estimate"], Tag("text")], Discriminator(_number_or_text)
]
ColumnsOfRun = Annotated[dict[Text, NonEmptyText], Field(min_length=1)]
Coefficients = Annotated[list[Number], Field(min_length=1)]


class Part(BaseModel):
    """A mapping of the file, in which an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


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

    column: Text = Field(description="Name of the output column.")
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


class Polynomials(Part):
    """B(s)/A(s), coefficients in descending powers of s."""

    numerator: Coefficients = Field(description="Coefficients of B.")
    denominator: Coefficients = Field(description="Coefficients of A.")


class PolynomialsFree(Part):
    """One truth value per coefficient."""

    numerator: list[TruthValue] = Field(description="true where a coefficient of B may be re-estimated.")
    denominator: list[TruthValue] = Field(description="true where a coefficient of A may be re-estimated.")


class PolynomialsDeviations(Part):
    """One standard deviation per coefficient."""

    numerator: list[NonNegative] = Field(description="Standard deviations of the coefficients of B; 0: not estimated.")
    denominator: list[NonNegative] = Field(
        description="Standard deviations of the coefficients of A; 0: not estimated."
    )


class TransferFunctionPart(Part):
    """A linear plant."""

    transfer_function: Polynomials = Field(description="B(s)/A(s), coefficients in descending powers of s.")
    free: NotNull[PolynomialsFree] = Field(
        default=None, description="What may be re-estimated, in the shape of the coefficients."
    )
    standard_deviations: NotNull[PolynomialsDeviations] = Field(
        default=None, description="Standard deviations in the shape of the coefficients."
    )
    covariance: NotNull[list[list[Number]]] = Field(
        default=None,
        description="Covariance of all coefficients: numerator first, then the denominator without its first.",
    )


class PendulumParameters(Part):
    """ÿ + 2ξωẏ + ω² sin(y − rest) = gain ω² u."""

    natural_frequency: Positive = Field(description="ω in rad/s.")
    damping: NonNegative = Field(description="Damping ratio ξ.")
    gain: Number = Field(default=1.0, description="Static gain for small motions.")
    rest: Number = Field(default=0.0, description="Position of rest.")


class PendulumFree(Part):
    """One truth value per parameter."""

    natural_frequency: TruthValue = Field(default=True, description="Whether ω may be re-estimated.")
    damping: TruthValue = Field(default=True, description="Whether ξ may be re-estimated.")
    gain: TruthValue = Field(default=True, description="Whether the static gain may be re-estimated.")
    rest: TruthValue = Field(default=True, description="Whether the position of rest may be re-estimated.")


class PendulumDeviations(Part):
    """One standard deviation per parameter."""

    natural_frequency: NotNull[NonNegative] = Field(default=None, description="Standard deviation of ω in rad/s.")
    damping: NotNull[NonNegative] = Field(default=None, description="Standard deviation of ξ.")
    gain: NotNull[NonNegative] = Field(default=None, description="Standard deviation of the static gain.")
    rest: NotNull[NonNegative] = Field(default=None, description="Standard deviation of the position of rest.")


class PendulumPart(Part):
    """A pendulum of any amplitude."""

    pendulum: PendulumParameters = Field(description="ÿ + 2ξωẏ + ω² sin(y − rest) = gain ω² u.")
    free: NotNull[PendulumFree] = Field(default=None, description="What may be re-estimated; what is not named may be.")
    standard_deviations: NotNull[PendulumDeviations] = Field(
        default=None, description="Standard deviations of the parameters; 0 where one was not estimated."
    )
    covariance: NotNull[list[list[Number]]] = Field(
        default=None, description="Covariance of natural_frequency, damping, gain and rest, in this order."
    )


Expression = Annotated[
    Annotated[Number, Tag("number")] | Annotated[NonEmptyText, Tag("text")], Discriminator(_number_or_text)
]
Expressions = Annotated[list[Expression], Field(min_length=1)]


class RationalExpressions(Part):
    """B(s)/A(s), coefficients in descending powers of s, as expressions of the constants."""

    numerator: Expressions = Field(description="Expressions of the coefficients of B.")
    denominator: Expressions = Field(description="Expressions of the coefficients of A.")


class StateSpaceExpressions(Part):
    """ẋ = A x + B u, y = C x, entries as expressions of the constants."""

    state_matrix: Annotated[list[Expressions], Field(min_length=1)] = Field(description="Rows of A.")
    input_vector: Expressions = Field(description="Entries of B.")
    output_row: Expressions = Field(description="Entries of C.")


class EquationsPart(Part):
    """ẋ = f(x, u), y = h(x), as expressions of states, input and constants."""

    states: Annotated[dict[Text, Expression], Field(min_length=1)] = Field(
        description="Derivative of each state by the time in seconds, by the name of the state."
    )
    output: NonEmptyText = Field(description="y, an expression of states and constants.")
    input: NonEmptyText = Field(default="u", description="What the input is called in the expressions.")
    start: NotNull[dict[Text, Number]] = Field(
        default=None, description="State before the first sample, by name; zero where nothing is said."
    )


class PhysicalParameters(Part):
    """Named constants and how the plant follows from them; see docs/physical_plants.md."""

    parameters: Annotated[dict[Text, Number], Field(min_length=1)] = Field(description="Values of the constants.")
    units: NotNull[dict[Text, Text]] = Field(default=None, description="Units of the constants, for people.")
    transfer_function: NotNull[RationalExpressions] = Field(
        default=None, description="B(s)/A(s), coefficients in descending powers of s, as expressions of the constants."
    )
    state_space: NotNull[StateSpaceExpressions] = Field(
        default=None, description="ẋ = A x + B u, y = C x, entries as expressions of the constants."
    )
    equations: NotNull[EquationsPart] = Field(
        default=None, description="ẋ = f(x, u), y = h(x), as expressions of states, input and constants."
    )
    fixed: list[Text] = Field(default=[], description="Constants that are known and keep their values.")


class PhysicalPart(Part):
    """A plant of named constants."""

    physical: PhysicalParameters = Field(description="Named constants and how the plant follows from them.")
    standard_deviations: NotNull[dict[Text, NonNegative]] = Field(
        default=None, description="Standard deviations of the constants, by name, where they were estimated."
    )
    covariance: NotNull[list[list[Number]]] = Field(
        default=None, description="Covariance of all constants, in the order in which they are written."
    )


PLANTS = ("transfer_function", "pendulum", "physical")


def _kind_of_plant(written: Any) -> str:
    named = [kind for kind in PLANTS if isinstance(written, Mapping) and kind in written]
    return named[0] if named else "transfer_function"


Plant = Annotated[
    Annotated[TransferFunctionPart, Tag("transfer_function")]
    | Annotated[PendulumPart, Tag("pendulum")]
    | Annotated[PhysicalPart, Tag("physical")],
    Discriminator(_kind_of_plant),
]


class Validation(Part):
    """Rows that are not fitted."""

    start: Number = Field(description="First time, in seconds.")
    end: Number = Field(description="Last time, in seconds.")


class EffectPart(Part):
    """An effect beyond the linear chain."""

    id: Text = Field(description="Identifier from the catalogue.")
    parameters: dict[str, JsonValue] = Field(description="Values in SI units, by name.")
    standard_deviations: NotNull[dict[str, JsonValue]] = Field(
        default=None, description="Standard deviations of the parameters, by name."
    )


class SimulationFile(Part):
    """What the user believes of the chain of hold, actuator, plant and sensor. SI units."""

    version: Annotated[Literal[1], BeforeValidator(_no_truth_value)] = Field(
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
