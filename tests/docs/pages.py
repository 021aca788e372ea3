"""The README and the pages of docs/ as blocks of code, and the comparison of an output with what a page shows.

``python -m tests.docs.pages`` runs the pages and rewrites the outputs that they show; read the difference before you
commit it.
"""

from __future__ import annotations

import contextlib
import difflib
import io
import itertools
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from tests.support import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^( *)```(\w+)[^\n]*\n(.*?)^\1```$", flags=re.DOTALL | re.MULTILINE)
# A line of this sign alone stands for any number of lines.
LEFT_OUT = "…"
NUMBER = re.compile(r"(?<![\w.])[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]*\w)")
COLUMNS = "100"
# Said only where the machine code is not kept yet.
COMPILING = "camid: compiling "


@dataclass(frozen=True)
class Block:
    """A block of code: its language, its text, and the line of the page where its text starts."""

    page: Path
    language: str
    text: str
    line: int
    start: int
    end: int


def blocks(page: Path, language: str) -> list[Block]:
    """The blocks of one language, in the order of the page."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(page, m[2], m[3], text.count("\n", 0, m.start(3)) + 1, m.start(3), m.end(3))
        for m in BLOCK.finditer(text)
        if m[2] == language
    ]


def commands(block: Block) -> list[tuple[str, list[str]]]:
    """Commands of a ``console`` block, each with the lines shown below it; a backslash continues a command."""
    found: list[tuple[str, list[str]]] = []
    continued = False
    for line in block.text.splitlines():
        if continued:
            found[-1] = (f"{found[-1][0]}\n{line}", [])
        elif line.startswith("$ "):
            found.append((line[2:], []))
        else:
            assert found, f"{block.page.name}:{block.line}: an output before the first command"
            found[-1][1].append(line)
        continued = line.endswith("\\")
    return found


def same_number(shown: str, printed: str) -> bool:
    """Whole numbers are equal; others differ by at most two in the last digit shown (another BLAS rounds elsewhere)."""
    if "." not in shown and "e" not in shown:
        return shown == printed
    mantissa, _, power = shown.replace("−", "-").partition("e")
    last = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
    return abs(float(shown.replace("−", "-")) - float(printed.replace("−", "-"))) <= 2.001 * last


def same_line(shown: str, printed: str) -> bool:
    """Equal text, numbers by :func:`same_number`; the width of columns does not count."""
    plain = [" ".join(NUMBER.sub("#", re.sub("[━─]+", "━", line)).split()) for line in (shown, printed)]
    numbers = [NUMBER.findall(line) for line in (shown, printed)]
    return plain[0] == plain[1] and all(same_number(a, b) for a, b in zip(*numbers, strict=True))


def difference(shown: list[str], printed: list[str]) -> str | None:
    """First line of a page that is not what was printed; None if all are.

    Parameters
    ----------
    shown : list of str
        Lines of the page; ``…`` stands for any lines up to the next one that matches.
    printed : list of str
        Lines of the command.
    """
    position, anywhere = 0, False
    for line in shown:
        if line.strip() == LEFT_OUT:
            anywhere = True
            continue
        rest = printed[position:]
        match = next((k for k, other in enumerate(rest) if same_line(line, other)), None) if anywhere else 0
        if match is None or match >= len(rest) or not same_line(line, rest[match]):
            return f"shown:   {line}\nprinted: {rest[0] if rest else '(nothing more)'}"
        position, anywhere = position + match + 1, False
    if position < len(printed) and not anywhere:
        return f"shown:   (nothing more)\nprinted: {printed[position]}"
    return None


# (command, files that it names and their contents) → lines, and files that it wrote.
_DONE: dict[tuple[str, frozenset[tuple[str, bytes]]], tuple[list[str], dict[str, bytes]]] = {}


class Session:
    """A folder with a copy of examples/ where the commands of one page run, one after the other."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "examples"
        shutil.copytree(ROOT / "examples", self.folder)
        programs = folder / "bin"
        programs.mkdir()
        (programs / "camid").write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m camid "$@"\n')
        (programs / "python").write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} "$@"\n')
        for program in programs.iterdir():
            program.chmod(0o755)
        self.environment = os.environ | {
            "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(ROOT / "src"),
            "COLUMNS": COLUMNS,
            "PYTHONIOENCODING": "utf-8",
            "MPLBACKEND": "agg",
        }

    def run(self, command: str) -> list[str]:
        """Lines that a command prints; an exit code that is not 0 is the last one.

        Where an earlier page ran the same command of camid on the same files, its lines and files are taken.
        """
        if command.startswith("cd "):
            self.folder = (self.folder / shlex.split(command)[1]).resolve(strict=True)
            return []
        if not command.startswith("camid "):
            return self._run(command)
        before = self._files()
        named = frozenset((name, content) for name, content in before.items() if name in shlex.split(command))
        if (command, named) not in _DONE:
            lines = self._run(command)
            written = {n: content for n, content in self._files().items() if before.get(n) != content}
            _DONE[command, named] = lines, written
        else:
            lines, written = _DONE[command, named]
            for name, content in written.items():
                path = self.folder / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
        return lines

    def _files(self) -> dict[str, bytes]:
        """Contents of all files, by their paths within the folder."""
        paths = (p for p in sorted(self.folder.rglob("*")) if p.is_file())
        return {str(p.relative_to(self.folder)): p.read_bytes() for p in paths}

    def _run(self, command: str) -> list[str]:
        """Lines of a command: of camid alone in this process, which imports and loads once; of others in a shell."""
        if command.startswith(("camid ", "python ")) and not re.search(r"[|<>&;$`*]", command):
            program, *arguments = shlex.split(command.replace("\\\n", " "))
            if program == "camid" or len(arguments) == 1:
                return self._run_here(program, arguments)
        done = subprocess.run(
            ["sh", "-c", f"{command} 2>&1"],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=600,
        )
        return _shown(done.stdout, done.returncode)

    def _run_here(self, program: str, arguments: list[str]) -> list[str]:
        from camid.cli import main as camid

        printed, code = io.StringIO(), 0
        with (
            mock.patch.dict(os.environ, self.environment),
            contextlib.chdir(self.folder),
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(printed),
        ):
            if program == "camid":
                code = camid(arguments)
            else:
                runpy.run_path(arguments[0], run_name="__main__")
        return _shown(printed.getvalue(), code)


