"""What the terminal and the page say of a diagnosis: verdict, units, errors, laws without a name, and formulas."""

from dataclasses import replace

import numpy as np
import pytest

from camid.diagnosis.diagnosis import Coefficient, Undetectable
from camid.diagnosis.explanation import headline
from camid.diagnosis.finding import ParameterEstimate
from camid.diagnosis.in_declared_units import in_declared_units
from camid.diagnosis.laws.learned_effect_file import effect_file
from camid.diagnosis.learned_part import Formula, LearnedPart, Quantity
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.report import page as report
from camid.diagnosis.report import pictures, summary
from camid.diagnosis.verdict import parameters_of
from camid.number_text import SPACE
from camid.recording.options import Reading
from camid.recording.units import Conversion
from tests.support import written_diagnoses
from tests.support.mass_on_spring import effect
from tests.support.report_page import Page


@pytest.mark.parametrize("verdict", summary.VERDICT_WORDS)
def test_summary(capsys, verdict):
    diagnosis = written_diagnoses.diagnosis(verdict, input_column="[red]u", warnings=["[bold]look"])
    summary.print_summary(diagnosis, [])
    shown = capsys.readouterr().out
    assert summary.VERDICT_WORDS[verdict][1].upper() in shown
    assert diagnosis.explanation in shown
    assert "look" not in shown  # the command says it, once
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


def test_constants_beside_a_law_are_said_where_they_are_beyond_chance(capsys):
    """A dead zone from −0.35 to 0.9 V is one of ±0.625 V only beside a constant at the input."""
    diagnosis = written_diagnoses.diagnosis("partly-explained")
    reading = Reading(input=Conversion(unit="V"), output=Conversion(unit="mm"))
    bent = {"reading": reading, "bias": -0.275, "bias_deviation": 0.002, "offset": 0.004, "offset_deviation": 0.001}
    diagnosis = replace(diagnosis, improved=replace(diagnosis.improved, **bent))
    said = "the sensor's zero, 4.0 ± 1.0 mm; a constant at the input, −0.2750 ± 0.0020 V"
    for text in texts(diagnosis, capsys):
        assert f"stimated beside the coefficients: {said}" in " ".join(text.split())
    by_chance = replace(diagnosis, improved=replace(diagnosis.improved, bias_deviation=0.1, offset_deviation=0.002))
    for text in texts(by_chance, capsys):
        assert "stimated beside the coefficients" not in text


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


def test_coefficients_of_no_plant_have_no_deviation(capsys):
    """Alone the plant may run away from what it is beside its friction."""
    away = Coefficient("b0", 40.0, 2.2e10, 1e8, 45.0, 0.1)
    found = written_diagnoses.diagnosis("explained", coefficients=[away, replace(away, name="b1", refitted=47.0)])
    for text in texts(found, capsys):
        assert "ran away (2.2·10¹⁰)" in text.replace(SPACE, " ")
        assert text.count("ran away") == 1


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
    # Its weight is that of any law of such a kind: the catalogue's explains it not.
    assert summary.weight_text(resembling) == f"{summary.weight_text(written_diagnoses.finding())} that it is such"


@pytest.mark.parametrize(("count", "more"), [(3, ""), (12, "; … (12 numbers)")])
def test_many_numbers_of_a_spectrum_are_not_shown_one_by_one(count, more):
    shown = summary.estimate_text(ParameterEstimate([0.25] * count, [0.01] * count, ""))
    assert shown.replace(SPACE, " ") == "; ".join(["0.250 ± 0.010"] * 3) + more


def test_a_law_is_as_large_as_it_is_where_the_recording_goes(capsys):
    """At the ends of its knots, where hardly a row lies, a curve goes on as it likes."""
    part = replace(LEARNED, knots=[-9.0, -1.0, 0.0, 1.0, 9.0], values=[0.9, 0.1, 0.0, 0.2, 1.0], visited=(-1.0, 2.0))
    part = replace(part, standard_deviations=[0.5, 0.01, 0.01, 0.01, 0.5])
    assert part.largest == pytest.approx(0.3)
    assert part.to_mapping()["visited"] == [-1.0, 2.0]
    diagnosis = written_diagnoses.diagnosis("partly-explained", learned=[part])
    page = texts(diagnosis, capsys)[1]
    values = list(summary._table_of_findings(in_declared_units(diagnosis)).columns[4].cells)
    assert f"5 values, up to 0.3{SPACE}u s/y there" in values
    assert "Up to 0.3 u s/y." in page
    assert "Drawn over the middle 98 % of the rows" in page
    assert "# Up to 0.3 from -1.0 to 2.0, where the middle 98 % of the rows lie." in effect_file(diagnosis)


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


def test_a_remainder_has_the_same_digits_in_the_title_and_in_the_sentence(capsys):
    diagnosis = written_diagnoses.diagnosis("adequate", output_column="way", known_remainder=0.4901)
    assert "declared remainder of 0.49 way (root" in summary.verdict_words(diagnosis)[2]


def test_a_number_at_its_bound_has_no_deviation_and_does_not_lead(capsys):
    """The curvature of a fit that has ended at a bound says nothing of what lies beyond."""
    law = effect("position-dependent-friction", force=1.4e-18, gradient=0.1)
    parameters = parameters_of(law, {"force": 2e-7, "gradient": 0.005})
    assert parameters["force"] == ParameterEstimate(0.0, None, "u", at_bound=True)
    assert not parameters["gradient"].at_bound
    finding = replace(written_diagnoses.finding(), parameters=parameters)
    diagnosis = written_diagnoses.diagnosis("explained", findings=[finding])
    assert summary.estimate_text(parameters["force"]) == f"0{SPACE}u (at its bound)"
    assert headline(finding).startswith("Coulomb friction (gradient")
    assert "0 (at its bound)" in texts(diagnosis, capsys)[1]


def test_printed_shares_add_up():
    """What is less than a per cent has a decimal, and so have all."""
    diagnosis = written_diagnoses.diagnosis("explained")
    places = {"plant": 0.9958, "disturbance": 0.0042, "actuator": 0.0, "sensor": 0.0, "noise": 0.0}
    diagnosis = replace(diagnosis, location=replace(diagnosis.location, place="plant", places=places))
    shares = [box.share_text for box in report.chain(diagnosis) if box.share is not None]
    assert sorted(shares)[-2:] == [f"0.4{SPACE}%", f"99.6{SPACE}%"]


def test_a_region_of_positions_says_what_they_are_counted_from():
    """Where the sensor's zero shifts what is recorded."""
    simulation = written_diagnoses.diagnosis("adequate").improved
    assert summary.state_text(("position", -92.0, 50.0), simulation).endswith(f"50{SPACE}y")
    moved = replace(simulation, offset=320.0)
    assert summary.state_text(("position", -92.0, 50.0), moved).endswith(f"50{SPACE}y (counted from the rest)")
    assert "counted" not in summary.state_text(("input", -92.0, 50.0), moved)


def test_the_weight_of_what_a_law_only_acts_like_is_that_of_the_name():
    finding = replace(written_diagnoses.finding(), weight=0.45, alternatives=[("unlisted", 0.55)])
    assert headline(finding).endswith("; 45 % that it is this)")


def test_the_text_says_what_the_lines_of_a_law_are():
    page = Page(report.render(written_diagnoses.diagnosis("explained"))).text
    assert "Dashed: the law that was found; where the recording can only be shown smoothed" in page
