"""``camid compare``."""

from __future__ import annotations

from pathlib import Path

import click

from camid.cli.shared import progress_display
from camid.cli.views import check_picture, show, view_options


@click.command(short_help="Compare models with a recording: fit in per cent.")
@click.argument("recording", type=click.Path(path_type=Path))
@click.argument("model", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--held-out",
    nargs=2,
    type=float,
    metavar="START END",
    help="Seconds of the rows that were not fitted [the models' validation].",
)
@click.option("--zoom", nargs=2, type=float, metavar="START END", help="Seconds that the picture shows [all].")
@view_options
def compare(
    *,
    recording: Path,
    model: tuple[Path, ...],
    held_out: tuple[float, float] | None,
    zoom: tuple[float, float] | None,
    output: Path | None,
    as_json: bool,
) -> None:
    """Simulate a RECORDING with one or several MODELs and say how well each follows it.

    The fit is 100 (1 - |y - simulated| / |y - mean of y|) per cent, with Euclidean norms.
    """
    from camid.analysis.comparison import Comparison
    from camid.commands.compare import compare as run

    check_picture(output, [recording, *model], Comparison.columns)
    with progress_display(as_json):
        result = run(recording, *model, held_out=held_out, zoom=zoom)
    show(result, output, as_json)
