"""``camid order``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from camid.cli.shared import (
    check_table_output,
    column_options,
    declarations,
    declared_simulation,
    progress_display,
    warn,
)


@click.command(short_help="Find how many poles and zeros recordings call for.")
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--simulation", type=click.Path(path_type=Path), help="What you believe of the rig; its plant is ignored."
)
@declarations
@click.option("--largest", type=int, default=4, show_default=True, help="Largest number of poles.")
@click.option("--output", type=click.Path(path_type=Path), help="Where the table goes (CSV or Parquet).")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def order(
    *,
    recording: tuple[Path, ...],
    simulation: Path | None,
    largest: int,
    output: Path | None,
    as_json: bool,
    **declared: Any,
) -> None:
    """Find how many poles and zeros one or several RECORDINGs of a rig call for."""
    from camid.cli.printing import print_orders
    from camid.commands.order import select_order
    from camid.writing import without_infinities, write_table

    believed = declared_simulation(simulation, declared)
    check_table_output(output, [*recording, *([simulation] if simulation else [])])
    with progress_display(as_json) as progress, column_options(simulation):
        result = select_order(list(recording), believed, largest=largest, progress=progress)
    if output is not None:
        write_table(result.table, output)
    if as_json:
        click.echo(json.dumps(without_infinities(result.to_mapping()), indent=2))
    else:
        print_orders(result)
        if output is not None:
            click.echo(f"written to {output}")
    for sentence in result.warnings():
        warn(sentence)
