"""The JSON schema of a simulation file, ``schemas/simulation.schema.json``, from its models.

``python -m camid.simulation.json_schema`` prints it.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from camid.simulation.schema import SimulationFile


class _WithoutRepetition(GenerateJsonSchema):
    """A JSON schema without titles and defaults that repeat names and absence."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False

    def default_schema(self, schema: Any) -> dict[str, Any]:
        if schema.get("default") is None:
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)


def json_schema() -> str:
    """The JSON schema of a simulation file, as it is in the package."""
    schema = SimulationFile.model_json_schema(schema_generator=_WithoutRepetition)
    schema = {"$schema": GenerateJsonSchema.schema_dialect, "title": "camid simulation, version 1", **schema}
    schema["title"] = "camid simulation, version 1"
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    print(json_schema(), end="")
