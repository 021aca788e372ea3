"""Numbers as people read them: their digits follow the deviation, and they say what was computed."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from camid.number_text import (
    SPACE,
    apart_from,
    interval,
    number,
    percentage,
    percentages,
    plain,
    printable,
    probability,
    span,
    typeset,
    unit_text,
    with_deviation,
)


@pytest.mark.parametrize(
    ("value", "other", "text"),
    [
        (0.99934, 1.0, "0.99934"),
        (0.0100587, 0.01, "0.010059"),
        (2.9988, 3.0, "2.9988"),
        (0.00067, 0.0, "0.00067"),
        (67890.0, None, "68000"),
        (3.0, 3.0, "3.0"),
    ],
)
def test_a_number_has_digits_that_tell_it_from_another(value, other, text):
    assert apart_from(value, other) == text


@pytest.mark.parametrize(
    ("value", "deviation", "text"),
    [
        (0.15, 0.0021, "0.1500 ± 0.0021"),
        (12345.6, 78.0, "12346 ± 78"),
        (12345.6, 780.0, "(1.235 ± 0.078)·10⁴"),
        (5708.0, 240000.0, "(0.057 ± 2.4)·10⁵"),
        (5708.0, 2.4e16, "5700 ± 2.4·10¹⁶"),
        (-5708.0, 99999.0, "(−0.057 ± 1.0)·10⁵"),
        (9e4, 99999.0, "(0.90 ± 1.0)·10⁵"),
        (3.2e-9, 4.1e-7, "(0.032 ± 4.1)·10⁻⁷"),
        (5708.0, 24.0, "5708 ± 24"),
        (-1.5e-7, 2e-9, "(−1.500 ± 0.020)·10⁻⁷"),
        (0.01, 0.3, "0.010 ± 0.30"),
        (-0.001, 3.0, "−0.0010 ± 3.0"),
        (0.0, 0.0996, "0.00 ± 0.10"),
        (2.5e8, 1e6, "(2.500 ± 0.010)·10⁸"),
        (5.0, 1e-300, "5 ± 1.0·10⁻³⁰⁰"),
        (1e308, 1.5e308, "1.000·10³⁰⁸ ± 1.5·10³⁰⁸"),
        (100.0, 0.0, "100 (fixed)"),
        (3.0, None, "3 (undetermined)"),
        (3.0, float("inf"), "3 (undetermined)"),
        (float("nan"), 1.0, "not determined"),
        ([1.0, 2.0], [0.1, 0.2], "1.00 ± 0.10; 2.00 ± 0.20"),
        ([1.0, 2.0], None, "1 (undetermined); 2 (undetermined)"),
    ],
)
def test_values_have_the_digits_of_their_deviations(value, deviation, text):
    assert with_deviation(value, deviation) == text


def test_the_unit_follows_the_number():
    assert with_deviation(0.15, 0.0021, "N") == f"0.1500 ± 0.0021{SPACE}N"
    assert with_deviation(0.15, 0.0, "N") == f"0.15{SPACE}N (fixed)"


def parsed(text):
    """Value and deviation of what is printed."""
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
    bracketed = re.fullmatch(r"\((\S+) ± (\S+)\)·10(\S+)", text)
    if bracketed:
        value, deviation, power = (part.translate(digits) for part in bracketed.groups())
        return float(f"{value}e{power}"), float(f"{deviation}e{power}")
    return tuple(float(part.translate(digits).replace("·10", "e")) for part in text.split(" ± "))


magnitudes = st.builds(lambda mantissa, power: mantissa * 10.0**power, st.floats(1.0, 10.0), st.integers(-30, 30))


@given(magnitudes, st.sampled_from([-1.0, 1.0]), st.floats(-11.0, 8.0))
def test_rounding_moves_no_value_by_more_than_a_twentieth_of_its_deviation(size, sign, relative):
    value, deviation = sign * size, size * 10.0**relative
    shown, spread = parsed(with_deviation(value, deviation))
    # What is lost beside half a unit of the second digit is the rounding of the deviation itself, 0.995 to 1.0.
    assert abs(shown - value) <= 0.05 * max(deviation, spread) * (1.0 + 1e-9) + 1e-15 * abs(value)
    assert spread == pytest.approx(deviation, rel=0.0501)


@given(magnitudes, st.floats(-11.0, 8.0))
def test_a_deviation_has_two_significant_digits(size, relative):
    shown = re.split(r"[)·]", with_deviation(size, size * 10.0**relative).partition(" ± ")[2])[0]
    assert len(shown.replace(".", "").lstrip("0")) == 2


@given(magnitudes, st.sampled_from([-1.0, 1.0]), st.floats(0.0, 8.0))
def test_a_value_smaller_than_its_deviation_keeps_two_digits(size, sign, relative):
    shown, _ = parsed(with_deviation(sign * size, size * 10.0**relative))
    assert shown == pytest.approx(sign * size, rel=0.0501)


@given(magnitudes, st.sampled_from([-1.0, 1.0]), st.integers(1, 12))
def test_numbers_keep_their_significant_digits(size, sign, digits):
    text = number(sign * size, digits)
    digit = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
    read = float(text.translate(digit).replace("·10", "e"))
    assert read == pytest.approx(sign * size, rel=0.5001 * 10.0 ** (1 - digits))
    assert float(plain(sign * size, digits).translate(digit).replace("·10", "e")) == read


@given(st.floats())
def test_every_number_has_a_text(value):
    for text in (number(value), plain(value), percentage(value), probability(value), with_deviation(value, value)):
        assert text
        assert "nan" not in text
        assert "e" not in text.replace("not determined", "").replace("undetermined", "").replace("fixed", "")
    assert interval(value, abs(value)) or math.isnan(value)


def test_numbers_and_units():
    assert number(0.00012345) == "0.000123"
    assert number(9.996) == "10.0"
    assert number(1234567.0) == "1.23·10⁶"
    assert number(0.0) == "0.00"
    assert plain(20.0, unit="ms") == f"20{SPACE}ms"
    assert plain(1e-7) == "1·10⁻⁷"
    assert plain(100.0) == "100"
    assert unit_text("u s^2/y^2", "force", "[x pos]") == "force s²/[x pos]²"
    assert unit_text("rad/s", "N", "mm") == "rad/s"
    assert unit_text("u/y^0.5", "N", "mm") == "N/mm^0.5"
    assert typeset("m*s**-2") == "m·s⁻²"
    assert probability(3e-9) == "< 0.0001"
    assert interval(0.15, 0.0021) == "0.1459 to 0.1541"
    assert span((0.5, 2.0), "Hz") == f"0.5 to 2{SPACE}Hz"
    assert span((2.961e-10, 10.98), "s") == f"0 to 10.98{SPACE}s"
    assert span((1000.012, 1000.034), "s") == f"1000.012 to 1000.034{SPACE}s"
    assert span((3.0, 3.0), "") == "about 3"
    assert percentage(None) == "–"


@pytest.mark.parametrize(
    ("shares", "printed"),
    [
        ([0.9958, 0.0042], ["99.6", "0.4"]),
        ([0.3975, 0.2467, 0.1950, 0.1608, 0.0], ["40", "25", "19", "16", "0"]),
        ([1 / 3, 1 / 3, 1 / 3], ["34", "33", "33"]),
        ([0.0, 0.0], ["0", "0"]),
    ],
)
def test_shares_add_up_as_they_are_printed(shares, printed):
    assert percentages(shares) == [f"{each}{SPACE}%" for each in printed]


def test_minus_zero_is_zero():
    assert (number(-0.0), plain(-0.0, unit="V"), with_deviation(-0.0, 0.0)) == ("0.00", "0\u00a0V", "0 (fixed)")


def test_a_message_has_blanks_for_hard_spaces():
    assert printable(f"between {plain(0.16, unit='s')} and\n{plain(30.0, unit='s')}") == "between 0.16 s and?30 s"
