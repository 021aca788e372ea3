"""Names of columns, files and folders that are markup, shell or paths: text, wherever they turn up."""

import re
from html.parser import HTMLParser
from pathlib import Path

import pandas as pd
import pytest

from camid.cli import main
from tests.support import ROOT, hostile_files, hostile_numbers
from tests.support import linear_rig as rig

IMAGE = '"><img src=x onerror=alert(1)>'


class Elements(HTMLParser):
    """Elements of a page, and whether one has an event handler."""

    def __init__(self):
        super().__init__()
        self.seen, self.handlers, self.links = [], [], []

    def handle_starttag(self, tag, attributes):
        self.seen.append(tag)
        self.handlers += [name for name, _ in attributes if name.startswith("on")]
        self.links += [value for name, value in attributes if name in {"src", "href"} and value]


def elements(page):
    parser = Elements()
    parser.feed(page)
    return parser


def diagnosed(folder, output, recording):
    """report.html of a recording whose output and file have these names."""
    folder.mkdir()
    rig.recording(200).rename(columns={"y": output}).to_csv(folder / recording, index=False)
    rig.write_yaml(rig.simulation(sensor={"column": output, "kind": "camera"}), folder / "S.yaml")
    arguments = ["diagnose", recording, "--simulation", "S.yaml", "--output", "out", "--time-limit", "1"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(arguments) == 0
    return (folder / "out/report.html").read_text(encoding="utf-8")


def test_markup_in_names_is_text_in_the_report(tmp_path):
    plain = elements(diagnosed(tmp_path / "plain", "y", "recording.csv"))
    for number, name in enumerate((hostile_files.SCRIPT, IMAGE)):
        page = diagnosed(tmp_path / str(number), name, "<script>alert(2)<!--.csv")
        found = elements(page)
        assert found.seen.count("script") == plain.seen.count("script")
        assert found.seen.count("img") == plain.seen.count("img")
        assert found.handlers == plain.handlers
        assert "alert(1)" in page  # the name is there, as text
        assert hostile_files.SCRIPT not in page
        assert IMAGE not in page


@pytest.mark.parametrize("name", hostile_numbers.NAMES)
def test_any_name_of_a_column_and_a_folder(tmp_path, monkeypatch, capsys, name):
    folder = tmp_path / "ein Ordner · $(touch owned); <b> & 'x'"
    folder.mkdir()
    monkeypatch.chdir(folder)
    rig.recording().rename(columns={"y": name}).to_csv("rec `touch owned`.csv", index=False)
    rig.write_yaml(rig.simulation(sensor={"column": name, "kind": "camera"}), Path("S.yaml"))
    start = ["rec `touch owned`.csv", "--simulation", "S.yaml", "--output"]
    assert main(["identify", *start, "model.yaml"]) == 0
    assert main(["simulate", start[0], "--simulation", "model.yaml", "--output", "simulated.csv"]) == 0
    assert sorted(p.name for p in folder.iterdir()) == ["S.yaml", "model.yaml", start[0], "simulated.csv"]
    assert name in pd.read_csv("simulated.csv").columns
    capsys.readouterr()


def test_no_shell_is_given_anything():
    """Neither the package nor the workflow calls one; shell commands of the rules quote what they are given."""
    sources = [*ROOT.glob("src/**/*.py"), *ROOT.glob("workflow/**/*.py")]
    assert len(sources) > 300
    called = re.compile(r"shell\s*=\s*True|os\.system|os\.popen|getoutput")
    assert [p for p in sources if called.search(p.read_text(encoding="utf-8"))] == []
    rules = "\n".join(p.read_text(encoding="utf-8") for p in ROOT.glob("workflow/rules/*.smk"))
    for command in re.findall(r"shell:\s*\n((?:\s+f?\"[^\n]*\n)+)", rules):
        # Of the parameters, the command itself and its options are made by the rules, from nothing of a user's.
        fields = set(re.findall(r"\{([^}]*)\}", command)) - {"params.camid", "params.options"}
        assert fields
        assert all(field.endswith(":q") for field in fields), command
