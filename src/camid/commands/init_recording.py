"""``camid init recording``: a first simulation, with comments, from a look at recordings."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from camid import __version__
from camid.commands.first_fit import fitted
from camid.draft.layout import layout_of
from camid.draft.roles import roles_of
from camid.draft.simulation import bare_simulation, drafted, simulation_with_comments
from camid.draft.templates import TEMPLATES
from camid.errors import InputError, nearest_match
from camid.identification.from_recordings import load_recordings

PathLike = str | os.PathLike[str]


def init_recording(
    recording: PathLike | Sequence[PathLike],
    *,
    period: float | None = None,
    plant: str | None = None,
    progress: Callable[[str], None] | None = None,
) -> str:
    """Look at recordings of one rig and write a first simulation of it.

    Parameters
    ----------
    recording : path, or list of them
        The first is looked at; the others must be readable in the same way.
    period : float, optional
        Seconds, for files without a time column.
    plant : str, optional
        Name of a physical plant (:data:`camid.draft.templates.TEMPLATES`), in place of a transfer function.
    progress : callable, optional
        Called with a sentence about the current step.

    Returns
    -------
    str
        YAML, in which the comments say what is a guess, and why.

    Raises
    ------
    InputError
        If a file cannot be read or holds no columns of numbers, or no plant has that name.
    """
    if plant is not None and plant not in TEMPLATES:
        raise InputError(f"no plant '{plant}'", hint=nearest_match(plant, TEMPLATES))
    recordings = [Path(r) for r in ([recording] if isinstance(recording, str | os.PathLike) else recording)]
    if not recordings:
        raise InputError("no recording is given", hint="name at least one")
    if period is not None and not 0.0 < period < float("inf"):
        raise InputError(f"--period {period:g}", hint="it takes a positive number of seconds")
    layout = layout_of(recordings[0])
    roles = roles_of(layout)
    if period is not None and roles.time is not None:
        raise InputError(
            f"a period is given, and column '{roles.time}' looks like the time",
            where=str(recordings[0]),
            hint="leave out --period",
        )
    bare = bare_simulation(layout, roles, period)
    found = [one for path in recordings for one in load_recordings(path, bare, output_needed=True)]
    draft = drafted(bare, layout, roles, found)
    draft = fitted(draft, recordings[0], found[0], progress)
    draft = replace(draft, template=None if plant is None else TEMPLATES[plant])
    return simulation_with_comments(
        draft, roles, layout, [p.name for p in recordings], f"camid {__version__} init recording"
    )
