"""``camid simulate``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from camid.cli.shared import check_output, progress_display


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--simulation", type=click.Path(path_type=Path), required=True, help="The chain to run (YAML).")
@click.option(
    "--output", type=click.Path(path_type=Path), required=True, help="Where the result goes (CSV or Parquet)."
)
@click.option("--json", "as_json", is_flag=True, help="Print a summary as JSON.")
def simulate(recording: Path, simulation: Path, output: Path, as_json: bool) -> None:
    """Run a simulation on the input of a RECORDING: one row a recorded row."""
    import numpy as np

    from camid.api import simulate as run
    from camid.identification.result import without_infinities
    from camid.recording import write_table
    from camid.simulation import load_simulation

    check_output(output, [recording, simulation])
    believed = load_simulation(simulation)
    with progress_display(as_json):
        table = run(recording, believed)
    write_table(table, output)
    summary: dict[str, Any] = {"schema": 1, "rows": len(table), "output": str(output), "rmse": None, "nrmse": None}
    if believed.output_column in table:
        recorded = table[believed.output_column].to_numpy()
        summary["rmse"] = float(np.sqrt(np.mean((recorded - table["simulated"].to_numpy()) ** 2)))
        spread = float(np.std(recorded))
        summary["nrmse"] = summary["rmse"] / spread if spread > 0.0 else None
    if as_json:
        click.echo(json.dumps(without_infinities(summary), indent=2))
        return
    click.echo(f"{summary['rows']} rows written to {output}")
    if summary["nrmse"] is not None:
        click.echo(f"difference: {summary['rmse']:.4g} rms, {100 * summary['nrmse']:.4g} % of the output's spread")
