"""The page of a diagnosis: complete for every verdict, self-contained, safe with any name, and drawn beside it."""

import re
import shutil
import sys

import pytest

from camid.diagnosis.diagnosis import Location
from camid.diagnosis.finding import ParameterEstimate
from camid.diagnosis.report import beside, summary
from camid.diagnosis.report import page as report
from camid.diagnosis.results_folder import FILES, write_diagnosis
from camid.effects import known_effects
from tests.support import written_diagnoses
from tests.support.report_page import HOSTILE, Page

SECTIONS = ["location", "effects", "structure", "fit", "coefficients", "tests", "undetectable", "about"]


@pytest.mark.parametrize("verdict", summary.VERDICT_WORDS)
def test_every_verdict_has_its_sections(pages, verdict):
    page = Page(pages[verdict])
    diagnosis = written_diagnoses.diagnosis(verdict)
    assert page.sections == SECTIONS
    symbol, word, meaning = summary.VERDICT_WORDS[verdict]
    assert f"{symbol} {word} {meaning}" in page.text
    assert diagnosis.explanation in page.text
    assert ("Improved simulation" in page.text) == bool(diagnosis.findings)
    assert page.text.count("▲ here") == (verdict != "adequate")
    # Four before and after, and four of the missing force; what is a force over time has a picture of its own.
    assert page.tags.count("figure") == 8 + (verdict == "partly-explained")
    assert "bench/run_07.csv, 2044 rows, 1544 of them fitted" in page.text
    assert "Made by camid 0.1.0" in page.text
    for unseen in diagnosis.undetectable:
        assert summary.title_of(unseen.identifier) in page.text
    assert "0.0041 u s²/y²" in page.text


@pytest.mark.parametrize("verdict", summary.VERDICT_WORDS)
def test_every_row_of_a_table_has_the_cells_of_its_head(pages, verdict):
    tables = re.findall(r"<table.*?</table>", pages[verdict], re.DOTALL)
    assert tables
    for table in tables:
        head, *rows = (re.findall(r"<t[hd][ >]", row) for row in re.findall(r"<tr>.*?</tr>", table, re.DOTALL))
        assert rows
        assert {len(row) for row in rows} == {len(head)}


def test_a_page_of_doubtful_names_speaks_of_no_structure():
    doubtful = written_diagnoses.diagnosis("partly-explained", structured=False)
    told, structured = (
        Page(report.render(each)).text for each in (doubtful, written_diagnoses.diagnosis("partly-explained"))
    )
    assert "leaves noise. That all of it has its right name is less likely than not" in told
    assert "is structured, not noise" not in told
    assert "is structured, not noise" in structured


def test_a_page_is_known_for_ours_when_it_is_written_anew(tmp_path):
    diagnosis = written_diagnoses.diagnosis("explained")
    first, again = ((write_diagnosis(diagnosis, tmp_path / "found")[3]).read_bytes() for _ in range(2))
    assert first == again


def test_a_finding_is_told_in_full(pages):
    text = Page(pages["partly-explained"]).text
    assert "force 0.1500 ± 0.0021 u 0.1459 to 0.1541" in text
    assert "amplitude (3.210 ± 0.044)·10⁻⁷ u" in text
    assert "frequency 7.5612 ± 0.0019 rad/s (1.203 Hz) 7.5575 to 7.5649" in text
    assert "error without it (RMS, held-out rows) 24.2 %" in text
    assert "Coulomb friction 88 % Hysteresis (Bouc-Wen) 11 % physics outside the catalogue 1.0 %" in text
    assert "What would tell them apart: a free decay" in text
    assert "12 to 31 s" in text
    assert "1.1 to 2.3 Hz" in text
    assert "velocity from −2.5 to 2.5 y/s" in text
    assert "disturbance force from outside 8 % △ also here" in text
    assert "a1 0.84 3.62 ± 0.21 1.203 ± 0.034 −30 % +200 % 11" in text
    assert pages["partly-explained"].count('class="equation"') == 2


def test_an_unlocated_mismatch_is_not_called_none():
    diagnosis = written_diagnoses.diagnosis("unexplained", location=Location())
    text = Page(report.render(diagnosis)).text
    assert "It cannot be located" in text
    assert "Nowhere" not in text


def test_a_wrong_hold_marks_the_hold():
    finding = written_diagnoses.finding()
    hold = type(finding)(
        "input-hold", "actuator", "Hold of the input", "", "", {"hold": ParameterEstimate("foh", None, "")}, {}
    )
    diagnosis = written_diagnoses.diagnosis(
        "explained", findings=[hold], location=Location("actuator", {"actuator": 0.9})
    )
    assert {box.name: box.flag for box in report.chain(diagnosis) if box.flag} == {"hold": "here"}
    assert "first-order hold" in Page(report.render(diagnosis)).text


@pytest.mark.parametrize("verdict", summary.VERDICT_WORDS)
def test_the_page_needs_nothing_else(pages, verdict):
    text, page = pages[verdict], Page(pages[verdict])
    assert not {"link", "img", "iframe", "object", "embed", "image", "base"} & set(page.tags)
    assert page.tags.count("script") == 1
    assert not re.search(r"https?://|//[a-z]", text)
    for name, value in page.attributes:
        assert name != "src"
        assert not name.startswith("on")
        if name.endswith("href"):
            assert value.startswith("#") or value in FILES
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)\)", text))
    # What a drawing refers to is in the page.
    referred = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', text))
    assert {a or b for a, b in referred} <= set(re.findall(r'\bid="([^"]+)"', text))
    assert len(text.encode()) < 1.5e6


def test_names_are_escaped(hostile):
    text = hostile
    page = Page(text)
    assert "img" not in page.tags
    assert page.tags.count("script") == 1
    assert HOSTILE["explanation"] in page.text
    assert "$x_{1}" in page.text  # neither markup nor mathtext
    assert "\x07" not in text


@pytest.mark.parametrize("identifier", known_effects())
def test_the_equations_of_the_catalogue_are_drawn(identifier):
    effect = known_effects()[identifier]
    assert 'd="M' in report.equation(effect.equation)
    assert summary.title_of(identifier) == effect.title


def test_equations():
    assert 'd="M' in report.equation(r"f = f_c\,\mathrm{sgn}(\dot{y})")
    assert report.equation(r"\nosuchcommand{x}") is None
    finding = type(written_diagnoses.finding())(
        **{**vars(written_diagnoses.finding()), "equation": r"\nosuchcommand{x}"}
    )
    assert (
        r"\nosuchcommand{x}" in Page(report.render(written_diagnoses.diagnosis("explained", findings=[finding]))).text
    )


class TestPageDrawnBeside:
    """A process that loads the drawing library during the diagnosis draws what this process would draw."""

    def test_draws_the_same_page(self):
        diagnosis = written_diagnoses.diagnosis("explained")
        with beside.PageDrawnBeside() as drawn:
            drawn.begin(diagnosis)
            assert drawn.text() == report.render(diagnosis)

    def test_a_process_that_ends_without_a_page_is_replaced_by_this_one(self, monkeypatch):
        monkeypatch.setattr(sys, "executable", shutil.which("false"))
        diagnosis = written_diagnoses.diagnosis("explained")
        with beside.PageDrawnBeside() as drawn:
            drawn.begin(diagnosis)
            assert drawn.text() == report.render(diagnosis)

    def test_it_ends_with_a_diagnosis_that_was_refused(self):
        with pytest.raises(ValueError, match="no diagnosis"), beside.PageDrawnBeside() as drawn:
            drawn.text()
        process = drawn._process
        assert process is None or process.poll() is not None
