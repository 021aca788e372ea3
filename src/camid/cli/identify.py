"""``camid identify``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from camid import __version__
from camid.cli.shared import (
    check_output,
    column_options,
    declarations,
    declared_simulation,
    declared_twice,
    own_effects_option,
    progress_display,
    warn,
)
from camid.errors import InputError

HINTS = """\b
What is known, and how to say it:
  a delay                 --latency, or latency under sensor in the file
  a coefficient           false under plant.free in the file keeps its value:
                          free: {numerator: [true], denominator: [false, true, false]}
  motion at the start     --initial-state estimate, or initial_state: estimate
  several recordings      name them all; each has its own initial state
  a column of a matrix    position[0] is its first: they are counted from 0
  not even a simulation   camid init recording RECORDING
  not even the order      camid order RECORDING
"""


@click.command(epilog=HINTS, short_help="Re-estimate the plant from recordings.")
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option("--simulation", type=click.Path(path_type=Path), help="What you believe of the rig (YAML).")
@click.option("--output", type=click.Path(path_type=Path), help="Where the identified model goes (YAML).")
@own_effects_option
@click.option("--residuals", type=click.Path(path_type=Path), help="Where the residual's correlations go (CSV).")
@click.option("--order", nargs=2, type=int, metavar="POLES ZEROS", help="Without --simulation: order of the plant.")
@declarations
@click.option(
    "--method",
    type=click.Choice(["srivc", "output-error", "plain-srivc"]),
    default="srivc",
    show_default=True,
    help="Safeguarded SRIVC; a general optimiser; SRIVC as the paper used it.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def identify(
    *,
    recording: tuple[Path, ...],
    simulation: Path | None,
    output: Path | None,
    effects: tuple[Path, ...],
    residuals: Path | None,
    order: tuple[int, int] | None,
    method: str,
    as_json: bool,
    **declared: Any,
) -> None:
    """Re-estimate the plant from one or several RECORDINGs of a rig."""
    from camid.cli.printing import print_identification
    from camid.commands.identify import identify as run
    from camid.simulation.file import write_simulation
    from camid.writing import write_table

    if simulation is not None and order is not None:
        raise declared_twice("order", simulation)
    if simulation is None and order is None:
        raise InputError(
            "neither --simulation nor --order is given",
            hint="say what to look for, e.g. --order 2 0 (camid order tries them all)",
        )
    believed = declared_simulation(simulation, declared)
    inputs = [*recording, *([simulation] if simulation else []), *effects]
    check_output(output, inputs)
    check_output(residuals, inputs, "--residuals")
    if output is not None and residuals is not None and output.resolve() == residuals.resolve():
        raise InputError("--output and --residuals are the same file", where=str(output), hint="name two files")
    with progress_display(as_json) as progress, column_options(simulation):
        result = run(list(recording), believed, structure=order, method=method, progress=progress, effects=effects)
    if residuals is not None:
        if result.residual_analysis is None:
            raise InputError(
                "the residual was not tested: the estimate diverged, or the engine had to simulate it (a pendulum, "
                "equations, a closed loop, a clock with a skew, effects)",
                hint="leave out --residuals",
            )
        write_table(result.residual_analysis.correlations(result.period), residuals)
    if output is not None:
        names = ", ".join(p.name for p in recording)
        method = result.method or method
        state = "converged" if result.converged else "NOT CONVERGED: do not use the numbers"
        write_simulation(
            result.simulation,
            output,
            f"identified by camid {__version__} from {names}: {method}, {state}, NRMSE {result.nrmse:.4g}",
        )
    if as_json:
        click.echo(json.dumps(result.to_mapping(), indent=2))
    else:
        print_identification(result, [p for p in (output, residuals) if p is not None])
    for sentence in result.warnings():
        warn(sentence)
