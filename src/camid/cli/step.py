"""``camid step``."""

from __future__ import annotations

from pathlib import Path

import click

from camid.cli.shared import progress_display
from camid.cli.views import check_picture, show, view_options


@click.command(short_help="Step responses of models, with bands.")
@click.argument("model", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option("--amplitude", type=float, default=1.0, show_default=True, help="Height of the step, in units of u.")
@click.option("--duration", type=float, help="Seconds [as long as the slowest model takes].")
@view_options
def step(
    *, model: tuple[Path, ...], amplitude: float, duration: float | None, output: Path | None, as_json: bool
) -> None:
    """Motion of the plants of one or several MODELs after a step of the input from rest, with 95 % bands.

    Nonlinear plants and those with effects run as they are, so the height of the step matters.
    """
    from camid.analysis.step_response import StepResponses
    from camid.commands.step import step as run

    check_picture(output, [*model], StepResponses.columns)
    with progress_display(as_json):
        result = run(*model, amplitude=amplitude, duration=duration)
    show(result, output, as_json)
