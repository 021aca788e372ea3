"""Compiled functions and the folder that keeps their machine code from one process to the next.

:func:`njit` and :func:`callback` replace numba's own decorators. Machine code is kept per user and found by what
was compiled: the instructions of the function, the constants and compiled functions that it uses (in whatever module
they stand), the types of its arguments, the options, numba's version and the processor. Neither the place nor the age
of a source file matters, nor docstrings and comments, so every copy of the package shares one folder, and a change in
a function compiles again all that call it.

The environment variable ``CAMID_CACHE`` names another folder. ``python -m camid.compile_all`` fills it beforehand.

The folder holds pickled code of its user, like numba's own cache; do not share a folder that others may write to.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import pickle
import platform
import shutil
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dis import EXTENDED_ARG, opmap
from functools import cache
from inspect import CO_GENERATOR, CO_VARARGS, CO_VARKEYWORDS
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, TypeVar, cast, overload

import llvmlite.binding
import numba
import numpy as np
from numba.core.caching import _Cache
from numba.core.ccallback import CFunc
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.types import Tuple, Type, UniTuple
from numba.extending import _Intrinsic

VARIABLE = "CAMID_CACHE"
LOAD_GLOBAL = opmap["LOAD_GLOBAL"]
# Versions of one function that the folder keeps: those of a few branches or installed releases.
VERSIONS_KEPT = 12
# What a waiting user is told, by package or module; a longer name goes before a shorter one.
PURPOSES = {
    "camid.chain": "the exact simulation",
    "camid.proof": "the generator of concealed recordings",
    "camid.effects": "the effects",
    "camid.engine": "the simulation engine",
    "camid.identification": "the identification",
    "camid.images": "the images of markers",
    "own_effects": "effects of your own",
}

# What every x86-64 processor of the last ten years has. Sums that may be taken in any order are taken in that of the
# processor's vectors, so that one target makes the last digits the same on all of them; longer vectors gain nothing.
COMMON_FEATURES = ("avx2", "bmi2", "fma")
COMMON_TARGET = "haswell"


def _fix_target() -> None:
    """Compile for one kind of processor, unless the reader chose another one or the machine is not of that kind."""
    available = llvmlite.binding.get_host_cpu_features()
    configuration: Any = numba.config
    if configuration.CPU_NAME is None and all(available.get(feature) for feature in COMMON_FEATURES):
        configuration.CPU_NAME, configuration.CPU_FEATURES = COMMON_TARGET, ""


_fix_target()

Function = TypeVar("Function", bound=Callable[..., Any])


@overload
def njit(function: Function, /) -> Function: ...


@overload
def njit(**options: Any) -> Callable[[Function], Function]: ...


def njit(function: Function | None = None, /, **options: Any) -> Function | Callable[[Function], Function]:
    """Compile a function when it is first called with arguments of certain types; numba's ``njit`` with its options."""

    def decorate(function: Function) -> Function:
        # Nothing takes the address of these functions: an entry point for C would be compiled for nothing.
        decorator: Any = numba.njit
        dispatcher: Any = decorator(no_cfunc_wrapper=True, **options)(function)
        if dispatcher is not function:  # as it is where NUMBA_DISABLE_JIT is set
            dispatcher._cache = CompiledCode(cast(FunctionType, function), options)
            dispatcher.get_call_template = _without_literals(dispatcher.get_call_template)
        return cast(Function, dispatcher)

    return decorate if function is None else decorate(function)


@overload
def kernel(function: Function, /) -> Function: ...


@overload
def kernel(**options: Any) -> Callable[[Function], Function]: ...


def kernel(function: Function | None = None, /, **options: Any) -> Function | Callable[[Function], Function]:
    """Compile a function that allocates nothing and is called by compiled code: :func:`njit` without reference counts.

    Each array that such a function takes out of a tuple or hands on is else counted up and down, by an atomic
    instruction that takes as long as ten multiplications. Parts of one long function are best ``inline="always"``:
    they become part of it before it is compiled, whereas each with code of its own is compiled again in every caller.
    """
    return njit(**options, _nrt=False) if function is None else njit(_nrt=False)(function)


def _without_literals(template: Callable[..., Any]) -> Callable[..., Any]:
    """Numba compiles a call with a constant once for that constant and once more for its type; the second does."""

    def call_template(arguments: Sequence[Any], keywords: Mapping[str, Any]) -> Any:
        plain = {name: numba.types.unliteral(each) for name, each in keywords.items()}
        return template(tuple(numba.types.unliteral(each) for each in arguments), plain)

    return call_template


