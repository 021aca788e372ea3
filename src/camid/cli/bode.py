"""``camid bode``."""

from __future__ import annotations

from pathlib import Path

import click

from camid.cli.shared import progress_display
from camid.cli.views import check_picture, show, view_options


@click.command(short_help="Frequency responses of models, with bands.")
@click.argument("model", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--recording",
    type=click.Path(path_type=Path),
    help="Recording whose empirical frequency response stands beside them, read as the first model says.",
)
@click.option("--camera", is_flag=True, help="Show exposure and latency of the sensor, too [the plant alone].")
@click.option("--frequencies", nargs=2, type=float, metavar="LOW HIGH", help="Range in rad/s [by python-control].")
@click.option("--segment", type=float, help="Seconds of a spectrum of the recording [8 time constants].")
@view_options
def bode(
    *,
    model: tuple[Path, ...],
    recording: Path | None,
    camera: bool,
    frequencies: tuple[float, float] | None,
    segment: float | None,
    output: Path | None,
    as_json: bool,
) -> None:
    """Frequency responses of the plants of one or several MODELs, with 95 % bands from their covariances.

    Nonlinear plants are linearised about rest, effects that are not linear dynamics are left out; both are said.
    """
    from camid.analysis.frequency_response import FrequencyResponses
    from camid.commands.bode import bode as run

    check_picture(output, [*model, *([recording] if recording else [])], FrequencyResponses.columns)
    with progress_display(as_json):
        result = run(*model, recording=recording, camera=camera, frequencies=frequencies, segment=segment)
    show(result, output, as_json)
