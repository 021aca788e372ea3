"""``camid poles``."""

from __future__ import annotations

from pathlib import Path

import click

from camid.cli.views import check_picture, show, view_options


@click.command(short_help="Poles and zeros of models, with ellipses.")
@click.argument("model", type=click.Path(path_type=Path), nargs=-1, required=True)
@view_options
def poles(*, model: tuple[Path, ...], output: Path | None, as_json: bool) -> None:
    """Poles and zeros of the plants of one or several MODELs, with 95 % ellipses from their covariances."""
    from camid.analysis.poles_and_zeros import PolesAndZeros
    from camid.commands.poles import poles as run

    check_picture(output, [*model], PolesAndZeros.columns)
    show(run(*model), output, as_json)
