"""Digests of the code that a rule uses, so that a changed module reruns the rules that use it, and a docstring none.

Snakemake watches a rule's own script but not what the script imports. A digest covers every module of the package that
given modules reach through imports, and the package data (a template, a schema) that those name. It is a parameter of
the rule: another digest reruns it, and the cache between workflows keys on it, too. Comments, blank lines and
docstrings do not count; a result may not depend on them.
"""

from __future__ import annotations

import ast
import atexit
import hashlib
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import grimp

PACKAGE = "camid"
# The command line imports all commands. A rule that calls a command names the module of that command instead.
COMMAND_LINE = f"{PACKAGE}.cli"
NAME_OF_A_FILE = re.compile(r"[\w./-]+\.[a-z]\w*")
# The digest is that of a syntax tree, which other versions of Python write otherwise.
PYTHON = f"{sys.version_info.major}.{sys.version_info.minor}"


@dataclass(frozen=True)
class _Read:
    """What was read of a Python file: time in ns and size, digest without docstrings, strings that may name a file."""

    stamp: tuple[int, int]
    digest: str
    names: tuple[str, ...]


class CodeDigest:
    """Digests of modules with all that they reach.

    Parameters
    ----------
    sources : path
        Folder that holds the package, first on the path of imports.
    cache : path
        JSON file that keeps what was read; a file is read again when its time or size has changed.
    """

    def __init__(self, sources: Path, cache: Path) -> None:
        self._sources, self._cache = sources, cache
        self._graph = grimp.build_graph(PACKAGE, exclude_type_checking_imports=True, cache_dir=None)
        self._data: dict[str, list[Path]] = {}
        for path in sorted((sources / PACKAGE).rglob("*.*")):
            if path.suffix not in {".py", ".pyc"} and path.is_file():
                self._data.setdefault(path.name, []).append(path)
        self._kept: dict[str, _Read] = {}
        self._new = False
        atexit.register(self.save)
        self._digests: dict[tuple[str | Path, ...], str] = {}
        self._files: dict[str, Path] = {}
        self._current: dict[Path, _Read] = {}
        try:
            kept = json.loads(cache.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            kept = {}
        if kept.get("python") == PYTHON:
            self._kept = {
                file: _Read((time, size), digest, tuple(names))
                for file, (time, size, digest, names) in kept["files"].items()
            }

    def __call__(self, *starts: str | Path) -> str:
        """Digest of modules (dotted names) and scripts (paths) with everything that they reach."""
        if starts not in self._digests:
            digest = hashlib.sha256()
            for path in self.files(*starts):
                content = self._read(path).digest if path.suffix == ".py" else _digest(path.read_bytes())
                digest.update(f"{path.relative_to(self._sources.parent)} {content}\n".encode())
            self._digests[starts] = digest.hexdigest()
        return self._digests[starts]

    def files(self, *starts: str | Path) -> list[Path]:
        """The files that a digest covers, sorted.

        Raises
        ------
        ValueError
            If a start is neither a module of the package nor a file.
        """
        waiting, found, reached = [], set(), set()
        for start in starts:
            if str(start) in self._graph.modules:
                waiting.append(str(start))
            elif Path(start).is_file():
                found.add(Path(start))
                waiting += self._imported_by_script(Path(start))
            else:
                raise ValueError(f"{start}: neither a module of {PACKAGE} nor a file")
        while waiting:
            module = waiting.pop()
            if module in reached or module == COMMAND_LINE:
                continue
            reached.add(module)
            waiting += self._graph.find_modules_directly_imported_by(module)
            if "." in module:  # whose package is imported first
                waiting.append(module.rpartition(".")[0])
        found |= {self._file(module) for module in reached}
        for path in tuple(found):
            for name in self._read(path).names:
                found.update(self._data.get(Path(name).name, ()))
        return sorted(found)

    def save(self) -> None:
        """Keep what was read for the next time."""
        if self._new:
            files = {file: (*read.stamp, read.digest, read.names) for file, read in self._kept.items()}
            self._cache.parent.mkdir(parents=True, exist_ok=True)
            temporary = self._cache.with_suffix(".new")
            temporary.write_text(json.dumps({"python": PYTHON, "files": files}), encoding="utf-8")
            temporary.replace(self._cache)

    def _imported_by_script(self, script: Path) -> list[str]:
        """Modules of the package that a file outside it imports."""
        names = []
        for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names += [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        return [name for name in names if name in self._graph.modules]

    def _file(self, module: str) -> Path:
        if module not in self._files:
            folder = self._sources.joinpath(*module.split("."))
            package = folder / "__init__.py"
            self._files[module] = package if package.is_file() else folder.with_suffix(".py")
        return self._files[module]

    def _read(self, path: Path) -> _Read:
        if path not in self._current:
            status = path.stat()
            stamp = (status.st_mtime_ns, status.st_size)
            kept = self._kept.get(str(path))
            self._current[path] = kept if kept is not None and kept.stamp == stamp else self._parse(path, stamp)
        return self._current[path]

    def _parse(self, path: Path, stamp: tuple[int, int]) -> _Read:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        _remove_docstrings(tree)
        strings = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str)}
        names = tuple(sorted(s for s in strings if NAME_OF_A_FILE.fullmatch(s)))
        self._kept[str(path)], self._new = _Read(stamp, _digest(ast.dump(tree).encode()), names), True
        return self._kept[str(path)]


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _remove_docstrings(tree: ast.AST) -> None:
    for node in ast.walk(tree):
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) or not node.body:
            continue
        first = node.body[0]
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
            del node.body[0]
