"""A look at a file in a process of its own: the first frame of a clip and the marker in it, or a table's columns.

``python -m camid.studio.look frame|columns JSON`` prints JSON, or one line of error like the commands.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from camid.errors import InputError, need
from camid.number_text import printable
from camid.writing import write_whole

# Of a curve on the page; of the columns that are offered.
MOST_POINTS, MOST_COLUMNS = 600, 60


def frame(clip: str, picture: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Write the first frame of a clip as PNG, and say where its marker is.

    Parameters
    ----------
    clip, picture : str
        Paths.
    settings : dict
        Of :class:`camid.tracking.options.Options`.

    Returns
    -------
    dict
        ``width``, ``height``, ``time``, and either ``marker`` (``x``, ``y``, ``region`` in px) or ``problem``.

    Raises
    ------
    InputError
        If the clip cannot be read.
    """
    need("tracking a video", "video")
    import cv2

    from camid.tracking.follow import Follower
    from camid.tracking.options import Options
    from camid.tracking.preview import rgb_image

    region = settings.get("region")
    options = Options(**{**settings, "region": None if region is None else tuple(region)})
    source = options.source(Path(clip))
    first = next(iter(source.frames(options.start, options.end)), None)
    if first is None:
        raise InputError("there are no frames", where=clip, hint="check the start, and the file")
    image = rgb_image(first.picture)
    write_whole(picture, lambda path: cv2.imwrite(str(path), image[:, :, ::-1]))
    height, width = first.picture.shape
    found: dict[str, Any] = {"width": width, "height": height, "time": first.time}
    try:
        appearance = options.appearance(source, None)
        follower = Follower(appearance, options.method, source.name, options.first_region((height, width), clip))
        position = follower.step(first)
        if position is None:
            raise InputError(f"{appearance.sentence} is not in the first frame", hint="choose another appearance")
        x, y = position.grey_level
        found["marker"] = {"x": x, "y": y, "region": position.region, "what": appearance.sentence}
    except InputError as error:
        found["problem"] = str(error)
    return found


def columns(recording: str) -> dict[str, Any]:
    """Columns of a table that nobody has described.

    Returns
    -------
    dict
        ``names``; ``time`` (None if there is none); ``curves``, by name up to `MOST_POINTS` numbers with None for gaps.

    Raises
    ------
    InputError
        If it cannot be read, or holds no columns of numbers.
    """
    import numpy as np

    from camid.draft.layout import layout_of
    from camid.draft.roles import time_of

    layout = layout_of(Path(recording))
    names = [*layout.columns][:MOST_COLUMNS]
    curves = {}
    for name in names:
        values = layout.columns[name]
        shown = values[:: max(1, -(-len(values) // MOST_POINTS))]
        curves[name] = [float(f"{v:.6g}") if np.isfinite(v) else None for v in shown]
    return {"names": names, "time": time_of(layout), "curves": curves, "experiments": list(layout.experiments)}


def main(arguments: list[str]) -> int:
    """Run one look; the exit code."""
    what, given = arguments[0], json.loads(arguments[1])
    try:
        found = frame(**given) if what == "frame" else columns(**given)
        print(json.dumps(found))
    except (InputError, OSError, MemoryError) as error:
        line = "there is not enough memory" if isinstance(error, MemoryError) else str(error)
        print("camid: error: " + printable(line), file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
