"""What the commands share: options that declare a rig, progress, warnings, and checks before the work is done."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from camid.errors import InputError
from camid.studio import progress

if TYPE_CHECKING:
    from camid.simulation.model import Simulation


@contextmanager
def progress_display(quiet: bool) -> Iterator[Callable[[str], None] | None]:
    """The current step on the error stream; nothing for machines, but lines for those that ask.

    It is not animated: that takes a thread, beside which this process cannot be copied (:mod:`camid.side_by_side`).
    """
    if os.environ.get(progress.VARIABLE) == progress.LINES:
        yield lambda sentence: click.echo(f"{progress.PREFIX}{' '.join(sentence.split())}", err=True)
        return
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    with Live(Text("starting …"), console=Console(stderr=True), auto_refresh=False, transient=True) as live:
        yield lambda sentence: live.update(Text(f"{sentence} …"), refresh=True)


def warn(sentence: str) -> None:
    """One line on the error stream; the command goes on."""
    click.echo(f"camid: warning: {sentence}", err=True)


class FromZero(click.FloatRange):
    """A number from zero on: a range of click takes what is no number for one within it."""

    def __init__(self) -> None:
        super().__init__(min=0.0)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number.

        Raises
        ------
        click.BadParameter
            If it is below zero, or none.
        """
        number = float(super().convert(value, param, ctx))
        if isnan(number):
            self.fail(f"{value} is no number; give one from 0 on.", param, ctx)
        return number


own_effects_option = click.option(
    "--effects",
    type=click.Path(path_type=Path),
    multiple=True,
    metavar="FILE",
    help="Python file with effects of your own, which is run; may be given several times.",
)

# What the options below declare where there is no --simulation.
DECLARATIONS = (
    click.option("--hold", type=click.Choice(["zoh", "foh"]), help="Without --simulation: hold of the input [zoh]."),
    click.option("--sensor", type=click.Choice(["camera", "instant"]), help="Without --simulation: sensor [camera]."),
    click.option("--exposure", type=float, help="Without --simulation: exposure of the camera in s [the period]."),
    click.option("--latency", type=float, help="Without --simulation: latency, or a known delay of the rig, in s [0]."),
    click.option(
        "--initial-state",
        type=click.Choice(["zero", "estimate"]),
        help="Without --simulation: estimate it if the rig is moving when a recording starts [zero].",
    ),
    click.option("--time-column", help="Without --simulation: name of the time column [t]."),
    click.option("--input-column", help="Without --simulation: name of the input column [u]."),
    click.option("--output-column", help="Without --simulation: name of the output column [y]."),
)


def declarations(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options in `DECLARATIONS`."""
    for option in reversed(DECLARATIONS):
        command = option(command)
    return command


@contextmanager
def column_options(simulation: Path | None) -> Iterator[None]:
    """Name the options for columns where a column is missing and no file names the columns."""
    try:
        yield
    except InputError as error:
        if simulation is None and error.problem.startswith("no column"):
            options = "say --time-column, --input-column, --output-column"
            raise InputError(error.problem, where=error.where, hint=f"{error.hint}; {options}") from None
        raise


def declared_twice(option: str, simulation: Path) -> InputError:
    """The error for an option that declares what the file declares already."""
    return InputError(
        f"--{option} and --simulation contradict each other", hint=f"write it into {simulation} or leave it out"
    )


def declared_simulation(simulation: Path | None, declared: dict[str, Any]) -> Simulation:
    """The simulation file, or what the options declare in its place."""
    from camid.chain.plant import TransferFunction
    from camid.simulation.file import load_simulation
    from camid.simulation.model import Simulation

    given = {k: v for k, v in declared.items() if v is not None}
    if simulation is not None:
        if given:
            raise declared_twice(next(iter(given)).replace("_", "-"), simulation)
        return load_simulation(simulation)
    sensor = given.get("sensor", "camera")
    if sensor == "instant" and "exposure" in given:
        raise InputError("an instant sensor has no exposure", hint="leave out --exposure or say --sensor camera")
    for name in ("exposure", "latency"):
        lowest = "positive" if name == "exposure" else "zero or positive"
        if name in given and not (0.0 <= given[name] < float("inf") and (given[name] or lowest != "positive")):
            raise InputError(f"--{name} {given[name]:g}", hint=f"it takes a {lowest} number of seconds")
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


def check_output(output: Path | None, inputs: list[Path], option: str = "--output") -> None:
    """Refuse, before the work is done, an output that cannot be written or that is one of the inputs."""
    from camid.writing import check_writable

    for path in inputs:
        if output is not None and output.exists() and path.exists() and output.samefile(path):
            raise InputError(
                f"{option} would overwrite what it is made from", where=str(path), hint="name another file"
            )
    if output is not None:
        check_writable(output)


def check_table_output(output: Path | None, inputs: list[Path]) -> None:
    """Refuse an output as :func:`check_output` does, and one whose name does not say that it is a table."""
    from camid.writing import TABLES

    check_output(output, inputs)
    if output is not None and output.suffix.lower() not in TABLES:
        raise InputError(
            f"'{output.suffix}' is no kind of table" if output.suffix else "this name has no ending",
            where=str(output),
            hint="end it with .csv or .parquet",
        )
