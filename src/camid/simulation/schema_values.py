"""Values of the keys of a simulation file, and what its parts have in common."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
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


def no_truth_value(value: Any) -> Any:
    """The value; to Python, and so to pydantic, true is the number 1."""
    if isinstance(plain_truth_value(value), bool):
        raise ValueError
    return value


def number_or_text(value: Any) -> str:
    """Which of the two an expression is; its errors are those of text."""
    plain = plain_truth_value(value)
    return "number" if isinstance(plain, int | float) and not isinstance(plain, bool) else "text"


NotNull = Annotated[Value | None, _NotNull]
Text = StrictStr
NonEmptyText = Annotated[StrictStr, StringConstraints(min_length=1)]
PLAIN = BeforeValidator(plain_truth_value)
Number = Annotated[float, Field(strict=True, allow_inf_nan=False), PLAIN]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0), PLAIN]
Skew = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-0.1, le=0.1), PLAIN]
TruthValue = Annotated[StrictBool, PLAIN]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0), PLAIN]
Estimated = Number | Literal["estimate"]
NonNegativeOrEstimate = Annotated[
    Annotated[NonNegative, Tag("number")] | Annotated[Literal["estimate"], Tag("text")],
    Discriminator(number_or_text),
]
SkewOrEstimate = Annotated[
    Annotated[Skew, Tag("number")] | Annotated[Literal["estimate"], Tag("text")], Discriminator(number_or_text)
]


class Part(BaseModel):
    """A mapping of the file, in which an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
