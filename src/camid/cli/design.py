"""``camid design``."""

from __future__ import annotations

import json
from pathlib import Path

import click

from camid.cli.shared import FromZero, check_output, own_effects_option, progress_display, warn
from camid.errors import InputError, need


@click.command(short_help="Compute the experiment that tells the remaining hypotheses apart.")
@click.argument("source", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    help="Folder for the design, created if missing; or a name that ends in .csv, for the input alone.",
)
@own_effects_option
@click.option("--amplitude", type=float, nargs=2, metavar="LOW HIGH", help="Least and largest input [as recorded].")
@click.option("--rate", type=float, help="Largest change of the input in a second; inf for none [as recorded].")
@click.option("--duration", type=float, help="Seconds [as recorded].")
@click.option(
    "--travel", type=float, nargs=2, metavar="LOW HIGH", help="Least and largest reading [a tenth more than recorded]."
)
@click.option("--frame-rate", type=float, multiple=True, help="Frames per second; several may be tried [as recorded].")
@click.option("--exposure", type=float, multiple=True, help="Exposure in s; several may be tried [as declared].")
@click.option("--initial-position", type=float, multiple=True, help="Reading from which the rig can be released.")
@click.option("--noise", type=float, help="Standard deviation of a reading [as recorded].")
@click.option(
    "--recording",
    type=click.Path(path_type=Path),
    multiple=True,
    help="With simulations: a recording that they are fitted to first; with a diagnosis: those it was made of.",
)
@click.option("--picture/--no-picture", default=True, show_default=True, help="Also draw design.png.")
@click.option(
    "--time-limit",
    type=FromZero(),
    default=50.0,
    show_default=True,
    help="Seconds after which nothing new is tried; 0 for no limit.",
)
@click.option("--json", "as_json", is_flag=True, help="Print design.json.")
def design(
    *,
    source: tuple[Path, ...],
    output: Path,
    effects: tuple[Path, ...],
    amplitude: tuple[float, float] | None,
    rate: float | None,
    duration: float | None,
    travel: tuple[float, float] | None,
    frame_rate: tuple[float, ...],
    exposure: tuple[float, ...],
    initial_position: tuple[float, ...],
    noise: float | None,
    recording: tuple[Path, ...],
    picture: bool,
    time_limit: float,
    as_json: bool,
) -> None:
    """Compute the next experiment of a rig.

    SOURCE is the output folder of camid diagnose, or simulations that are held against each other. The experiment tells
    the hypotheses that remain apart, or, where one remains, determines its coefficients.
    """
    from camid.experiment_design.results_folder import write_design, write_input
    from camid.writing import without_infinities

    inputs = [*source, *recording, *effects]
    input_alone = output.suffix.lower() == ".csv" and not output.is_dir()
    if input_alone:
        _check_file(output, inputs)
    else:
        _check_folder(output, inputs, picture=picture)
    with progress_display(as_json) as progress:
        from camid.commands.design import design as run

        result = run(
            source[0] if len(source) == 1 else list(source),
            amplitude=amplitude,
            rate=rate,
            duration=duration,
            travel=travel,
            frame_rate=frame_rate,
            exposure=exposure,
            initial_position=initial_position,
            noise=noise,
            recording=list(recording),
            progress=progress,
            time_limit=time_limit or None,
            effects=effects,
        )
        written = [write_input(result, output)] if input_alone else write_design(result, output, picture=picture)
    for sentence in result.warnings:
        warn(sentence)
    if as_json:
        click.echo(json.dumps(without_infinities(result.to_mapping()), indent=2))
        return
    from camid.experiment_design.words import print_design

    print_design(result, written)


def _check_file(output: Path, inputs: list[Path]) -> None:
    """Refuse, before the work is done, a file that the input cannot go to."""
    from camid.experiment_design.results_folder import refuse_other_tables

    check_output(output, inputs)
    refuse_other_tables(output)


def _check_folder(output: Path, inputs: list[Path], *, picture: bool) -> None:
    """Refuse, before the work is done, a folder that the design cannot go to."""
    from camid.experiment_design.results_folder import FILES
    from camid.writing import check_folder

    if picture:
        need("design.png", "plots", hint="or say --no-picture")
    check_folder(output, FILES, inputs)
    if (output / "diagnosis.json").exists():
        raise InputError("this folder holds a diagnosis", where=str(output), hint="name another one for the design")
