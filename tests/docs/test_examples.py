"""What README.md and docs/ show is what happens: every command is run, every output compared, every file loaded."""

import re
import subprocess
import sys

import pytest
from ruamel.yaml import YAML

from camid.cli import cli
from camid.simulation.file import load_simulation
from tests.docs.pages import PAGES, ROOT, Session, blocks, commands, difference, elided, same_line

README_BYTES = 8000
WITH_COMMANDS = [page for page in PAGES if blocks(page, "console")]
YAML_BLOCKS = [(page, block) for page in PAGES for block in blocks(page, "yaml")]
PYTHON_BLOCKS = [page for page in PAGES if blocks(page, "python") and page.name != "adding_an_effect.md"]
# Commands that set up, test or compute for minutes: not run here, but they have to exist.
LONG = re.compile(r"^(make|\.venv/bin/snakemake|pip install|git clone|cd|\.venv/bin/python -m pytest)\b")


def name(page):
    return str(page.relative_to(ROOT))


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_bytes()) <= README_BYTES


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=name)
def test_commands_print_what_the_page_shows(page, tmp_path):
    session = Session(tmp_path)
    for block in blocks(page, "console"):
        for command, shown in commands(block):
            found = difference(shown, session.run(command))
            assert found is None, f"{name(page)}, $ {command}\n{found}"


@pytest.mark.parametrize("page", PYTHON_BLOCKS, ids=name)
def test_python_runs_and_prints_its_comments(page, tmp_path):
    """A comment that starts with an arrow is what the line before prints."""
    session = Session(tmp_path)
    text = "\n".join(block.text for block in blocks(page, "python"))
    (session.folder / "page.py").write_text(text, encoding="utf-8")
    shown = re.findall(r"^ *# → (.*)$", text, flags=re.MULTILINE)
    assert difference(shown, session.run("python page.py")) is None, difference(shown, session.run("python page.py"))


@pytest.mark.parametrize(("page", "block"), YAML_BLOCKS, ids=[f"{name(p)}:{b.line}" for p, b in YAML_BLOCKS])
def test_simulations_load(page, block):
    """Whole files as they are; a part of one in the place of the same part of a whole file."""
    yaml = YAML(typ="safe")
    alternatives = re.split(r"^# or\b.*$", block.text, flags=re.MULTILINE)
    for text in alternatives:
        part = yaml.load(text)
        whole = {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": {"transfer_function": {"numerator": [100.0], "denominator": [1.0, 2.0, 100.0]}},
            "sensor": {"column": "y", "kind": "camera", "exposure": 0.02},
        }
        load_simulation(part if "schema" in part else whole | part)


def test_no_output_goes_unchecked():
    """Blocks of other languages show neither commands with outputs nor numbers of a run."""
    known = {"console", "python", "yaml", "sh", "text", "bibtex"}
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        languages = set(re.findall(r"^ *```(\w*)", text, flags=re.MULTILINE)) - {""}
        assert languages <= known, f"{name(page)}: {languages - known}"
        if page.name == "real_recordings.md":
            continue  # written by the target `recordings`, which runs its commands
        for line in (line for block in blocks(page, "sh") for line in block.text.splitlines()):
            assert LONG.match(line.strip()) or not line.strip(), f"{name(page)}: make this a console block: {line}"


def targets():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    return set(re.findall(r"^([a-z-]+):", makefile, flags=re.MULTILINE))


def test_targets_of_make_exist():
    known = targets()
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    named = set(re.findall(r"`make ([a-z-]+)", text))
    for block in (block for page in PAGES for block in blocks(page, "sh")):
        named |= set(re.findall(r"^make ([a-z-]+)", block.text, flags=re.MULTILINE))
    assert {"test", "docs", "check"} <= named
    assert named <= known, f"there is no make {named - known}"


def test_options_exist():
    commands = [c for command in cli.commands.values() for c in getattr(command, "commands", {"": command}).values()]
    known = {option for command in commands for p in command.params for option in (*p.opts, *p.secondary_opts)}
    for page in (page for page in PAGES if page.name not in {"workflow.md", "cluster.md"}):  # options of Snakemake
        for line in page.read_text(encoding="utf-8").splitlines():
            if re.search(r"snakemake|pip |make |mkdocs|git ", line):
                continue
            for option in re.findall(r"`(--[a-z-]+)", line):
                assert option in known | {"--help"}, f"{name(page)}: {option}"


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("error 0.411 % of 1500", "error 0.413 % of 1500", True),
        ("error 0.411 % of 1500", "error 0.414 % of 1500", False),
        ("error 0.411 % of 1500", "error 0.411 % of 1501", False),
        ("│ a   │ 1.5e-05 │", "│ a │ 1.7e-05 │", True),
        ("│ a   │ 1.5e-05 │", "│ a │ 1.5e-04 │", False),
        ("verdict: explained", "verdict: adequate", False),
    ],
)
def test_the_comparison_tells_lines_apart(shown, printed, same):
    assert same_line(shown, printed) is same


def test_the_comparison_sees_lines_too_many_and_too_few():
    assert difference(["a", "…", "d"], ["a", "b", "c", "d"]) is None
    assert difference(["a", "…"], ["a", "b"]) is None
    assert difference(["a"], ["a", "b"]) is not None
    assert difference(["a", "b"], ["a"]) is not None
    assert difference(["…", "e"], ["a", "b"]) is not None


def test_a_page_that_is_rewritten_leaves_out_what_it_did():
    printed = ["a 2", "b", "x", "y", "c 4", "z"]
    assert elided(["a 1", "b", "…", "c 3", "…"], printed) == ["a 2", "b", "…", "c 4", "…"]
    assert elided(["…", "last 1"], ["a", "b", "last 2"]) == ["…", "last 2"]
    assert elided(["a", "b"], ["a", "c", "b"]) == ["a", "c", "b"]
    assert elided(["a", "b", "c", "…"], ["a"]) == ["a", "…"]


@pytest.mark.parametrize("maker", ["make_recording.py", "make_two_clocks.py", "make_magnet.py", "make_detent.py"])
def test_examples_are_what_their_scripts_write(maker, tmp_path):
    """The recording is made without camid, and its script still writes it, to the byte."""
    source = (ROOT / "examples" / maker).read_text(encoding="utf-8")
    assert not re.search(r"^\s*(import|from) camid", source, flags=re.MULTILINE)
    subprocess.run([sys.executable, ROOT / "examples" / maker], cwd=tmp_path, check=True)
    for made in tmp_path.iterdir():
        assert made.read_bytes() == (ROOT / "examples" / made.name).read_bytes()
