"""``camid simulate``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from camid.cli.shared import check_table_output, own_effects_option, progress_display, warn
from camid.number_text import percentage, plain

if TYPE_CHECKING:
    from pandas import Series

    from camid.simulation.declared_units import DeclaredUnits


@click.command(short_help="Run a simulation on the input of a recording.")
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--simulation", type=click.Path(path_type=Path), required=True, help="The chain to run (YAML).")
@click.option(
    "--output", type=click.Path(path_type=Path), required=True, help="Where the result goes (CSV or Parquet)."
)
@own_effects_option
@click.option("--json", "as_json", is_flag=True, help="Print a summary as JSON.")
def simulate(recording: Path, simulation: Path, output: Path, effects: tuple[Path, ...], as_json: bool) -> None:
    """Run a simulation on the input of a RECORDING: one row per recorded row."""
    from camid.commands.simulate import rows_compared, units_of_table
    from camid.commands.simulate import simulate as run
    from camid.simulation.file import load_simulation
    from camid.writing import without_infinities, write_table

    check_table_output(output, [recording, simulation, *effects])
    believed = load_simulation(simulation)
    with progress_display(as_json):
        table = run(recording, believed, effects=effects)
    write_table(table, output)
    summary: dict[str, Any] = {"schema": 1, "rows": len(table), "output": str(output), "rmse": None, "nrmse": None}
    units = units_of_table(believed, table)
    summary["units"] = units.to_mapping()
    # Where it is stored, what it is called for people, recorded and simulated column, and unit.
    several = {column: f"simulated_{column}" for column in believed.output_columns if column in table}
    compared = [(f"_{column}", f" of {column}", column, name, "y") for column, name in several.items()]
    if believed.output_column in table and not several:
        compared = [("", "", believed.output_column, "simulated", "y")]
    if "simulated_input" in table and believed.input_column in table:
        compared.append(("_input", " of the control", str(believed.input_column), "simulated_input", "u"))
    rows = rows_compared(believed, table)
    for key, _, recorded, simulated, unit in compared:
        summary[f"rmse{key}"], summary[f"nrmse{key}"] = _difference(table[recorded][rows], table[simulated][rows])
        summary[f"unit{key}"] = units.signals[unit].si or unit
    if as_json:
        click.echo(json.dumps(without_infinities(summary), indent=2))
        return
    click.echo(f"{summary['rows']} rows written to {output}{_in_si(units)}")
    for key, words, *_, unit in compared:
        if summary[f"nrmse{key}"] is not None:
            size = plain(units.shown(summary[f"rmse{key}"], unit), 3, units.text(unit))
            whose = "its" if key else "the output's"
            share = percentage(summary[f"nrmse{key}"])
            click.echo(f"difference{words}: {size} RMS, {share} of {whose} standard deviation")
    for sentence in table.attrs.get("warnings", []):
        warn(sentence)


def _in_si(units: DeclaredUnits) -> str:
    """What has to be known of the columns where the recording is in other units."""
    signal = units.output
    return "" if signal.factor == 1.0 else f", in {signal.si} (recorded in {signal.unit})"


def _difference(recorded: Series, simulated: Series) -> tuple[float | None, float | None]:
    """Root mean square of the difference, and that over the spread of what is recorded; blank cells do not count."""
    import numpy as np

    known = np.isfinite(recorded.to_numpy(dtype=float))
    if not known.any():
        return None, None
    values = recorded.to_numpy(dtype=float)[known]
    error = float(np.sqrt(np.mean((values - simulated.to_numpy(dtype=float)[known]) ** 2)))
    spread = float(np.std(values))
    return error, error / spread if spread > 0.0 else None
