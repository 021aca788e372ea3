"""``camid residuals``."""

from __future__ import annotations

from pathlib import Path

import click

from camid.cli.shared import progress_display
from camid.cli.views import check_picture, show, view_options


@click.command(short_help="Test what a model leaves of a recording.")
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.argument("model", type=click.Path(path_type=Path))
@view_options
def residuals(*, recording: tuple[Path, ...], model: Path, output: Path | None, as_json: bool) -> None:
    """Correlations of what a MODEL leaves of one or several RECORDINGs, with itself and with the input."""
    from camid.analysis.residual_correlations import ResidualCorrelations
    from camid.commands.residuals import residuals as run

    check_picture(output, [*recording, model], ResidualCorrelations.columns)
    with progress_display(as_json) as progress:
        result = run(list(recording), model, progress=progress)
    show(result, output, as_json)
