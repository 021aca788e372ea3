# What every stage needs: which sources a rule depends on, and whether this working copy has computed anything yet.

import ast
import shlex
import sys
import time
from pathlib import Path

ROOT = Path(workflow.basedir)
# The command line of the environment that runs the workflow, whatever the PATH.
CAMID = f"{shlex.quote(sys.executable)} -m camid"
FIGURES = [f"fig{number}" for number in range(1, 9)]

# A fresh clone holds the committed figures but none of the data behind them, and to Snakemake a file that is there is up
# to date. This mark is made when the workflow is first read in a working copy (or after results/ was removed); it is
# newer than anything committed, and every rule that writes into paper_figs/ depends on it. Its content is the time,
# because Snakemake takes a new file with the old content for unchanged.
BIRTH_MARK = "results/.working-copy"
if not Path(BIRTH_MARK).exists():
    Path(BIRTH_MARK).parent.mkdir(exist_ok=True)
    Path(BIRTH_MARK).write_text(f"{time.time_ns()}\n")


def running_nodes(tree):
    """All nodes of a syntax tree but those that only a type checker reads."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            waiting.extend(node.orelse)
            continue
        yield node
        waiting.extend(ast.iter_child_nodes(node))


def imported_modules(source):
    """Files of camid that a Python file imports, at any depth of its code."""
    package = ROOT / "src"
    names = set()
    for node in running_nodes(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    files = set()
    for name in names:
        if name.split(".")[0] == "camid":
            parts = name.split(".")
            candidates = [
                package.joinpath(*parts).with_suffix(".py"),
                package.joinpath(*parts, "__init__.py"),
            ]
            candidates += [
                package.joinpath(*parts[:end], "__init__.py")
                for end in range(1, len(parts))
            ]
            files.update(file for file in candidates if file.is_file())
    return files


def sources(*starts):
    """All files of camid that the given files reach through imports, so that a change in any of them reruns the rule.

    Snakemake watches a rule's own script but not what the script imports. The files are inputs, so the cache between
    workflows keys on their contents, too.
    """
    reached, waiting = set(), [ROOT / start for start in starts]
    while waiting:
        file = waiting.pop()
        if file not in reached:
            reached.add(file)
            waiting.extend(imported_modules(file))
    return sorted(str(file.relative_to(ROOT)) for file in reached)
