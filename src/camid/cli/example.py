"""``camid example``."""

from __future__ import annotations

import shlex
from pathlib import Path

import click


@click.command(short_help="Write a clip, a drive log and a simulation to try it with.")
@click.argument("folder", type=click.Path(path_type=Path), default=Path("camid-example"))
@click.option("--list", "listed", is_flag=True, help="Say what the files hold, and write nothing.")
def example(*, folder: Path, listed: bool) -> None:
    """Write the files of an example to FOLDER [camid-example], and print the commands to run next.

    A clip of a marker, the log of the drive that moved it, and a simulation that leaves something out.
    """
    from camid.commands.example import COMMANDS, FILES, example_folder, write_example

    if listed:
        width = max(map(len, FILES))
        for name, meaning in FILES.items():
            size = (example_folder() / name).stat().st_size
            click.echo(f"{name:{width}}  {round(size / 1000) or 1:3d} kB  {meaning}")
        return
    written = write_example(folder)
    click.echo(f"{len(written)} files are in {folder}; camid example --list says what they hold")
    click.echo("From the clip to a better simulation:")
    for command in (f"cd {shlex.quote(str(folder))}", *COMMANDS):
        click.echo(f"  {command}")
    click.echo("Then open arm_diagnosis/report.html and arm_compare.png.")
