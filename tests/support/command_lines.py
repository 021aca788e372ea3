"""Command lines, and what they leave behind."""

from pathlib import Path

from ruamel.yaml import YAML

from camid.cli import main

IDENTIFY = ["identify", "recording.csv", "--simulation", "S.yaml", "--output", "model.yaml"]
SIMULATE = ["simulate", "recording.csv", "--simulation", "S.yaml", "--output", "simulated.csv"]


def load(path):
    return YAML(typ="safe", pure=True).load(path)


def contents():
    return {path: path.read_bytes() for path in Path().iterdir() if path.is_file()}


def refusal(capsys, arguments):
    """Run a command that has to fail and return its message."""
    before = contents()
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("camid: error: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    after = contents()
    assert after == before
    return err


def replaced(arguments, *changes):
    changed = [*arguments]
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        changed[changed.index(old)] = new
    return changed
