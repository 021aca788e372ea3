"""The folder of machine code: what makes camid compile again, and what does not."""

import dis
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from camid import compiled
from camid.engine.integrator import integrate

SOURCE = Path(compiled.__file__).parent

CALLEE = '''"""A module with a constant and a function that another module calls."""

from camid.compiled import njit

FACTOR = 2.0


@njit
def scaled(x):
    """Docstring."""
    return FACTOR * x
'''
CALLER = '''"""A module that calls it."""

from typing import NamedTuple

from callee import scaled

from camid.compiled import njit


class Pair(NamedTuple):
    """Two numbers."""

    first: float
    second: float


@njit
def difference(pair):
    """Docstring."""
    return scaled(pair.first) - pair.second
'''
MAIN = """
from caller import Pair, difference

result = difference(Pair(first=5.0, second=1.0))
print(result, sum(difference.stats.cache_misses.values()))
"""


def written(folder):
    """Folder with two modules of compiled code."""
    folder.mkdir()
    (folder / "callee.py").write_text(CALLEE, encoding="utf-8")
    (folder / "caller.py").write_text(CALLER, encoding="utf-8")
    (folder / "main.py").write_text(MAIN, encoding="utf-8")
    return folder


@pytest.fixture
def package(tmp_path):
    return written(tmp_path / "one")


@pytest.fixture(scope="module")
def compiled_before(tmp_path_factory):
    """Such a folder, and that of its compiled code."""
    base = tmp_path_factory.mktemp("compiled")
    run(written(base / "one"), base / "cache")
    return base / "one", base / "cache"


def start(folder, cache):
    environment = {**os.environ, "CAMID_CACHE": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.Popen(
        [sys.executable, "main.py"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def outcome(process):
    """Result, number of functions called from Python that were compiled, and standard error."""
    printed, complaint = process.communicate(timeout=300)
    assert process.returncode == 0, complaint
    result, misses = printed.split()
    return float(result), int(misses), complaint


def run(folder, cache):
    return outcome(start(folder, cache))


def edit(folder, name, *changes):
    path = folder / name
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def test_neither_another_folder_nor_docstrings_and_comments_compile_again(package, tmp_path):
    cache, copy = tmp_path / "cache", tmp_path / "two"
    result, misses, said = run(package, cache)
    assert (result, misses) == (9.0, 1)
    assert said.count("compiling") == 2  # a line for each of the two modules
    shutil.copytree(package, copy)
    for name in ("callee.py", "caller.py"):
        edit(
            copy,
            name,
            ("Docstring.", "Other words,\n\n    over several lines."),
            ("\n@njit", "# A comment.\n\n\n@njit"),
        )
    assert run(copy, cache) == (9.0, 0, "")


@pytest.mark.parametrize(
    ("name", "old", "new", "expected"),
    [
        ("callee.py", "FACTOR * x", "FACTOR + x", 6.0),
        ("callee.py", "FACTOR = 2.0", "FACTOR = 3.0", 14.0),
        ("caller.py", "    first: float\n    second: float", "    second: float\n    first: float", 9.0),
    ],
)
def test_a_change_of_what_a_function_uses_compiles_it_again(compiled_before, tmp_path, name, old, new, expected):
    for folder in compiled_before:
        shutil.copytree(folder, tmp_path / folder.name)
    package, cache = (tmp_path / folder.name for folder in compiled_before)
    edit(package, name, (old, new))
    result, misses, _ = run(package, cache)
    assert (result, misses) == (expected, 1)


def test_processes_at_once_and_damaged_files(package, tmp_path):
    cache = tmp_path / "cache"
    for result, _, _ in map(outcome, [start(package, cache) for _ in range(2)]):
        assert result == 9.0
    files = list((cache / "compiled").iterdir())
    assert sorted(f.name.split("-")[0] for f in files) == ["callee.scaled", "caller.difference"]
    assert run(package, cache) == (9.0, 0, "")
    for file in files:
        file.write_bytes(file.read_bytes()[:100])
    assert run(package, cache)[:2] == (9.0, 1)


def test_what_is_kept_is_loaded_without_what_compiling_needs(package, tmp_path):
    """Numba's registries, which its own cache loads first."""
    edit(
        package,
        "main.py",
        ("print(result", "import sys\n\nloaded = 'numba.np.linalg' in sys.modules\nprint(int(loaded)"),
    )
    assert [outcome(start(package, tmp_path / "cache"))[0] for _ in range(2)] == [1.0, 0.0]


def test_a_folder_that_cannot_be_written_is_replaced_with_a_warning(package, tmp_path):
    taken = tmp_path / "file"
    taken.write_text("", encoding="utf-8")
    result, misses, said = run(package, taken)
    assert (result, misses) == (9.0, 1)
    assert f"compiled code cannot be kept in {taken}" in said


def test_global_names_are_those_of_the_disassembler():
    code = integrate.py_func.__code__
    expected = [i.argval for i in dis.get_instructions(code) if i.opname == "LOAD_GLOBAL"]
    assert "_integrate" in expected
    assert compiled._global_names(code) == expected


def test_what_cannot_be_followed_is_refused():
    namespace = {"table": {}}
    exec("def function():\n    return table[0]\n", namespace)
    with pytest.raises(TypeError, match="would not follow"):
        compiled.digest(namespace["function"])


def test_all_compiled_code_is_kept_in_this_folder():
    """numba's own ``cache=True`` does not see a change in a function of another module."""
    found = [p.name for p in SOURCE.rglob("*.py") if "cache=True" in p.read_text(encoding="utf-8")]
    assert found == []
    found = [p.name for p in SOURCE.rglob("*.py") if "from camid.compiled import" in p.read_text(encoding="utf-8")]
    assert len(found) > 10
    for path in SOURCE.rglob("*.py"):
        assert path.name == "compiled.py" or "numba import njit" not in path.read_text(encoding="utf-8"), path


CACHE_CHECK = """
import numpy as np
from camid.chain.acquisition import Acquisition
from camid.engine.mechanics import Chain
from camid.engine.run import run
from camid.engine.integrator import integrate
from camid.effects.hysteresis import Hysteresis
from camid.chain.plant import second_order
chain = Chain(second_order(1.0, 10.0, 0.1), Acquisition(0.02), (Hysteresis(strength=0.1, shape=2.0),))
run(chain, np.ones(20), 0.02 * np.arange(20))
hits = sum(integrate.stats.cache_hits.values())
misses = sum(integrate.stats.cache_misses.values())
print(hits, misses)
"""


def test_compiled_code_comes_from_the_disk_in_a_second_process():
    for _ in range(2):
        found = subprocess.run([sys.executable, "-c", CACHE_CHECK], capture_output=True, text=True, check=True).stdout
    assert found.split() == ["1", "0"]
