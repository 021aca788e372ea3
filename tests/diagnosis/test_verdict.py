"""The words of a verdict: what is named, and how sure its number is."""

from dataclasses import replace

import pytest

from camid.diagnosis.diagnosis import Location, NormalisedErrors, ParameterEstimate
from camid.diagnosis.verdict import explanation
from tests.support import written_diagnoses

FIT = NormalisedErrors(0.684, 0.241, 0.0421, 0.0412, (24.0, 34.0))


@pytest.mark.parametrize(
    ("value", "deviation", "said"),
    [
        (0.15, 0.0021, "(force 0.1500 ± 0.0021 u)"),
        (2.4e6, 2.8e16, "(force not determined, 2.4·10⁶ ± 2.8·10¹⁶ u)"),
        (-0.1, 0.11, "(force not determined, −0.10 ± 0.11 u)"),
        (-0.1, 0.1, "(force −0.10 ± 0.10 u)"),
        (0.15, None, "(force about 0.15 u)"),
    ],
)
def test_a_number_smaller_than_its_deviation_is_called_not_determined(value, deviation, said):
    found = replace(written_diagnoses.finding(), parameters={"force": ParameterEstimate(value, deviation, "u")})
    assert f"Coulomb friction {said}." in explanation("explained", [found], FIT, Location("plant"))
