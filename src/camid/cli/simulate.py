"""``camid simulate``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from camid.cli.shared import check_output, own_effects_option, progress_display, warn
from camid.number_text import number, percentage

if TYPE_CHECKING:
    from pandas import Series


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
    from camid.commands.simulate import simulate as run
    from camid.simulation.file import load_simulation
    from camid.writing import without_infinities, write_table

    check_output(output, [recording, simulation, *effects])
    believed = load_simulation(simulation)
    with progress_display(as_json):
        table = run(recording, believed, effects=effects)
    write_table(table, output)
    summary: dict[str, Any] = {"schema": 1, "rows": len(table), "output": str(output), "rmse": None, "nrmse": None}
    compared = {column: f"simulated_{column}" for column in believed.output_columns if column in table}
    if believed.output_column in table and not compared:
        summary["rmse"], summary["nrmse"] = _difference(table[believed.output_column], table["simulated"])
    for column, name in compared.items():
        summary[f"rmse_{column}"], summary[f"nrmse_{column}"] = _difference(table[column], table[name])
    if "simulated_input" in table and believed.input_column in table:
        summary["rmse_input"], summary["nrmse_input"] = _difference(
            table[believed.input_column], table["simulated_input"]
        )
    if as_json:
        click.echo(json.dumps(without_infinities(summary), indent=2))
        return
    click.echo(f"{summary['rows']} rows written to {output}")
    if summary["nrmse"] is not None:
        size, share = number(summary["rmse"]), percentage(summary["nrmse"])
        click.echo(f"difference: {size} RMS, {share} of the output's standard deviation")
    for column in compared:
        if summary[f"nrmse_{column}"] is not None:
            size, share = number(summary[f"rmse_{column}"]), percentage(summary[f"nrmse_{column}"])
            click.echo(f"difference of {column}: {size} RMS, {share} of its standard deviation")
    if summary.get("nrmse_input") is not None:
        size, share = number(summary["rmse_input"]), percentage(summary["nrmse_input"])
        click.echo(f"difference of the control: {size} RMS, {share} of its standard deviation")
    for sentence in table.attrs.get("warnings", []):
        warn(sentence)


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
