"""Digests of code: what counts as a change, and for whom."""

import shutil
import sys
from pathlib import Path

import pytest

from tests.support import ROOT

sys.path.insert(0, str(ROOT / "workflow"))

from code_digest import CodeDigest

DIAGNOSIS = "camid.cli.diagnose"


@pytest.fixture
def digest_of(tmp_path, monkeypatch):
    """A copy of the package, and a function that takes a digest of it as it is now."""
    sources = tmp_path / "src"
    shutil.copytree(ROOT / "src", sources, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.syspath_prepend(str(sources))

    def digest(*starts):
        code = CodeDigest(sources, tmp_path / "cache.json")
        try:
            return code(*starts)
        finally:
            code.save()  # as at the end of a process

    digest.sources = sources / "camid"
    return digest


def changed(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_docstring_and_comment_count_for_nothing(digest_of):
    before = digest_of(DIAGNOSIS)
    path = digest_of.sources / "errors.py"
    path.write_text('"""Other words."""\n# and a comment\n' + path.read_text().split('"""', 2)[2], encoding="utf-8")
    assert digest_of(DIAGNOSIS) == before
    path.write_text(path.read_text() + "\nCHANGED = True\n", encoding="utf-8")
    assert digest_of(DIAGNOSIS) != before


def test_module_counts_for_those_that_reach_it(digest_of):
    starts = [DIAGNOSIS, "camid.paper.fig7_sampling_period.runs", "camid.paper.fig1_marker_image.drawing"]
    before = [digest_of(start) for start in starts]
    with (digest_of.sources / "identification/srivc.py").open("a", encoding="utf-8") as file:
        file.write("\nCHANGED = True\n")
    assert [digest_of(start) != old for start, old in zip(starts, before, strict=True)] == [True, True, False]


def test_template_of_the_report_counts_for_the_diagnosis_alone(digest_of):
    starts = [DIAGNOSIS, "camid.paper.fig7_sampling_period.runs"]
    before = [digest_of(start) for start in starts]
    changed(digest_of.sources / "diagnosis/report/templates/report.html", "<", "<!-- changed --><")
    assert [digest_of(start) != old for start, old in zip(starts, before, strict=True)] == [True, False]


def test_command_line_connects_no_command_with_another(digest_of):
    code = CodeDigest(digest_of.sources.parent, digest_of.sources / "cache.json")
    files = {str(p.relative_to(digest_of.sources)) for p in code.files(DIAGNOSIS)}
    assert "commands/diagnose.py" in files
    assert not [f for f in files if f.startswith(("tracking/", "cli/__init__", "proof/"))]
    blind = {str(p.relative_to(digest_of.sources)) for p in code.files("camid.proof.diagnoses", DIAGNOSIS)}
    assert not [f for f in blind if f.startswith("proof/concealed/")]


def test_script_counts_with_what_it_imports(digest_of):
    code = CodeDigest(digest_of.sources.parent, digest_of.sources / "cache.json")
    files = code.files(ROOT / "workflow/scripts/draw.py", "camid.paper.fig8_neglected_mode.drawing")
    names = {p.name for p in files}
    assert {"draw.py", "drawing.py", "plotting.py", "job.py"} <= names
    assert "srivc.py" not in names


def test_name_that_is_nothing_is_refused(digest_of):
    with pytest.raises(ValueError, match=r"camid\.nothing: neither a module of camid nor a file"):
        digest_of("camid.nothing")
