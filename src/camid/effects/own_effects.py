"""Effects of a user's own: classes, or files of them, which belong to the catalogue while they are used.

A file is Python and is run: what stands in it may do whatever its user may.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, TracebackType

from camid.effects.base import Effect
from camid.effects.known import declarable_effects, forget, is_of_the_package, make_known
from camid.effects.own_effect_form import code_of, line_of, refuse_wrong_form
from camid.errors import InputError

EffectSource = str | os.PathLike[str] | type[Effect]

# Package that the modules of files belong to, as camid.compiled knows it. It is no package on disk.
PACKAGE = "own_effects"
# What stands for physics outside the catalogue.
RESERVED = ("unlisted",)


@contextmanager
def own_effects(sources: Sequence[EffectSource] | EffectSource = ()) -> Iterator[tuple[type[Effect], ...]]:
    """Add effects to the catalogue until the end of the block, in all threads.

    Parameters
    ----------
    sources : sequence of path or subclass of Effect
        Of files, every class that has an identifier.

    Yields
    ------
    tuple of subclasses of Effect

    Raises
    ------
    InputError
        If a file cannot be read or run or holds no effect; if an effect misses a part, cannot be compiled or has an
        identifier that is taken; or if its code raises an error within the block.
    """
    if isinstance(sources, str | os.PathLike | type):
        sources = (sources,)
    modules: list[ModuleType] = []
    known: list[type[Effect]] = []
    try:
        found = tuple(kind for source in sources for kind in _classes_of(source, modules))
        for kind in found:
            refuse_wrong_form(kind)
            if declarable_effects().get(kind.identifier) is not kind:
                _refuse_taken(kind)
                make_known(kind)
                known.append(kind)
        with _blaming({code.co_filename for kind in found for code in code_of(kind)}):
            yield found
    finally:
        for kind in known:
            forget(kind)
        for module in modules:
            sys.modules.pop(module.__name__, None)


def own_effects_in_use() -> tuple[type[Effect], ...]:
    """Effects that do not belong to the package."""
    return tuple(kind for kind in declarable_effects().values() if not is_of_the_package(kind))


def files_of(sources: Sequence[EffectSource] | EffectSource) -> list[str]:
    """Files among what effects come from."""
    if isinstance(sources, str | os.PathLike | type):
        sources = (sources,)
    return [os.fspath(source) for source in sources if not isinstance(source, type)]


def refuse_raised_by(kind: type[Effect], error: Exception) -> None:
    """Raise one line for an error if code of an effect raised it; it may be one that the engine uses itself."""
    blamed = _blame(error, {code.co_filename for code in code_of(kind)})
    if blamed is not None:
        raise blamed from error


def _classes_of(source: EffectSource, modules: list[ModuleType]) -> Sequence[type[Effect]]:
    """The effects that a source stands for; a module that is made is added to the list."""
    if isinstance(source, type):
        if not issubclass(source, Effect):
            raise InputError(
                f"{source.__name__} is not an effect",
                where=line_of(source),
                hint="derive it from camid.effects.Effect",
            )
        return (source,)
    if not isinstance(source, str | os.PathLike):
        raise InputError(f"{source!r} is no effect", hint="give files, or subclasses of camid.effects.Effect")
    path = Path(source)
    if path.is_file() and path.suffix != ".py":
        raise InputError(
            "this is no Python file", where=str(path), hint="effects are classes in a file that ends in .py"
        )
    module = _run(path)
    modules.append(module)
    defined = [
        kind
        for kind in vars(module).values()
        if isinstance(kind, type) and issubclass(kind, Effect) and kind.__module__ == module.__name__
    ]
    named = list(dict.fromkeys(kind for kind in defined if "identifier" in vars(kind)))
    if defined and not named:
        raise InputError(
            f"{defined[0].__name__} has no identifier",
            where=line_of(defined[0]),
            hint='add one, for instance identifier = "my-effect"',
        )
    if not named:
        raise InputError(
            "no effect in this file", where=str(path), hint="it needs a class that derives from camid.effects.Effect"
        )
    return named


def _run(path: Path) -> ModuleType:
    """Module that a file makes."""
    if path.is_dir():
        raise InputError("this is a folder", where=str(path), hint="name a Python file")
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        raise InputError("no such file", where=str(path), hint="check the path after --effects") from None
    except OSError as error:
        raise InputError(f"cannot read ({error.strerror})", where=str(path)) from None
    name = f"{PACKAGE}.{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}"
    while name in sys.modules:
        name += "_"
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module  # dataclasses, numba and inspect look for it
    try:
        exec(compile(text, str(path), "exec", dont_inherit=True), vars(module))
    except SyntaxError as error:
        sys.modules.pop(name)
        at_line = f", line {error.lineno}" if error.filename == str(path) and error.lineno else ""
        raise InputError(f"this is no Python: {error.msg}", where=f"{path}{at_line}", hint="correct it") from None
    except InputError:
        sys.modules.pop(name)
        raise
    except (Exception, SystemExit) as error:
        sys.modules.pop(name)
        raise _blame(error, {str(path)}) or InputError(str(error), where=str(path)) from error
    return module


def _refuse_taken(kind: type[Effect]) -> None:
    other = declarable_effects().get(kind.identifier)
    if other is None and kind.identifier not in RESERVED:
        return
    owner = "the catalogue" if other is None or is_of_the_package(other) else line_of(other)
    raise InputError(
        f"the identifier '{kind.identifier}' is taken by {owner}",
        where=line_of(kind),
        hint="choose another one",
    )


@contextmanager
def _blaming(files: set[str]) -> Iterator[None]:
    """Errors that code of these files raises become one line that names the file and the line."""
    try:
        yield
    except Exception as error:
        where = error.where if isinstance(error, InputError) else None
        if any(where is not None and where.startswith(name) for name in files):
            raise
        blamed = _blame(error, files)
        if blamed is None:
            raise
        raise blamed from error


def _blame(error: BaseException | None, files: set[str]) -> InputError | None:
    """One line for an error, or what it took the place of, that was raised by code of these files."""
    while error is not None:
        line = _deepest_line(error.__traceback__, files)
        if line is not None and not isinstance(error, InputError):
            said = " ".join(str(error).split())
            hint = None
            if isinstance(error, ModuleNotFoundError):
                hint = "a file of effects is read alone: write what it needs into it, or install it"
            return InputError(f"{type(error).__name__}{': ' if said else ''}{said}", where=line, hint=hint)
        error = error.__cause__ or error.__context__
    return None


def _deepest_line(trace: TracebackType | None, files: set[str]) -> str | None:
    """File and line of the innermost call in these files; None where there is none."""
    found = None
    while trace is not None:
        name = trace.tb_frame.f_code.co_filename
        if name in files:
            found = f"{name}, line {trace.tb_lineno}"
        trace = trace.tb_next
    return found