def callback(signature: Any, function: Callable[..., Any]) -> Any:
    """Compile a function that other compiled code calls by its ``address``; numba's ``cfunc``.

    A division by zero is infinite: no caller of an address could hear of an exception, which would be printed.
    """
    options = {"error_model": "numpy"}
    found: Any = CFunc(function, numba.core.sigutils.normalize_signature(signature), locals={}, options=options)
    found._cache = CompiledCode(cast(FunctionType, function), options)
    found.compile()
    return found


class CompiledCode(_Cache):
    """Machine code of one function on disk, a file for each combination of argument types.

    Files are written under another name and renamed, and their names say all that distinguishes their contents, so that
    processes may write and read at once. A file that cannot be read counts as none.

    Parameters
    ----------
    function : function
        Not compiled yet.
    options : dict
        Of numba's decorator.
    """

    def __init__(self, function: FunctionType, options: dict[str, Any]) -> None:
        self._function = function
        self._options = options
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """Folder of the files."""
        return str(folder())

    def enable(self) -> None:
        """Read and write files from now on."""
        self._enabled = True

    def disable(self) -> None:
        """Leave the files alone from now on."""
        self._enabled = False

    def flush(self) -> None:
        """Remove the files of every version of the function."""
        for path in self._versions():
            path.unlink(missing_ok=True)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled function for a signature, None where there is none yet."""
        if not self._enabled:
            return None
        # Machine code needs the runtime alone; the registries, which numba's own cache loads here, serve compiling.
        rtsys.initialize(target_context)
        path = self._path(sig, target_context.codegen())
        try:
            found = CompileResult._rebuild(target_context, *pickle.loads(path.read_bytes()))
        except FileNotFoundError:
            found = None
        except Exception:  # unpickling may raise anything, and what is damaged is simply compiled again
            path.unlink(missing_ok=True)
            found = None
        if found is None:
            announce(self._function.__module__)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function; whatever cannot be written is compiled again next time."""
        if not self._enabled or data.library.has_dynamic_globals or any(not part.can_cache for part in data.lifted):
            return
        path = self._path(sig, data.codegen)
        try:
            with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".", delete=False) as file:
                file.write(dumps(data._reduce()))
            os.replace(file.name, path)
        except OSError as error:
            warnings.warn(f"compiled code is not kept in {path.parent}: {error}", stacklevel=2)
            return
        for old in sorted(self._versions(), key=_age)[VERSIONS_KEPT:]:
            old.unlink(missing_ok=True)

    def _versions(self) -> Iterator[Path]:
        return folder().glob(f"{self._name()}-*.code")

    def _name(self) -> str:
        return f"{self._function.__module__}.{self._function.__qualname__}".replace("<", "").replace(">", "")

    def _path(self, signature: Any, codegen: Any) -> Path:
        types = signature if isinstance(signature, tuple) else (*signature.args, signature.return_type)
        key = hashlib.sha256(digest(self._function).encode())
        for part in (
            sorted((name, _plain(value)) for name, value in self._options.items()),
            [_described(each) for each in types],
            codegen.magic_tuple(),
            numba.__version__,
            platform.python_version_tuple()[:2],
        ):
            key.update(repr(part).encode())
        return folder() / f"{self._name()}-{key.hexdigest()[:32]}.code"


def _age(path: Path) -> float:
    """Seconds since the file was written, larger for an older one; infinite if another process removed it."""
    with suppress(OSError):
        return -path.stat().st_mtime
    return float("inf")


def _plain(value: Any) -> Any:
    return sorted(value) if isinstance(value, set | frozenset) else value


def _described(kind: Any) -> str:
    """Type of an argument, with the names of fields: attributes are compiled to places in the tuple."""
    if hasattr(kind, "instance_class"):
        fields = zip(kind.fields, kind.types, strict=True)
        return f"{kind.instance_class.__qualname__}({', '.join(f'{n}: {_described(t)}' for n, t in fields)})"
    if isinstance(kind, UniTuple | Tuple):
        return f"({', '.join(_described(each) for each in kind.types)})"
    return f"{type(kind).__name__} {kind}"


@cache
def folder() -> Path:
    """Folder of the machine code: that of ``CAMID_CACHE``, or one in the user's cache; a temporary one if need be."""
    from platformdirs import user_cache_path

    named = os.environ.get(VARIABLE)
    path = (Path(named) if named else user_cache_path("camid")) / "compiled"
    try:
        path.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=path).close()
    except OSError as error:
        temporary = Path(tempfile.mkdtemp(prefix="camid-compiled-"))
        atexit.register(shutil.rmtree, temporary, ignore_errors=True)
        warnings.warn(
            f"compiled code cannot be kept in {path} ({error.strerror}), so that every process compiles again; set "
            f"{VARIABLE} to a folder that can be written",
            stacklevel=2,
        )
        return temporary
    return path


