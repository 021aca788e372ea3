"""What the commands with a picture share: options, and what is printed and written."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from camid.cli.shared import check_output, own_effects_option
from camid.errors import need

if TYPE_CHECKING:
    from camid.analysis.view import View

OPTIONS = (
    click.option(
        "--output",
        type=click.Path(path_type=Path),
        help="Picture (.png, .svg or .pdf), with the numbers as CSV beside it; the numbers alone (.csv, .parquet).",
    ),
    click.option("--json", "as_json", is_flag=True, help="Print the result as JSON."),
)


def view_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command ``--output`` and ``--json``, and ``--effects``, which are known while it runs."""

    @wraps(command)
    def with_effects(*, effects: tuple[Path, ...], **options: Any) -> None:
        from camid.effects.own_effects import own_effects

        with own_effects(effects):
            command(**options)

    found: Callable[..., None] = with_effects
    for option in reversed((*OPTIONS, own_effects_option)):
        found = option(found)
    return found


def check_picture(output: Path | None, inputs: list[Path], columns: tuple[str, ...]) -> None:
    """Refuse, before the work is done, what cannot be written: the picture, or the numbers beside it."""
    from camid.analysis.view import TABLES, files_of, refuse_foreign

    if output is None:
        return
    files = files_of(output)
    for file in files:
        check_output(file, inputs)
    refuse_foreign(files[-1], columns)
    if output.suffix.lower() not in TABLES:
        need("a picture", "plots", hint="the numbers alone need none: --output FILE.csv")


def show(view: View, output: Path | None, as_json: bool) -> None:
    """Write the files, and print the table and what is to be said, or JSON."""
    written = [] if output is None else view.save(output)
    if as_json:
        click.echo(json.dumps(view.to_mapping(), indent=2))
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console, found = Console(highlight=False), view.short_table()
    table = Table(title=Text(found.title), title_justify="left")
    for i, heading in enumerate(found.headings):
        table.add_column(Text(heading), overflow="fold", justify="left" if i < found.texts else "right")
    for row in found.rows:
        table.add_row(*map(Text, row))
    console.print(table)
    for sentence in view.said():
        console.print(Text(sentence), soft_wrap=True)
    for path in written:
        console.print(Text(f"written to {path}"), soft_wrap=True)
