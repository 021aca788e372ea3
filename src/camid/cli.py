"""The command line: ``camid identify``, ``camid order``, ``camid simulate`` and ``camid diagnose``.

Exit code 0: done. 2: the input is wrong, and one line says what, where and how to mend it.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from camid import __version__
from camid.errors import InputError

if TYPE_CHECKING:
    from camid.simulation import Simulation

INTERRUPTED = 130


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[str], None] | None]:
    """A spinner with the step at hand on the error stream; nothing for machines."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    with Console(stderr=True).status("starting") as status:
        yield status.update


def _warn(sentence: str) -> None:
    click.echo(f"camid: warning: {sentence}", err=True)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="camid")
def cli() -> None:
    """Identify the dynamics of machines from what a camera sees of them."""


# What the options below declare where there is no --simulation.
DECLARATIONS = (
    click.option("--hold", type=click.Choice(["zoh", "foh"]), help="Without --simulation: hold of the input [zoh]."),
    click.option("--sensor", type=click.Choice(["camera", "instant"]), help="Without --simulation: sensor [camera]."),
    click.option("--exposure", type=float, help="Without --simulation: exposure of the camera in s [the period]."),
    click.option("--latency", type=float, help="Without --simulation: latency, or a known delay of the rig, in s [0]."),
    click.option(
        "--initial-state",
        type=click.Choice(["zero", "estimate"]),
        help="Without --simulation: estimate it if the rig moves when a recording begins [zero].",
    ),
    click.option("--time-column", help="Without --simulation: name of the time column [t]."),
    click.option("--input-column", help="Without --simulation: name of the input column [u]."),
    click.option("--output-column", help="Without --simulation: name of the output column [y]."),
)


HINTS = """\b
What is known, and how to say it:
  a delay                 --latency, or latency under sensor in the file
  a coefficient           false under plant.free in the file keeps its value:
                          free: {numerator: [true], denominator: [false, true, false]}
  motion at the start     --initial-state estimate, or initial_state: estimate
  several recordings      name them one after the other; each has an initial
                          state of its own
  not even the order      camid order RECORDING
"""


def _declarations(command: Callable[..., Any]) -> Callable[..., Any]:
    for option in reversed(DECLARATIONS):
        command = option(command)
    return command


@cli.command(epilog=HINTS)
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option("--simulation", type=click.Path(path_type=Path), help="What you believe of the rig (YAML).")
@click.option("--output", type=click.Path(path_type=Path), help="Where the identified model goes (YAML).")
@click.option("--residuals", type=click.Path(path_type=Path), help="Where the residual's correlations go (CSV).")
@click.option("--order", nargs=2, type=int, metavar="POLES ZEROS", help="Without --simulation: order of the plant.")
@_declarations
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
    residuals: Path | None,
    order: tuple[int, int] | None,
    method: str,
    as_json: bool,
    **declared: Any,
) -> None:
    """Re-estimate the plant from one or several RECORDINGs of a rig."""
    from camid.api import identify as run
    from camid.printing import print_identification
    from camid.recording import write_table
    from camid.simulation import write_simulation

    if simulation is not None and order is not None:
        raise _contradiction("order", simulation)
    if simulation is None and order is None:
        raise InputError(
            "neither --simulation nor --order is given",
            mend="say what to look for, e.g. --order 2 0 (camid order tries them all)",
        )
    believed = _declared_simulation(simulation, declared)
    inputs = [*recording, *([simulation] if simulation else [])]
    _check_output(output, inputs)
    _check_output(residuals, inputs, "--residuals")
    if output is not None and residuals is not None and output.resolve() == residuals.resolve():
        raise InputError("--output and --residuals are the same file", where=str(output), mend="name two files")
    with _progress(as_json) as progress, _column_options(simulation):
        result = run(list(recording), believed, structure=order, method=method, progress=progress)
    if residuals is not None:
        if result.residual_analysis is None:
            raise InputError("the estimate ran away and left no residual", mend="leave out --residuals")
        write_table(result.residual_analysis.correlations(result.period), residuals)
    if output is not None:
        names = ", ".join(p.name for p in recording)
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
        _warn(sentence)


@contextmanager
def _column_options(simulation: Path | None) -> Iterator[None]:
    """Name the options for columns where a column is missing and no file says what the columns are called."""
    try:
        yield
    except InputError as error:
        if simulation is None and error.problem.startswith("no column"):
            options = "say --time-column, --input-column, --output-column"
            raise InputError(error.problem, where=error.where, mend=f"{error.mend}; {options}") from None
        raise


def _contradiction(option: str, simulation: Path) -> InputError:
    return InputError(
        f"--{option} and --simulation contradict each other", mend=f"write it into {simulation} or leave it out"
    )


