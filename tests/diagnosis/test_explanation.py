"""The words of a diagnosis: what is named, how surely, with which number; and what comes first."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from camid.diagnosis.diagnosis import Coefficient, Location
from camid.diagnosis.explanation import explanation
from camid.diagnosis.finding import ParameterEstimate
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.report.summary import verdict_words
from camid.diagnosis.verdict import verdict_of
from camid.diagnosis.weights import Comparison, Member
from tests.support import written_diagnoses

FIT = NormalisedErrors(0.684, 0.241, 0.0421, 0.0412, (24.0, 34.0))


@pytest.mark.parametrize(
    ("value", "deviation", "said"),
    [
        (0.15, 0.0021, "(force 0.1500 ± 0.0021 u; 88 %)"),
        (2.4e6, 2.8e16, "(force not determined, 2.4·10⁶ ± 2.8·10¹⁶ u; 88 %)"),
        (-0.1, 0.11, "(force not determined, −0.10 ± 0.11 u; 88 %)"),
        (-0.1, 0.1, "(force −0.10 ± 0.10 u; 88 %)"),
        (0.15, None, "(force about 0.15 u; 88 %)"),
    ],
)
def test_a_number_smaller_than_its_deviation_is_called_not_determined(value, deviation, said):
    found = replace(written_diagnoses.finding(), parameters={"force": ParameterEstimate(value, deviation, "u")})
    assert f"Coulomb friction {said}." in explanation("explained", [found], FIT, Location("plant"))


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        (
            {"coefficient": ParameterEstimate("gain", None, ""), "rate": ParameterEstimate(-0.012, 1e-4, "1/s")},
            "(gain; rate −0.01200 ± 0.00010 1/s; 88 %)",
        ),
        (
            {"rate": ParameterEstimate(150.0, 1e13, "u/s"), "time_constant": ParameterEstimate(0.04, 1e-4, "s")},
            "(time constant 0.04000 ± 0.00010 s; 88 %)",
        ),
        (  # a limit that was never reached
            {"low": ParameterEstimate(-6.3, None, "y"), "high": ParameterEstimate(4.1, 0.01, "y")},
            "(high 4.100 ± 0.010 y; 88 %)",
        ),
        (
            {"force": ParameterEstimate(0.03, 0.23, "u"), "transition": ParameterEstimate(2.0, 0.1, "y/s")},
            "(force not determined, 0.030 ± 0.23 u; transition 2.00 ± 0.10 y/s; 88 %)",
        ),
    ],
)
def test_the_first_number_that_is_determined_leads(parameters, said):
    """What it is of stands before it."""
    found = replace(written_diagnoses.finding(), parameters=parameters)
    assert f"Coulomb friction {said}." in explanation("explained", [found], FIT, Location("plant"))


def weighed(weight, *alternatives):
    """Coulomb friction with a weight."""
    return replace(written_diagnoses.finding(), weight=weight, alternatives=list(alternatives))


def test_a_name_below_a_half_is_one_of_a_class():
    found = weighed(0.4, ("quadratic-drag", 0.35), ("hysteresis", 0.2), ("unlisted", 0.05))
    text = explanation("explained", [found], FIT, Location("plant"))
    assert "leaves out: one of Coulomb friction (40 %), quadratic drag (35 %) or hysteresis (20 %)." in text


def test_two_effects_that_are_one_together_are_told_as_such():
    """Friction of another size in each direction is Coulomb friction and a constant."""
    friction = weighed(0.49, ("asymmetric-friction", 0.48), ("unlisted", 0.03))
    bias = replace(
        weighed(0.44, ("asymmetric-friction", 0.44), ("step-disturbance", 0.08), ("unlisted", 0.04)),
        identifier="input-bias",
        title="Bias of the input",
    )
    text = explanation("explained", [bias, friction], FIT, Location("plant"))
    assert (
        "leaves out: either Coulomb friction and bias of the input (49 %) or asymmetric Coulomb friction (48 %)" in text
    )
    hysteresis = replace(bias, identifier="hysteresis", title="Hysteresis")
    assert "one of hysteresis (44 %)" in explanation("explained", [hysteresis, friction], FIT, Location("plant"))
    other = replace(bias, alternatives=[("asymmetric-friction", 0.3), ("gain-asymmetry", 0.24)])
    assert "one of bias of the input (44 %)" in explanation("explained", [other, friction], FIT, Location("plant"))


@pytest.mark.parametrize(
    ("gap", "said"),
    [
        (3.0, "This recording cannot tell Coulomb friction from hysteresis."),
        (2000.0, "Hysteresis fits worse with the catalogue's law, and is not excluded with another one (8.0 %)."),
    ],
)
def test_a_rival_that_fits_worse_is_not_called_the_same(gap, said):
    members = (Member("coulomb-friction", 0.0, 0.0), Member("hysteresis", gap, 0.01))
    found = replace(weighed(0.91, ("hysteresis", 0.08), ("unlisted", 0.01)), comparison=Comparison(members, 0.9, 0.0))
    assert explanation("explained", [found], FIT, Location("plant")).endswith(said)


def test_where_most_of_the_weight_lies_outside_the_catalogue_that_comes_first():
    text = explanation("partly-explained", [weighed(0.1, ("unlisted", 0.9))], FIT, Location("plant"))
    assert "leaves out: physics outside the catalogue, which acts like Coulomb friction (" in text


@pytest.mark.parametrize(
    ("weights", "said"),
    [([0.1], "explained"), ([0.4], "explained"), ([0.6], "partly-explained"), ([0.3, 0.35], "partly-explained")],
)
def test_a_verdict_speaks_of_all_effects_together(weights, said):
    """Two names that are likely may be unlikely together."""
    found = [weighed(1.0 - weight, ("unlisted", weight)) for weight in weights]
    assert verdict_of(found, False, False) == said
    assert verdict_of(found, False, True) == "partly-explained"


def test_what_holds_in_the_fitted_rows_alone_explains_a_part():
    """Rows that were not fitted judge: a name that leaves them larger than the noise does not explain them."""
    assert verdict_of([weighed(0.99)], False, False, carries_over=False) == "partly-explained"
    assert verdict_of([], False, False, carries_over=False) == "unexplained"
    fit = replace(FIT, refitted=0.5, improved=0.5, noise_floor=0.05)
    text = explanation("unexplained", [], fit, Location())
    assert "in the fitted rows what is left is noise" in text
    assert "in the others the error is 10 times the noise" in text


def test_a_remark_on_the_noise_takes_nothing_from_what_explains_the_motion():
    remark = replace(weighed(0.46, ("unlisted", 0.54)), identifier="coloured-noise", title="Coloured noise")
    assert verdict_of([weighed(0.9, ("unlisted", 0.1)), remark], False, False) == "explained"
    assert verdict_of([remark], False, False) == "partly-explained"


def test_a_law_without_a_name_comes_before_what_is_on_the_noise():
    remark = replace(
        weighed(0.9, ("unlisted", 0.1)), identifier="coloured-noise", title="Coloured noise", parameters={}
    )
    law = SimpleNamespace(name="Learned curve over the input", curve=None)
    text = explanation("partly-explained", [remark], FIT, Location("actuator"), learned=[law])
    assert text.startswith("Something is left out that no effect of the catalogue explains.")
    assert "The mismatch sits at the actuator. The improved simulation holds a learned curve over the input." in text
    assert text.endswith("The simulation leaves out, of the noise alone, too: Coloured noise (90 %).")


def test_coefficients_that_were_wrong_are_not_the_mismatch_of_the_noise():
    """What changes the noise alone explains nothing of the error that they made."""
    remark = replace(
        weighed(0.9, ("unlisted", 0.1)), identifier="coloured-noise", title="Coloured noise", parameters={}
    )
    wrong = Coefficient("a1", 2.0, 4.0, 0.01, 4.0, 0.01)
    fit = replace(FIT, nominal=1.7, nominal_in_place=1.7, refitted=0.042, improved=0.042)
    text = explanation("explained", [remark], fit, Location("noise"), [wrong])
    assert text.startswith("The structure is right and the coefficients were wrong: a1 is 4.000 ± 0.010 and not 2.")
    assert text.endswith("of the noise alone: Coloured noise (90 %). It sits at the noise.")
    found = written_diagnoses.diagnosis("explained", findings=[remark], coefficients=[wrong], fit=fit)
    assert verdict_words(found)[2].startswith(
        "the coefficients were wrong, and what the simulation leaves out is of the"
    )
    found = replace(found, coefficients=[])
    assert verdict_words(found)[2].startswith("of the motion nothing that shows is left out")


def test_structure_without_a_name_is_unexplained_and_a_learned_law_explains_a_part():
    assert [verdict_of([], False, structured) for structured in (False, True)] == ["adequate", "unexplained"]
    assert verdict_of([], True, True) == "partly-explained"


def test_noise_beside_a_doubtful_name_is_not_called_structure():
    found = [weighed(0.45, ("unlisted", 0.55))]
    text = explanation("partly-explained", found, FIT, Location("plant"), structured=False)
    assert "What is left is noise, but it is likelier than not that something here has another name." in text
    text = explanation("partly-explained", found, FIT, Location("plant"), structured=True)
    assert "What is left is still structured" in text


def test_what_weighs_next_to_nothing_describes_nothing():
    text = explanation("partly-explained", [weighed(0.05, ("unlisted", 0.95))], FIT, Location("plant"))
    assert "leaves out: physics outside the catalogue at the plant. On rows" in text


WRONG = [Coefficient("a0", 360.0, 400.1, 0.3, 400.1, 0.3), Coefficient("a1", 12.0, 12.1, 0.2, 12.1, 0.2)]


def test_wrong_coefficients_are_the_first_sentence_with_old_and_new_values():
    fit = NormalisedErrors(2.01, 0.0101, 0.0101, 0.01, (24.0, 34.0))
    text = explanation("adequate", [], fit, Location(), WRONG)
    assert text.startswith(
        "The structure is right and the coefficients were wrong: a0 is 400.10 ± 0.30 and not 360. As given, the "
        "simulation leaves 201 %; re-estimated, it leaves 1.01 % of"
    )


def test_a_zero_of_the_sensor_is_no_wrong_coefficient():
    fit = NormalisedErrors(1.83, 0.0101, 0.0101, 0.01, (24.0, 34.0), nominal_in_place=0.0102)
    assert explanation("adequate", [], fit, Location(), WRONG).startswith("Nothing is left out that this recording")
    fit = NormalisedErrors(1.83, 0.0101, 0.0101, 0.01, (24.0, 34.0), nominal_in_place=0.152)
    text = explanation("adequate", [], fit, Location(), WRONG)
    assert "As given but for the sensor's zero, the simulation leaves 15.2 %" in text


def test_an_error_that_rises_does_not_fall():
    fit = NormalisedErrors(0.684, 0.0017, 0.00228, 0.0015, (24.0, 34.0))
    assert "the error rises from 0.170 %" in explanation("explained", [weighed(0.9)], fit, Location("plant"))


def test_coefficients_that_were_right_are_not_called_wrong():
    fit = NormalisedErrors(0.0102, 0.0101, 0.0101, 0.01, (24.0, 34.0))
    assert explanation("adequate", [], fit, Location(), WRONG).startswith("Nothing is left out that this recording")


def test_a_simulation_that_explains_nothing_says_so_first():
    fit = NormalisedErrors(1.1, 1.03, 1.03, 1.0, (24.0, 34.0))
    text = explanation("adequate", [], fit, Location())
    assert text.startswith("The simulation explains hardly anything of the output: at its best it leaves 103 %")


def test_a_name_without_weight_is_no_member_of_a_class():
    found = weighed(0.45, ("quadratic-drag", 0.4), ("hysteresis", 2e-5), ("unlisted", 0.15))
    text = explanation("explained", [found], FIT, Location("plant"))
    assert "leaves out: one of Coulomb friction (45 %) or quadratic drag (40 %)." in text


@pytest.mark.parametrize(("improved", "said"), [(0.0421, False), (0.1648, True)])
def test_noise_in_the_fitted_rows_is_said_of_them_alone_where_the_others_err_more(improved, said):
    fit = replace(FIT, improved=improved)
    text = explanation("explained", [weighed(0.99)], fit, Location("plant"))
    assert ("in the others the error is 4 times the noise" in text) == said
    meaning = verdict_words(written_diagnoses.diagnosis("explained", fit=fit))[2]
    assert meaning.endswith("in the rows that were fitted") == said


def test_where_nothing_carries_over_but_the_fitted_rows_are_explained_that_is_said():
    fit = replace(FIT, improved=0.998, noise_floor=0.0855, improved_everywhere=0.44)
    text = explanation("partly-explained", [weighed(0.79)], fit, Location("plant"))
    assert "hardly anything" not in text
    assert "in the others the error is 12 times the noise" in text
    fit = replace(fit, improved_everywhere=0.95)
    nothing = explanation("partly-explained", [weighed(0.79)], fit, Location("plant"))
    assert nothing.startswith("The simulation explains hardly anything of the output")
    assert "times the noise" not in nothing
