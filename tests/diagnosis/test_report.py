"""The page of a diagnosis: complete for every verdict, self-contained, safe with any name, laid out by a browser."""

import re
import shutil
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from camid.diagnosis.diagnosis import Location, NormalisedErrors, ParameterEstimate, Undetectable
from camid.diagnosis.in_declared_units import in_declared_units
from camid.diagnosis.learned_part import Formula, LearnedPart, Quantity
from camid.diagnosis.report import beside, panel, pictures, summary
from camid.diagnosis.report import page as report
from camid.diagnosis.results_folder import FILES, write_diagnosis
from camid.effects import known_effects
from camid.number_text import SPACE
from camid.recording.options import Reading
from camid.recording.units import Conversion
from tests.support import written_diagnoses

SECTIONS = ["location", "effects", "structure", "fit", "coefficients", "tests", "undetectable", "about"]
HOSTILE = {
    "input_column": "<script>document.title = 'run'</script>",
    "output_column": '$x_{1} & "y" </text><img src=x onerror=alert(1)>',
    "recordings": ["<script>document.title = 'run'</script>.csv", "b\x07ell\n.csv"],
    "warnings": ["</li><script>document.title = 'run'</script>"],
    "explanation": "<script>document.title = 'run'</script>",
}


class Page(HTMLParser):
    """Elements, attributes, identifiers of sections and text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.sections, self.parts, self.paths = [], [], [], [], 0
        self.feed(text)
        self.close()
        # Style sheet and script are text to the parser, but not to the reader.
        self.text = " ".join(" ".join(self.parts).replace(SPACE, " ").split())

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag == "section":
            self.sections.append(dict(attrs)["id"])

    def handle_data(self, data):
        if self.tags and self.tags[-1] not in {"style", "script"}:
            self.parts.append(data)


@pytest.fixture(scope="module")
def pages():
    return {verdict: report.render(written_diagnoses.diagnosis(verdict)) for verdict in summary.VERDICT_WORDS}


@pytest.fixture(scope="module")
def hostile():
    return report.render(written_diagnoses.diagnosis("partly-explained", **HOSTILE))


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
    assert "disturbance force from outside 8.0 % △ also here" in text
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


@pytest.mark.parametrize(
    ("location", "framed"),
    [
        (Location("plant", state=("velocity", -1.0, 1.0)), ["Missing force against velocity"]),
        (Location("plant"), ["Missing force against velocity", "Missing force against position"]),
        (Location("sensor", state=("position", 0.0, 1.0)), ["Residual against output"]),
        (Location("disturbance"), []),
    ],
)
def test_the_pictures_of_the_located_place_are_framed(location, framed):
    drawn = pictures.draw(written_diagnoses.diagnosis("unexplained", location=location))["structure"]
    assert [p.title for p in drawn if p.located] == framed


def test_a_free_decay_has_no_picture_against_its_input():
    diagnosis = written_diagnoses.diagnosis("explained", input_column=None)
    signals = diagnosis.signals
    still = type(signals)(**{**vars(signals), "signal": np.zeros(len(signals.time))})
    drawn = pictures.draw(written_diagnoses.diagnosis("explained", input_column=None, signals=still))["structure"]
    assert [p.title.split(" against ")[1] for p in drawn] == ["position", "output"]  # velocity is drawn with the law
    assert "no input" in Page(report.render(diagnosis)).text


def test_medians_show_the_law_through_outliers():
    random = np.random.default_rng(np.random.SeedSequence(3))
    x = random.uniform(-1.0, 1.0, 4000)
    y = np.sign(x) + 0.1 * random.standard_normal(4000)
    y[::40] = 50.0
    centres, quartiles = panel.quartiles_of_bins(x, y)
    away = np.abs(centres) > 0.1
    assert away.sum() >= 16
    assert np.abs(quartiles[away, 1] - np.sign(centres[away])).max() < 0.06
    assert np.all(np.diff(quartiles, axis=1) > 0.0)
    levels, _ = panel.quartiles_of_bins(np.tile([-1.0, 0.5], 100), np.ones(200))
    assert levels.tolist() == [-1.0, 0.5]


def test_thinning_keeps_the_extremes():
    time = np.arange(50_000.0)
    values = np.sin(time)
    values[12_345] = 9.0
    thin_time, thin = panel.thinned(time, values)
    assert len(thin) <= panel.LARGEST_LINE
    assert thin.max() == 9.0
    assert thin_time[thin.argmax()] == 12_345.0
    assert np.all(np.diff(thin_time) >= 0.0)


def test_drawing_leaves_the_settings_of_matplotlib_alone():
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 3.0, "text.usetex": True}):
        before = dict(mpl.rcParams)
        pictures.draw(written_diagnoses.diagnosis("explained"))
        assert dict(mpl.rcParams) == before


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


@pytest.mark.parametrize("verdict", summary.VERDICT_WORDS)
def test_summary(capsys, verdict):
    diagnosis = written_diagnoses.diagnosis(verdict, input_column="[red]u", warnings=["[bold]look"])
    summary.print_summary(diagnosis, [])
    shown = capsys.readouterr().out
    assert summary.VERDICT_WORDS[verdict][1].upper() in shown
    assert diagnosis.explanation in shown
    assert "warning: [bold]look" in shown
    assert "2 of which would not have shown" in shown
    if diagnosis.findings:
        assert "cannot be told apart from: Hysteresis (Bouc-Wen) (11" in shown
        assert "[red]u" in shown


def texts(diagnosis, capsys):
    """What the terminal and the page say, without line breaks that mean nothing."""
    summary.print_summary(diagnosis, [])
    printed = " ".join(capsys.readouterr().out.split())
    return printed, Page(report.render(diagnosis)).text


def test_scaled_columns_are_not_the_units_of_their_values(capsys):
    reading = Reading(input=Conversion(unit="V", scale=35.15), output=Conversion(unit="mm"))
    diagnosis = written_diagnoses.diagnosis("partly-explained", input_column="vir", output_column="way")
    diagnosis = replace(diagnosis, improved=replace(diagnosis.improved, reading=reading))
    printed, page = texts(diagnosis, capsys)
    assert f"0.1500 ± 0.0021{SPACE}u" in diagnosis_table(diagnosis)
    assert "velocity from −2500 to 2500 mm/s" in page
    assert "4.1·10⁻⁹ u s²/mm²" in page
    for text in (printed, page):
        assert "u = 35.15 · vir" in text
    shown = in_declared_units(diagnosis)
    drawn = "".join(p.svg for panels in pictures.draw(shown).values() for p in panels)
    assert "vir" not in drawn
    assert "way, mm" in drawn
    np.testing.assert_allclose(shown.signals.recorded, 1e3 * diagnosis.signals.recorded)
    np.testing.assert_array_equal(shown.signals.equivalent_input, diagnosis.signals.equivalent_input)


def test_a_declared_unit_is_written_and_the_name_of_a_column_where_none_is(capsys):
    diagnosis = written_diagnoses.diagnosis("partly-explained", input_column="vir", output_column="way")
    diagnosis = replace(diagnosis, improved=replace(diagnosis.improved, reading=Reading(input=Conversion(unit="V"))))
    printed, page = texts(diagnosis, capsys)
    assert f"0.1500 ± 0.0021{SPACE}V" in diagnosis_table(diagnosis)
    assert "0.0041 V s²/way²" in page
    assert "vir in V. Units are written with the names of columns: way stands for the unit of column way." in page
    assert "in units" not in printed


def diagnosis_table(diagnosis):
    """Values of all parameters as the terminal shows them."""
    return [summary.estimate_text(p) for f in in_declared_units(diagnosis).findings for p in f.parameters.values()]


def test_an_adequate_simulation_with_a_remainder_says_so_in_its_title(capsys):
    diagnosis = written_diagnoses.diagnosis("adequate", output_column="way", known_remainder=0.0123)
    for text in texts(diagnosis, capsys):
        assert "nothing beyond the declared remainder of 0.0123 way" in text
        assert "leaves nothing out" not in text
        assert "depends on nothing" not in text
        assert "owhere" not in text


def test_errors_are_root_mean_squares_alone(capsys):
    """Shares of squares, which do not add up beside root mean squares, stay in diagnosis.json."""
    pair = [written_diagnoses.finding(), written_diagnoses.second_finding()]
    squares = [replace(f, evidence=f.evidence | {"share": 0.0953, "share_together": 0.78}) for f in pair]
    for text in texts(written_diagnoses.diagnosis("explained", findings=squares), capsys):
        assert "24.2 %" in text.replace(SPACE, " ")
        assert "10.2 %" in text.replace(SPACE, " ")
        assert "9.53" not in text
        assert "78.0" not in text


def test_a_name_without_half_of_the_weight_is_no_headline(capsys):
    faint = replace(written_diagnoses.finding(), weight=0.1, alternatives=[("unlisted", 0.9)])
    for text in texts(written_diagnoses.diagnosis("partly-explained", findings=[faint]), capsys):
        assert "something is named" not in text
        assert "has no name that is likely" in text


def test_wrong_coefficients_are_not_plainly_adequate(capsys):
    fit = NormalisedErrors(2.01, 0.0612, 0.0612, 0.0604, (24.0, 34.0))
    for text in texts(written_diagnoses.diagnosis("adequate", fit=fit), capsys):
        assert "oefficients were wrong" in text.lower() or "COEFFICIENTS WERE WRONG" in text
    page = report.render(written_diagnoses.diagnosis("adequate", fit=fit))
    assert '<body class="corrected">' in page


def test_an_effect_without_a_number_that_would_have_shown_is_not_called_invisible(capsys):
    seen = Undetectable("absolute-value", "68 times as visible as needed", shows=True)
    diagnosis = written_diagnoses.diagnosis("adequate", undetectable=[seen])
    assert summary.sorted_undetectable(diagnosis.undetectable) == ([seen], [])
    assert "would not have shown" not in Page(report.render(diagnosis)).text


LEARNED = LearnedPart(
    "learned-force",
    "plant",
    "Learned force",
    "damping over position",
    [-1.5, 0.0, 1.5],
    [0.31, 0.0, 0.33],
    [0.02, 0.0, 0.03],
    "y",
    "u s/y",
    123.0,
    0.04,
)


def test_a_name_that_is_not_simulated_is_marked():
    resembling = replace(written_diagnoses.finding(), simulated=False)
    assert f"  {summary.NOT_SIMULATED}" in summary.finding_lines(resembling, {})
    assert f"  {summary.NOT_SIMULATED}" not in summary.finding_lines(written_diagnoses.finding(), {})
    assert resembling.to_mapping()["simulated"] is False


def test_a_law_without_a_name_is_shown_and_not_claimed(capsys):
    diagnosis = replace(written_diagnoses.diagnosis("partly-explained"), learned=[LEARNED])
    for text in texts(diagnosis, capsys):
        assert "Learned" in text
    entry = diagnosis.to_mapping()["effects"][-1]
    assert (entry["id"], entry["weight"], entry["alternatives"]) == (
        "learned-force",
        0.0,
        [{"id": "unlisted", "weight": 1.0}],
    )
    assert (entry["knots"], entry["values"], entry["standard_deviations"]) == (
        LEARNED.knots,
        LEARNED.values,
        LEARNED.standard_deviations,
    )
    assert "Learned damping over the position" in report.render(diagnosis)


FORMULA = Formula(
    "square",
    "f = d(y)·v, d(y) = a·y²",
    {"a": Quantity(0.14, 0.01, "u s/y^3")},
    ["cogging"],
    {"constant": 0.1},
    [-1.5, 0.0, 1.5],
    [0.315, 0.0, 0.315],
    [0.0, 0.0, 0.0],
)


def test_a_formula_is_shown_with_its_numbers(capsys):
    law = replace(LEARNED, formula=FORMULA, description="even")
    diagnosis = replace(written_diagnoses.diagnosis("partly-explained"), learned=[law])
    text = "f = d(y)·v, d(y) = a·y², a = 0.140 ± 0.010 u s/y³"
    summary.print_summary(diagnosis, [])
    printed = capsys.readouterr().out
    assert f"formula: {text}" in printed
    assert "in words: even" in printed
    page = report.render(diagnosis)
    assert f"Formula: <code>{text}</code>" in page
    assert "In words: even." in page
    entry = diagnosis.to_mapping()["effects"][-1]
    assert (entry["formula"], entry["formula_replaces"], entry["formula_rivals"]) == (
        "f = d(y)·v, d(y) = a·y², a = 0.140 ± 0.010 u s/y^3",
        ["cogging"],
        [],
    )


def test_formulas_that_cannot_be_told_apart_are_all_shown(capsys):
    other = replace(FORMULA, form="absolute value", expression="f = d(y)·v, d(y) = a·|y|")
    diagnosis = written_diagnoses.diagnosis("partly-explained")
    diagnosis = replace(diagnosis, learned=[replace(LEARNED, rivals=[FORMULA, other])])
    summary.print_summary(diagnosis, [])
    printed, page = capsys.readouterr().out, report.render(diagnosis)
    entry = diagnosis.to_mapping()["effects"][-1]
    assert entry["formula"] is None
    assert entry["formula_rivals"] == [FORMULA.text, other.text]
    for formula in (FORMULA, other):
        text = formula.text.replace("y^3", "y³")
        assert f"formula, one of 2: {text}" in printed
        assert f"One of the formulas that cannot be told apart: <code>{text}</code>" in page


@pytest.mark.parametrize(("structured", "left"), [(True, "something remains"), (False, "what is left is noise")])
def test_what_a_learned_law_leaves_is_said(structured, left):
    diagnosis = replace(written_diagnoses.diagnosis("partly-explained"), learned=[LEARNED], structured=structured)
    assert left in summary.verdict_words(diagnosis)[2]


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
