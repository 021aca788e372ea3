"""The keys of the plant in a simulation file: one pydantic model per part."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from camid.simulation.schema_values import (
    NonEmptyText,
    NonNegative,
    NotNull,
    Number,
    Part,
    Positive,
    Text,
    TruthValue,
    number_or_text,
)

Coefficients = Annotated[list[Number], Field(min_length=1)]


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
    Annotated[Number, Tag("number")] | Annotated[NonEmptyText, Tag("text")], Discriminator(number_or_text)
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
    free: NotNull[dict[Text, TruthValue]] = Field(
        default=None,
        description="What may be re-estimated, by name; what is named neither here nor under fixed may be.",
    )
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
