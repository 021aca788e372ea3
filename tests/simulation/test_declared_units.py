"""Units that a simulation declares: how they are written, and by what values are divided."""

import numpy as np
import pytest

from camid.recording.units import Conversion, si_name
from camid.simulation.declared_units import IN_U_AND_Y, DeclaredUnits, SignalUnit

NEWTON_AND_MILLIMETRE = DeclaredUnits(
    SignalUnit.of("u", "force", Conversion("N")), SignalUnit.of("y", "way", Conversion("mm"))
)


@pytest.mark.parametrize(
    ("unit", "text", "factor"),
    [
        ("u", "N", 1.0),
        ("y", "mm", 1e-3),
        ("y/s", "mm/s", 1e-3),
        ("u s^2/y^2", "N s²/mm²", 1e6),
        ("u s/y^3", "N s/mm³", 1e9),
        ("1/y", "1/mm", 1e3),
        ("u/y^0.5", "N/mm^0.5", 1e1**1.5),
        ("y/(u s^2)", "mm/(N s²)", 1e-3),
        ("u/(y s)", "N/(mm s)", 1e3),
        ("u*s**2/y**2", "N·s²/mm²", 1e6),
        ("rad/s", "rad/s", 1.0),
        ("", "", 1.0),
        (None, "", 1.0),
    ],
)
def test_units_of_parameters(unit, text, factor):
    assert NEWTON_AND_MILLIMETRE.text(unit) == text
    assert NEWTON_AND_MILLIMETRE.factor(unit) == pytest.approx(factor)
    assert NEWTON_AND_MILLIMETRE.shown(factor, unit) == pytest.approx(1.0)


def test_values_of_all_kinds():
    units = NEWTON_AND_MILLIMETRE
    assert units.shown([0.001, 0.002], "y") == [1.0, 2.0]
    np.testing.assert_allclose(units.shown(np.array([0.001]), "y"), [1.0])
    assert units.shown(None, "y") is None
    assert units.shown("zoh", "y") == "zoh"
    assert IN_U_AND_Y.shown(0.3, "y/u") == 0.3
    assert IN_U_AND_Y.text("y/u") == "y/u"


@pytest.mark.parametrize(
    ("conversion", "symbol", "factor", "explained"),
    [
        (Conversion("mm"), "mm", 1e-3, None),
        (Conversion("mm", scale=-1.0), "mm", 1e-3, None),
        (Conversion("m/s^2"), "m/s²", 1.0, None),
        (Conversion("V", scale=35.15), "u", 1.0, "u = 35.15 · vir"),
        (Conversion(scale=-1.0), "u", 1.0, "u = −1 · vir"),
        (Conversion(), "vir", 1.0, None),
        (Conversion("dimensionless"), "vir", 1.0, None),
        (Conversion("degC"), "K", 1.0, None),
        (Conversion("px"), "px", 1.0, None),
    ],
)
def test_what_a_column_is_shown_in(conversion, symbol, factor, explained):
    signal = SignalUnit.of("u", "vir", conversion)
    assert (signal.symbol, signal.explained) == (symbol, explained)
    assert signal.factor == pytest.approx(factor)


def test_symbols_of_several_parts_stand_in_brackets():
    units = DeclaredUnits(SignalUnit("u", "x pos"), SignalUnit.of("y", "a", Conversion("m/s^2")))
    assert units.text("y/s") == "(m/s²)/s"
    assert units.text("y") == "m/s²"
    assert units.text("u") == "[x pos]"


@pytest.mark.parametrize(
    ("unit", "name"), [("mm", "m"), ("deg", "rad"), ("mV", "V"), ("kN", "N"), ("V", "V"), ("px", "px"), ("degC", "K")]
)
def test_si_names(unit, name):
    assert si_name(unit) == name