def _declared_simulation(simulation: Path | None, declared: dict[str, Any]) -> Simulation:
    """The simulation file, or what the options declare in its place."""
    from camid.plant import TransferFunction
    from camid.simulation import Simulation, load_simulation

    given = {k: v for k, v in declared.items() if v is not None}
    if simulation is not None:
        if given:
            raise _contradiction(next(iter(given)).replace("_", "-"), simulation)
        return load_simulation(simulation)
    sensor = given.get("sensor", "camera")
    if sensor == "instant" and "exposure" in given:
        raise InputError("an instant sensor has no exposure", mend="leave out --exposure or say --sensor camera")
    for name in ("exposure", "latency"):
        lowest = "positive" if name == "exposure" else "zero or positive"
        if name in given and not (0.0 <= given[name] < float("inf") and (given[name] or lowest != "positive")):
            raise InputError(f"--{name} {given[name]:g}", mend=f"it takes a {lowest} number of seconds")
    return Simulation(
        time_column=given.get("time_column", "t"),
        input_column=given.get("input_column", "u"),
        output_column=given.get("output_column", "y"),
        plant=TransferFunction((1.0,), (1.0, 1.0)),
        hold=given.get("hold", "zoh"),
        sensor=sensor,
        exposure=given.get("exposure"),
        latency=given.get("latency", 0.0),
        initial_state=given.get("initial_state", "zero"),
        source="options",
    )


def _check_output(output: Path | None, inputs: list[Path], option: str = "--output") -> None:
    """Refuse, before the work is done, an output that cannot be written or that is one of the inputs."""
    from camid.recording import check_writable

    for path in inputs:
        if output is not None and output.exists() and path.exists() and output.samefile(path):
            raise InputError(
                f"{option} would overwrite what it is made from", where=str(path), mend="name another file"
            )
    if output is not None:
        check_writable(output)


@cli.command()
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--simulation", type=click.Path(path_type=Path), help="What you believe of the rig; its plant is ignored."
)
@_declarations
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
    from camid.api import select_order
    from camid.identification.result import without_infinities
    from camid.printing import print_orders
    from camid.recording import write_table

    believed = _declared_simulation(simulation, declared)
    _check_output(output, [*recording, *([simulation] if simulation else [])])
    with _progress(as_json) as progress, _column_options(simulation):
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
        _warn(sentence)


@cli.command()
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

    _check_output(output, [recording, simulation])
    believed = load_simulation(simulation)
    with _progress(as_json):
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


@cli.command()
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--simulation", type=click.Path(path_type=Path), required=True, help="What you believe of the rig (YAML)."
)
@click.option(
    "--output", type=click.Path(path_type=Path), required=True, help="Folder for the results; made if need be."
)
@click.option("--report/--no-report", default=True, show_default=True, help="Write report.html, too.")
@click.option("--json", "as_json", is_flag=True, help="Print diagnosis.json.")
def diagnose(*, recording: tuple[Path, ...], simulation: Path, output: Path, report: bool, as_json: bool) -> None:
    """Find, name and model what a simulation leaves out of one or several RECORDINGs of a rig.

    Of several recordings the last one validates, unless the simulation says which rows do.
    """
    from camid.api import diagnose as run
    from camid.diagnosis.files import check_folder, write_diagnosis
    from camid.identification.result import without_infinities

    check_folder(output, [*recording, simulation])
    with _progress(as_json) as progress:
        result = run(list(recording), simulation, progress=progress)
        written = write_diagnosis(result, output, report=report)
    if as_json:
        click.echo(json.dumps(without_infinities(result.to_mapping()), indent=2))
    else:
        from camid.diagnosis.summary import print_summary

        print_summary(result, written)
    for sentence in result.warnings:
        _warn(sentence)


def _message(error: Exception) -> str:
    """One line for an error that the user can mend."""
    sentence = str(error)
    if isinstance(error, click.ClickException):
        sentence = f"{' '.join(error.format_message().split())} (see camid --help)"
    elif isinstance(error, OSError):  # no right to read, a name that is too long, a full disk
        sentence = f"{error.filename or 'cannot read or write'}: {error.strerror or error}"
    # Names of files and columns may hold anything, line breaks too.
    return "".join(c if c.isprintable() else "?" for c in sentence)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit code; errors are one line on the error stream."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without · or ² shows ? instead
    try:
        with warnings.catch_warnings():
            # A start that overflows is dropped; what becomes of the others is judged at the end.
            warnings.simplefilter("ignore", RuntimeWarning)
            return int(cli.main(args=arguments, prog_name="camid", standalone_mode=False) or 0)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 2
    except (InputError, OSError, click.ClickException) as error:
        click.echo(f"camid: error: {_message(error)}", err=True)
        return 2
    except (click.Abort, KeyboardInterrupt):
        click.echo("camid: interrupted; no file is half-written", err=True)
        return INTERRUPTED
