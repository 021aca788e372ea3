"""Numbers as people read them: value ± standard deviation, significant digits, percentages, probabilities and units.

The digits of an estimate follow its standard deviation, which has two significant digits. Where that asks for a power
of ten, value and deviation share it: (1.235 ± 0.078)·10⁴. A value smaller than its deviation keeps two digits of its
own, (0.057 ± 2.4)·10⁵: rounded to those of the deviation it would be another number.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

NORMAL_95 = 1.959964  # half the width of a 95 % interval in standard deviations
SCIENTIFIC_ABOVE, SCIENTIFIC_BELOW = 5, -4
SMALLEST_PROBABILITY = 1e-4
# A deviation below this share of the value is rounding error; the digits that it asks for would be noise.
SMALLEST_RELATIVE_DEVIATION = 1e-12
# A limit below this share of the distance to the other one is an error of rounding.
ROUNDING_ERROR = 1e-6
SMALLEST_WHOLE_SHARE = 0.01
LIMITS = 1e-290, 1e290
SPACE = "\u00a0"  # between a number and its unit: no line breaks there
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _fixed(value: float, decimals: int) -> str:
    return f"{round(value, decimals):.{max(decimals, 0)}f}".replace("-", "−")


def _exponent(value: float) -> int:
    return int(f"{value:e}".partition("e")[2]) if value else 0


def number(value: float, digits: int = 3) -> str:
    """A number with this many significant digits; powers of ten where it is very small or large."""
    if not math.isfinite(value):
        return "not determined" if math.isnan(value) else ("∞" if value > 0 else "−∞")
    value += 0.0  # minus zero is zero
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if SCIENTIFIC_BELOW <= exponent <= SCIENTIFIC_ABOVE:
        return _fixed(float(f"{mantissa}e{power}"), digits - 1 - exponent)
    return f"{mantissa}·10{str(exponent).translate(SUPERSCRIPTS)}".replace("-", "−")


def plain(value: float, digits: int = 4, unit: str = "") -> str:
    """A number that somebody declared, and its unit: without the zeros at its end."""
    text = number(value, digits)
    head, power, tail = text.partition("·")
    head = head.rstrip("0").rstrip(".") if "." in head else head
    return head + power + tail + (SPACE + unit if unit else "")


def apart_from(value: float, other: float | None, digits: int = 2, most: int = 9) -> str:
    """A number with this many significant digits, or as many more as its distance from another one asks for."""
    if other is None or not math.isfinite(other) or value == other:
        return number(value, digits)
    needed = _exponent(value) - _exponent(value - other) + digits
    return number(value, min(max(digits, needed), most))


def with_deviation(value: Any, deviation: Any, unit: str = "") -> str:
    """``value ± standard deviation unit``; items of lists are separated by semicolons.

    Parameters
    ----------
    value : float or sequence of float
    deviation : float, sequence of float or None
        0: the value is fixed and not estimated. None, NaN or infinite: the data do not determine it.
    unit : str
    """
    after = SPACE + unit if unit else ""
    if isinstance(value, list | tuple):
        spreads = deviation if isinstance(deviation, list | tuple) else [deviation] * len(value)
        return "; ".join(with_deviation(v, d) for v, d in zip(value, spreads, strict=True)) + after
    if not math.isfinite(value):
        return number(value)
    if deviation is None or not math.isfinite(deviation) or deviation < 0.0:
        return f"{plain(value, 4)}{after} (undetermined)"
    if deviation == 0.0:
        return f"{plain(value, 6)}{after} (fixed)"
    return _estimate(value, deviation) + after


def _estimate(value: float, deviation: float) -> str:
    """Value and deviation, both finite and the second positive, with two significant digits of the smaller one."""
    from uncertainties import ufloat  # type: ignore[import-untyped]

    if deviation < SMALLEST_RELATIVE_DEVIATION * abs(value):
        return f"{plain(value, 12)} ± {number(deviation, 2)}"
    if not LIMITS[0] < deviation < LIMITS[1]:  # where powers of ten overflow
        return f"{number(value, 4)} ± {number(deviation, 2)}"
    # .2u: two significant digits of the deviation; P: superscripts and × instead of e.
    text = f"{ufloat(value, deviation):.2uP}"
    text = re.sub(r"-(?=0(?:\.0*)?±)", "", text)  # minus zero
    text = text.replace("±", " ± ").replace("×", "·").replace("-", "−")
    return text if not 0.0 < abs(value) < deviation else _with_its_own_digits(value, deviation, text)


def _with_its_own_digits(value: float, deviation: float, text: str) -> str:
    """The text of an estimate, with two significant digits of a value that is smaller than its deviation."""
    power = _exponent(deviation) if text.startswith("(") else 0
    # What is printed of the deviation may have been rounded up to the next power of ten.
    power += text.startswith("(") and text.endswith(f"·10{str(power + 1).translate(SUPERSCRIPTS)}")
    own = number(value / 10.0**power, 2)
    if "·" not in own:
        return re.sub(r"[−\d.]+(?= ±)", own, text, count=1)
    spread = text.partition(" ± ")[2].replace(")", "")
    return f"{number(value, 2)} ± {spread}"


def interval(value: float, deviation: float | None) -> str:
    """95 % interval of a normal estimate; a dash where the deviation is not known."""
    if deviation is None or not math.isfinite(deviation) or deviation <= 0.0:
        return "–"
    digits = min(9, max(3, _exponent(max(abs(value), deviation)) - _exponent(deviation) + 2))
    return " to ".join(number(value + sign * NORMAL_95 * deviation, digits) for sign in (-1, 1))


def span(limits: tuple[float, float], unit: str) -> str:
    """Two limits and their unit: with digits that tell them apart, and rounding errors of zero as zero."""
    width = abs(limits[1] - limits[0])
    if width == 0.0:
        return f"about {plain(limits[0], 4, unit)}"
    low, high = (0.0 if abs(limit) < ROUNDING_ERROR * width else limit for limit in limits)
    apart = _exponent(max(abs(low), abs(high))) - _exponent(width) + 3 if 0.0 < width < math.inf else 4
    digits = min(max(4, apart), 9)
    return f"{plain(low, digits)} to {plain(high, digits, unit)}"


def percentage(share: float | None, digits: int = 3) -> str:
    """A share of one in per cent."""
    return "–" if share is None or math.isnan(share) else f"{number(100.0 * share, digits)}{SPACE}%"


def percentages(shares: Sequence[float]) -> list[str]:
    """Shares of one in per cent, which add up to a hundred as they are printed.

    Whole ones, or with a decimal where one is smaller; what rounding down leaves goes to the largest remainders
    (Hamilton's method).
    """
    total = sum(shares)
    if not total > 0.0:
        return [percentage(0.0, 1) for _ in shares]
    steps = 1000 if any(0.0 < share < SMALLEST_WHOLE_SHARE * total for share in shares) else 100
    exact = [share / total * steps for share in shares]
    whole = [math.floor(each) for each in exact]
    order = sorted(range(len(exact)), key=lambda i: whole[i] - exact[i])
    for i in order[: steps - sum(whole)]:
        whole[i] += 1
    return [f"{100.0 * each / steps:.{0 if steps == 100 else 1}f}{SPACE}%" for each in whole]


def probability(value: float | None) -> str:
    """A p-value."""
    if value is None or math.isnan(value):
        return "–"
    return f"< {number(SMALLEST_PROBABILITY, 1)}" if value < SMALLEST_PROBABILITY else number(value, 2)


def equals_probability(value: float) -> str:
    """A p-value after its sign of equality, ``= 0.054`` or ``< 0.0001``."""
    text = probability(value)
    return text if text.startswith("<") else f"= {text}"


def printable(name: str) -> str:
    """A text that may quote a file as one line: line breaks and control characters are ?, hard spaces are blanks."""
    return "".join(c if c.isprintable() else " " if c in (SPACE, "\u202f", "\u2009") else "?" for c in name)


def typeset(unit: str) -> str:
    """A unit as people write it: ``m*s^-2`` becomes ``m·s⁻²``."""
    marked = unit.replace("**", "^").replace("*", "·")
    return re.sub(r"\^(-?\d+)(?![\d.])", lambda power: power.group(1).translate(SUPERSCRIPTS), marked)


def unit_text(unit: str | None, input_symbol: str, output_symbol: str) -> str:
    """A unit in u, y and s with symbols in place of u and y; empty for a pure number."""
    if not unit or unit in {"1", "-"}:
        return ""
    symbols = {"u": input_symbol, "y": output_symbol}
    return typeset(re.sub(r"(?<![\w%])[uy](?![\w%])", lambda match: symbols[match.group()], unit))
