"""Every key of a simulation file as tables in Markdown, from the JSON schema that the package holds."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

SCHEMA = Path(__file__).resolve().parents[2] / "src/camid/schemas/simulation.schema.json"
# What the types of the schema are called for people.
KINDS = {"number": "number", "integer": "number", "string": "text", "boolean": "`true` or `false`", "null": "`null`"}
# A part of the schema of simulation files that another one holds.
REFERENCE = re.compile(r"#/\$defs/(\w+)")


def simulation_keys() -> str:
    """Every key of a simulation file: a table of the file, then one of each part in the order in which it is met."""
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    parts = {"": schema, **schema["$defs"]}
    names, text = [""], []
    for name in names:  # in the order in which they are met
        part = parts[name]
        keys, required = part.get("properties", {}), part.get("required", [])
        met = dict.fromkeys(REFERENCE.findall(json.dumps(keys)))
        names += [other for other in met if other not in names and "properties" in parts[other]]
        lines = ["| key | value | meaning |", "|---|---|---|"]
        lines += [
            f"| `{key}`{' (needed)' if key in required else ''} | {_value(said)} | {_meaning(said, parts)} |"
            for key, said in keys.items()
        ]
        heading = f"## {_title(name)} {{#{name.lower()}}}\n\n{part.get('description', '')}" if name else "## The file"
        text += [heading, "\n".join(lines)]
    return "\n\n".join(text)


def _title(name: str) -> str:
    """What a part is called for people: ``TransferFunctionPart`` → Transfer function."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", name.removesuffix("Part")).capitalize()


def _meaning(said: dict[str, Any], parts: dict[str, Any]) -> str:
    """What a key of the schema means; a part is described where it stands."""
    name = said.get("$ref", "").removeprefix("#/$defs/")
    return str(said.get("description") or parts.get(name, {}).get("description", "")).replace("|", "\\|")


def _value(said: dict[str, Any]) -> str:
    """What may stand under a key of the schema, in words."""
    if "$ref" in said:
        name = said["$ref"].removeprefix("#/$defs/")
        return "anything" if name == "JsonValue" else f"[{_title(name)}](#{name.lower()})"
    if several := said.get("anyOf") or said.get("oneOf"):
        return " or ".join(dict.fromkeys(_value(each) for each in several))
    if constants := [said["const"]] if "const" in said else said.get("enum"):
        return " or ".join(f"`{constant}`" for constant in constants)
    kind = said.get("type", "")
    if kind == "array":
        return f"list of {_value(said.get('items', {}))}"
    if kind == "object":
        more = said.get("additionalProperties")
        return f"mapping of names to {_value(more if isinstance(more, dict) else {})}"
    return KINDS.get(kind, "anything")
