"""``camid join``."""

from __future__ import annotations

import json
from pathlib import Path

import click

from camid.cli.shared import check_output, own_effects_option, progress_display, warn
from camid.errors import InputError


@click.command(short_help="Join a clip and the log of a drive that run on two clocks.")
@click.argument("clip", type=click.Path(path_type=Path))
@click.argument("drive", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), required=True, help="Where the recording goes (CSV).")
@click.option(
    "--simulation",
    type=click.Path(path_type=Path),
    help="What links the drive's input to the clip's output (YAML): the clocks are aligned through its plant.",
)
@own_effects_option
@click.option(
    "--match",
    metavar="CLIP=DRIVE",
    help="Columns that hold the same motion, flash or step, e.g. x=encoder [the pair that agrees best].",
)
@click.option(
    "--write-simulation",
    type=click.Path(path_type=Path),
    help="With --simulation: where it goes with what the join leaves open, its latency (YAML).",
)
@click.option("--exposure", type=float, help="With --match: exposure of the camera in s [0].")
@click.option("--clip-time", help="Time column of the clip [recognised].")
@click.option("--drive-time", help="Time column of the drive [recognised].")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def join(
    *,
    clip: Path,
    drive: Path,
    output: Path,
    simulation: Path | None,
    effects: tuple[Path, ...],
    match: str | None,
    write_simulation: Path | None,
    exposure: float | None,
    clip_time: str | None,
    drive_time: str | None,
    as_json: bool,
) -> None:
    """Join the table of a CLIP with the log of a DRIVE: estimate offset and skew between their clocks.

    The recording has the time of the drive, its columns, and those of the clip on the same rows.
    """
    from camid.commands.join import join as run
    from camid.simulation.file import write_simulation as write
    from camid.writing import write_table

    if write_simulation is not None and simulation is None:
        raise InputError("--write-simulation without --simulation", hint="give the simulation that is to be written")
    inputs = [clip, drive, *([simulation] if simulation else []), *effects]
    check_output(output, inputs)
    check_output(write_simulation, inputs, "--write-simulation")
    if write_simulation is not None and write_simulation.resolve() == output.resolve():
        raise InputError("--output and --write-simulation are the same file", where=str(output), hint="name two files")
    with progress_display(as_json) as progress:
        found = run(
            clip,
            drive,
            simulation=simulation,
            match=_pair(match),
            exposure=exposure,
            clip_time=clip_time,
            drive_time=drive_time,
            progress=progress,
            effects=effects,
        )
    write_table(found.table, output, missing="")
    written = [output]
    if write_simulation is not None and found.simulation is not None:
        write(found.simulation, write_simulation, f"{simulation}, for {output.name}: its latency is left open")
        written.append(write_simulation)
    if as_json:
        click.echo(json.dumps(found.to_mapping(), indent=2))
    else:
        from camid.cli.printing import print_joined

        print_joined(found, written)
    for sentence in found.remarks:
        warn(sentence)


def _pair(match: str | None) -> tuple[str, str] | None:
    """Names of two columns."""
    if match is None:
        return None
    one, sign, other = match.partition("=")
    if not (sign and one and other) or "=" in other:
        raise InputError(f"--match {match}", hint="it takes two columns, such as x=encoder")
    return one, other