def _shown(printed: str, code: int) -> list[str]:
    lines = [line.rstrip() for line in printed.splitlines() if not line.startswith(COMPILING)]
    return lines if code == 0 else [*lines, f"[exit code {code}]"]


def elided(shown: list[str], printed: list[str]) -> list[str]:
    """What is printed now, without what the page left out: of the lines between, those that are most alike."""
    found: list[str] = []
    position, ends = 0, [i for i, line in enumerate(shown) if line.strip() == LEFT_OUT]
    for start, end in itertools.pairwise([-1, *ends, len(shown)]):
        part = shown[start + 1 : end]
        room = len(printed) - len(part) + 1
        # What follows the command, or ends the output, stays there.
        places = range(position, room) if start >= 0 and end < len(shown) else [room - 1] if start >= 0 else [0]
        if part and not places:
            return printed
        best = max(places, key=lambda k: likeness(part, printed[k : k + len(part)]), default=position)
        found += [*printed[best : best + len(part)], *([LEFT_OUT] if end < len(shown) else [])]
        position = best + len(part)
    return found if difference(found, printed) is None else printed


def likeness(lines: list[str], others: list[str]) -> float:
    """From 0 to 1."""
    return difflib.SequenceMatcher(None, "\n".join(lines), "\n".join(others), autojunk=False).ratio()


def rewritten(page: Path, session: Session) -> str:
    """The page with the outputs of today; where what it shows still matches, it stays as it is."""
    text = page.read_text(encoding="utf-8")
    pieces, position = [], 0
    for block in blocks(page, "console"):
        lines: list[str] = []
        for command, shown in commands(block):
            printed = session.run(command)
            lines += [f"$ {command}", *(shown if difference(shown, printed) is None else elided(shown, printed))]
        pieces += [text[position : block.start], "\n".join(lines), "\n"]
        position = block.end
    return "".join([*pieces, text[position:]])


def main(names: list[str]) -> None:
    """Rewrite the outputs of the pages named, or of all."""
    for page in PAGES:
        if (not names or page.name in names) and blocks(page, "console"):
            with tempfile.TemporaryDirectory() as folder:
                page.write_text(rewritten(page, Session(Path(folder))), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
