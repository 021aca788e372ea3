"""``camid studio``."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(short_help="Do it all on a local page in the browser.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port of 127.0.0.1 [any that is free].")
@click.option(
    "--folder", type=click.Path(path_type=Path), help="Keeps uploaded files and results [removed at the end]."
)
@click.option(
    "--largest-upload", type=click.FloatRange(min=1.0), default=2000.0, show_default=True, help="In megabytes."
)
@click.option("--browser/--no-browser", default=True, show_default=True, help="Open the page in the browser.")
def studio(*, port: int, folder: Path | None, largest_upload: float, browser: bool) -> None:
    """Serve a local page that leads from a clip or a recording to a diagnosis.

    It answers this computer alone, and nothing leaves it.
    """
    from camid.studio.guard import MEGABYTE
    from camid.studio.server import serve

    serve(port=port, folder=folder, largest_upload=int(largest_upload * MEGABYTE), browser=browser, say=click.echo)
