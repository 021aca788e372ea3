"""The one kind of error that a user can put right."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from importlib.util import find_spec


class InputError(ValueError):
    """What the user gave is wrong: one line that names the file, the place and what to do about it.

    The command line prints it without a traceback and exits with code 2.

    Parameters
    ----------
    problem : str
        What is wrong, in the user's words.
    where : str, optional
        File and place in it, put in front of the problem.
    hint : str, optional
        What to do about it, put after the problem.
    """

    def __init__(self, problem: str, *, where: str | None = None, hint: str | None = None) -> None:
        self.problem, self.where, self.hint = problem, where, hint
        line = problem if where is None else f"{where}: {problem}"
        super().__init__(line if hint is None else f"{line}; {hint}")


# Of names that a message lists: a longer one is a line of text that was taken for a name.
LONGEST_NAME = 60


def nearest_match(name: str, known: Iterable[str]) -> str:
    """Sentence that offers the likeliest spelling of ``name`` among ``known``, or lists them all."""
    known = list(known)
    lower = {k.lower(): k for k in reversed(known)}
    near = get_close_matches(str(name).lower(), lower, n=1, cutoff=0.5)
    if near:
        return f"did you mean '{lower[near[0]]}'?"
    short = [k if len(k) <= LONGEST_NAME else f"{k[: LONGEST_NAME - 1]}…" for k in known]
    return f"known here: {', '.join(short)}"


# What an extra of pyproject.toml brings: the names of its modules, as people call them.
EXTRAS = {
    "plots": {"matplotlib": "matplotlib"},
    "video": {"cv2": "OpenCV", "av": "PyAV", "matplotlib": "matplotlib"},
    "formats": {
        "pyarrow": "PyArrow",
        "h5py": "h5py",
        "pymatreader": "pymatreader",
        "python_calamine": "python-calamine",
    },
    "control": {"control": "python-control"},
    "studio": {"nicegui": "NiceGUI"},
}


def need(purpose: str, extra: str, *modules: str, hint: str | None = None) -> None:
    """Refuse a feature whose extra is not installed, before its work is done.

    Parameters
    ----------
    purpose : str
        What needs it, for instance ``tracking a video``.
    extra : str
        In pyproject.toml.
    modules : str
        Modules of the extra that are needed; all of them by default.
    hint : str, optional
        How to do without.

    Raises
    ------
    InputError
        If a module is missing: one line with the command that installs it.
    """
    names = EXTRAS[extra]
    missing = [names[m] for m in modules or names if find_spec(m) is None]
    if missing:
        listed = " and ".join([", ".join(missing[:-1]), missing[-1]] if len(missing) > 1 else missing)
        raise InputError(f"{purpose} needs {listed}: pip install 'camid[{extra}]'", hint=hint)