_announced: set[str] = set()


def announce(module: str) -> None:
    """Say on standard error, once per process and purpose, what the user waits for."""
    purpose = next((words for name, words in PURPOSES.items() if module.startswith(f"{name}.")), module)
    if purpose not in _announced:
        _announced.add(purpose)
        print(f"camid: compiling {purpose}, once per installation", file=sys.stderr, flush=True)


def keep_quiet() -> None:
    """Compile without saying so, in a process that says it in its own way."""
    _announced.update(PURPOSES.values())


# -- what a function compiles to, as a digest -------------------------------------------------------------------------

# None marks a function that is being read.
_digests: dict[FunctionType, str | None] = {}


def digest(function: FunctionType) -> str:
    """Hash of all that decides what a function compiles to, apart from its options and the types of its arguments.

    Raises
    ------
    TypeError
        If the function refers to something whose changes would go unnoticed.
    """
    found = _digests.get(function)
    if found is None:
        if function in _digests:
            raise TypeError(f"{function.__qualname__} is part of a circle of compiled functions")
        _digests[function] = None
        try:
            code, names = function.__code__, function.__globals__
            content = hashlib.sha256(f"{function.__module__}.{function.__qualname__}".encode())
            for part in (function.__defaults__, *(cell.cell_contents for cell in function.__closure__ or ())):
                content.update(_content(part).encode())
            content.update(_content_of_code(code, names, function.__doc__, function).encode())
            found = content.hexdigest()
        finally:
            del _digests[function]
        _digests[function] = found
    return found


def _content(value: Any) -> str:  # noqa: PLR0911 - one for each kind of value
    """Text that differs between any two values that compile to something else."""
    kind = type(value).__name__
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic | Type):
        return f"{kind} {value!r}"
    if isinstance(value, tuple | list):
        return f"{kind} [{', '.join(_content(each) for each in value)}]"
    if isinstance(value, np.ndarray):
        return f"array {value.dtype.str} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, Dispatcher):
        options = sorted((name, _plain(option)) for name, option in value.targetoptions.items())
        return f"{options} {digest(value.py_func)}"
    if isinstance(value, FunctionType):
        return digest(value)
    if isinstance(value, _Intrinsic):
        return digest(value._defn)
    if isinstance(value, CodeType):
        return _content_of_code(value, {})
    if isinstance(value, ModuleType | BuiltinFunctionType | np.ufunc):
        return f"{kind} {getattr(value, '__module__', '')} {value.__name__}"
    if isinstance(value, type):
        return f"class {value.__module__}.{value.__qualname__} {getattr(value, '_fields', ())}"
    raise TypeError(f"compiled code refers to {value!r}, whose changes the kept machine code would not follow")


def _content_of_code(
    code: CodeType, names: dict[str, Any], docstring: str | None = None, itself: FunctionType | None = None
) -> str:
    """Instructions with what they refer to; no line numbers, and no docstring."""
    constants = code.co_consts
    if docstring is not None and constants[0] == docstring:
        constants = (None, *constants[1:])
    arguments = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    flags = code.co_flags & (CO_VARARGS | CO_VARKEYWORDS | CO_GENERATOR)
    parts = [repr((code.co_code, code.co_exceptiontable, code.co_names, arguments, flags)), _content(constants)]
    nested = (each for each in constants if isinstance(each, CodeType))
    for name in sorted({*_global_names(code), *(name for each in nested for name in _global_names(each))}):
        value = names.get(name)
        if getattr(value, "py_func", value) is itself:
            continue
        parts.append(f"{name}: {_content(value)}")
        # Constants and functions of the package may be used through their module.
        if isinstance(value, ModuleType) and value.__name__.startswith("camid."):
            parts += [_content(getattr(value, each)) for each in code.co_names if hasattr(value, each)]
    return "; ".join(parts)


def _global_names(code: CodeType) -> list[str]:
    """Global names that a function reads. :mod:`dis` says the same, in a time that every start would notice."""
    found, extended = [], 0
    for operation, argument in zip(code.co_code[::2], code.co_code[1::2], strict=True):
        whole = extended | argument
        extended = whole << 8 if operation == EXTENDED_ARG else 0
        if operation == LOAD_GLOBAL:
            found.append(code.co_names[whole >> 1])
    return found
