"""YAML files: read, with keys that remember their lines so that an error names file, line and key; and written."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from io import StringIO
from pathlib import Path
from typing import Any

from camid.errors import InputError

Where = Callable[..., str]  # file, line and dotted key of the keys that lead to a value
# Of a file; of brackets within each other.
MOST_BYTES, DEEPEST = 500_000, 50
# First characters of text that ruamel.yaml leaves unquoted within braces, and then cannot read back: {:a: ?b}.
NEED_QUOTES = (":", "?")


def read_yaml(path: Path) -> Any:
    """Content of a YAML 1.2 file, whose mappings remember their lines.

    Raises
    ------
    InputError
        If there is no such file or it is not YAML; a key that appears twice is not YAML.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError

    if path.is_dir():
        raise InputError("this is a folder", where=str(path), hint="name a YAML file")
    if not path.exists():
        raise InputError("no such file", where=str(path), hint="check the path")
    if not path.is_file():
        raise InputError("this is a device or a pipe", where=str(path), hint="name a YAML file")
    _refuse_large(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
        _refuse_nested(text, path)
        return YAML(typ="rt", pure=True).load(text)
    except (OSError, InputError):
        raise
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{path}, line {mark.line + 1}" if mark else str(path)
        problem = " ".join(str(error.problem or error.context).split())
        raise InputError(f"not valid YAML: {problem}", where=where, hint="correct the line") from None
    except Exception as error:  # the parser lets errors of its own making through, such as those of impossible dates
        problem = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError(f"not valid YAML: {problem}", where=str(path), hint="write it as text") from None


def _refuse_large(path: Path) -> None:
    """Refuse a file that is no simulation: the parser takes a minute for two megabytes."""
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise InputError(
            f"{size:,} bytes, and a simulation has at most {MOST_BYTES:,}", where=str(path), hint="is it a simulation?"
        )


def _refuse_nested(text: str, path: Path) -> None:
    """Refuse brackets in brackets without end, whose parsing takes the square of their number."""
    depth = 0
    for bracket in re.finditer(r"[\[{]|[]}]", text):
        depth = depth + 1 if bracket[0] in "[{" else max(depth - 1, 0)
        if depth > DEEPEST:
            line = text.count("\n", 0, bracket.start()) + 1
            hint = "a simulation has lists of lists at most"
            raise InputError(f"more than {DEEPEST} brackets are open", where=f"{path}, line {line}", hint=hint)


def yaml_text(content: Mapping[str, Any]) -> str:
    """A mapping as YAML 1.2, whose keys keep their order; keys and values may be any text."""
    from ruamel.yaml import YAML
    from ruamel.yaml.nodes import ScalarNode
    from ruamel.yaml.representer import SafeRepresenter

    class QuotingRepresenter(SafeRepresenter):
        """Quotes what its emitter would write so that it cannot be read back."""

        def represent_scalar(self, tag: Any, value: Any, style: Any = None, anchor: Any = None) -> ScalarNode:
            if style is None and isinstance(value, str) and value.startswith(NEED_QUOTES):
                style = '"'
            return super().represent_scalar(tag, value, style=style, anchor=anchor)

    yaml = YAML(typ="safe", pure=True)
    yaml.Representer = QuotingRepresenter
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 120
    stream = StringIO()
    yaml.dump(content, stream)
    return stream.getvalue()


def plain_truth_value(value: Any) -> Any:
    """A truth value as Python has it; with an anchor, ruamel.yaml makes an integer of it."""
    from ruamel.yaml.scalarbool import ScalarBoolean

    return bool(value) if isinstance(value, ScalarBoolean) else value


def _line(content: Any, path: list[Any]) -> int | None:
    """Line in the YAML file of the value at ``path``, as ruamel.yaml remembers it."""
    line = None
    for key in path:
        try:
            marks: Any = content.lc  # only what came out of a file has them
            line = (marks.item(key) if isinstance(content, list) else marks.key(key))[0] + 1
            content = content[key]
        except (AttributeError, KeyError, TypeError, IndexError):
            return line
    return line


def place(source: str, content: Any, path: list[Any]) -> str:
    """File, line and dotted key of a value, for messages."""
    line = _line(content, path)
    key = ".".join(str(p) for p in path)
    return ", ".join([source, *([f"line {line}"] if line else []), *([key] if key else [])])
