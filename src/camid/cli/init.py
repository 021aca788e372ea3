"""``camid init``."""

from __future__ import annotations

from pathlib import Path

import click

from camid.cli.shared import check_output, progress_display
from camid.errors import InputError


@click.group(short_help="Write a first file for you to correct.")
def init() -> None:
    """Write a first file for you to correct."""


@init.command(short_help="Write a first simulation after a look at recordings.")
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="Where the simulation goes (YAML) [standard output]."
)
@click.option("--period", type=float, help="Sampling period in s, for files without a time column.")
@click.option(
    "--plant",
    metavar="NAME",
    help="A physical plant with named constants: mass-spring-damper, pendulum, cart, motor, two-tanks or two-masses.",
)
def recording(*, recording: tuple[Path, ...], output: Path | None, period: float | None, plant: str | None) -> None:
    """Look at one or several RECORDINGs of a rig and write a first simulation of it, with comments.

    What the columns are is guessed from their names and their values, and each guess is marked as one. The columns of
    a matrix are counted from 0: position[0] is the first.
    """
    from camid.commands.init_recording import init_recording
    from camid.writing import write_whole

    check_output(output, [*recording])
    if output is not None and output.exists():
        raise InputError("this file exists", where=str(output), hint="remove it, or name another")
    with progress_display(output is None) as progress:
        text = init_recording(recording, period=period, plant=plant, progress=progress)
    if output is None:
        click.echo(text, nl=False)
        return
    content = text.encode("utf-8", errors="replace")
    write_whole(output, lambda temporary: temporary.write_bytes(content))
    click.echo(f"written to {output}: correct it, then camid identify or camid diagnose with --simulation {output}")
