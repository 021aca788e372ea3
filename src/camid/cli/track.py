"""``camid track``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from camid.cli.shared import check_output, check_table_output, progress_display, warn
from camid.errors import InputError

EPILOGUE = """\b
Without --colour, --bright or --dark, what moves is followed.
Examples:
  camid track pendulum.mp4 --colour red --output recording.csv
  camid track stage.avi --dark --region 200 80 60 60 --scale 0.12 --unit mm
      --upwards --output recording.csv --preview preview.png
"""


@click.command(epilog=EPILOGUE, short_help="Measure the positions of a marker in a video.")
@click.argument("video", type=click.Path(path_type=Path))
@click.option(
    "--output", type=click.Path(path_type=Path), required=True, help="Where the recording goes (CSV or Parquet)."
)
@click.option("--colour", help="The marker is of this hue: a name such as red, or #rrggbb.")
@click.option("--bright", is_flag=True, help="The marker is the brightest thing.")
@click.option("--dark", is_flag=True, help="The marker is the darkest thing.")
@click.option(
    "--region", nargs=4, type=int, metavar="X Y WIDTH HEIGHT", help="Where it is in the first frame, in px [found]."
)
@click.option(
    "--method",
    type=click.Choice(["grey-level", "gradient"]),
    default="grey-level",
    show_default=True,
    help="Centroid for x and y: the mean over the exposure, which the camera of a simulation means; or the paper's.",
)
@click.option("--scale", type=float, help="Units per pixel.")
@click.option("--unit", help="Unit of --scale, e.g. m.")
@click.option(
    "--origin",
    nargs=2,
    type=float,
    metavar="X Y",
    default=(0.0, 0.0),
    help="Pixel that becomes 0, 0 [upper left].",
)
@click.option("--upwards", is_flag=True, help="y points up; without it down, as in images.")
@click.option("--start", type=float, help="First time used, in s of the video's time stamps.")
@click.option("--end", type=float, help="Last time used, in s.")
@click.option("--frame-rate", type=float, help="Frames per second, for images and streams without time stamps.")
@click.option(
    "--longest-gap", type=int, default=30, show_default=True, help="Consecutive frames that may be without the marker."
)
@click.option("--allow-truncated", is_flag=True, help="Take what can be read of a file that ends in the middle.")
@click.option("--threads", type=int, default=1, show_default=True, help="Threads that decode.")
@click.option("--preview", type=click.Path(path_type=Path), help="Where a picture of the result goes (PNG).")
@click.option("--json", "as_json", is_flag=True, help="Print a summary as JSON.")
def track(*, video: Path, output: Path, preview: Path | None, as_json: bool, **options: Any) -> None:
    """Measure the positions of a marker in a VIDEO (a file, or a folder of PNG images)."""
    from camid.commands.track import track as run
    from camid.writing import write_table

    check_table_output(output, [video])
    check_output(preview, [video], "--preview")
    if preview is not None:
        if preview.suffix.lower() != ".png":
            raise InputError("a preview is a PNG image", where=str(preview), hint="name it e.g. preview.png")
        if preview.resolve() == output.resolve():
            raise InputError("--output and --preview are the same file", where=str(output), hint="name two files")
    with progress_display(as_json) as progress:
        result = run(video, preview=preview, progress=progress, **options)
    write_table(result.table, output)
    written = [str(path) for path in (output, preview) if path is not None]
    if as_json:
        click.echo(json.dumps({**result.to_mapping(), "output": str(output)}, indent=2, allow_nan=False))
    else:
        for line in result.summary():
            click.echo(line)
        click.echo(f"written to {' and '.join(written)}")
    for sentence in result.warnings():
        warn(sentence)
