"""What docs/diagnosis.md says of constants and files is what the code does."""

import importlib
import re

import pytest

from camid.diagnosis.report.summary import VERDICT_WORDS
from camid.diagnosis.results_folder import FILES
from tests.support import ROOT

PAGE = (ROOT / "docs" / "diagnosis.md").read_text(encoding="utf-8")
CONSTANT = re.compile(r"`([A-Z_]+)` ([0-9.]+·10⁻[⁰¹²³⁴-⁹]+|10⁻[⁰¹²³⁴-⁹]+|[0-9.]+)")
DIGITS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")


def number(text):
    """A number as the page writes it, 2·10⁻⁴ for instance."""
    factor, power_of_ten, power = text.rpartition("10⁻")
    if not power_of_ten:
        return float(text)
    return float(factor.rstrip("·") or 1.0) * 10.0 ** -int(power.translate(DIGITS))


ROWS = [
    (name, number(value), module)
    for line in PAGE.splitlines()
    if (module := next(iter(re.findall(r"`((?:diagnosis|fitting)/\w+)\.py`", line)), None))
    for name, value in CONSTANT.findall(line)
]


def test_the_page_lists_constants():
    assert len(ROWS) >= 12


@pytest.mark.parametrize(("name", "value", "module"), ROWS)
def test_constants_are_those_of_the_code(name, value, module):
    assert getattr(importlib.import_module(f"camid.{module.replace('/', '.')}"), name) == pytest.approx(value, rel=1e-9)


def test_files_and_verdicts_are_all_explained():
    for name in (*FILES, *VERDICT_WORDS):
        assert f"`{name}`" in PAGE
