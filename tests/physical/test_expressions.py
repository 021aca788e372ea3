"""Expressions of a user's file: what is read, and what is refused in one line."""

import numpy as np
import pytest

from camid.physical.expressions import Compiled, parsed, refuse_name, symbols

NAMES = ("mass", "x")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("mass*x^2", 12.0),
        ("sqrt(max(x - 3, 0)) + abs(-mass)", 3.0),
        ("sign(x)*min(mass, x)", 2.0),
        ("atan2(x, 2)*4/pi", 1.0),
        ("1/3*mass", 1.0),
        ("x - 1.0000000000000000000 + mass*0.3333333333333333333", 2.0),
        (2.5, 2.5),
    ],
)
def test_values(text, value):
    function = Compiled(symbols(NAMES), [parsed(text, NAMES)])
    assert function(np.array([3.0, 2.0]))[0] == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mas", "unknown name 'mas': did you mean 'mass'"),
        ("sine(x)", "unknown function 'sine': did you mean 'sin'"),
        ("__import__('os').system('ls')", "is not an expression"),
        ("x.real", "is not an expression"),
        ("x +", "is not an expression"),
        ("1/0", "is not a real expression"),
        ("sqrt(-1)", "is not a real expression"),
        ("x < 1", "is not a real expression"),
        ("1e400", "is not a real expression"),
        ("(" * 100 + "x" + ")" * 100, "too long"),
        ("x" * 3000, "too long"),
    ],
)
def test_refusals(text, said):
    with pytest.raises(ValueError, match=r"expression|unknown|too long") as refused:
        parsed(text, NAMES)
    assert said in str(refused.value)


@pytest.mark.parametrize("name", ["E", "I", "pi", "sqrt", "2a", "a b", "", "nan"])
def test_names_that_mean_something_else(name):
    with pytest.raises(ValueError, match="name"):
        refuse_name(name)


def test_constants_that_are_called_like_the_common_parts_of_expressions():
    """SymEngine's elimination of common subexpressions calls them x0, x1, … whatever else is called so."""
    names = ["x0", "x1", "a"]
    texts = ["x0 + x1*sin(a) + sin(a)/(1 + sin(a))", "x1*sin(a)^2", "x0*cos(a) + sin(a)"]
    found = Compiled(symbols(names), [parsed(text, names) for text in texts])(np.array([318.0, 0.5, 0.3]))
    s, c = np.sin(0.3), np.cos(0.3)
    np.testing.assert_allclose(found, [318.0 + 0.5 * s + s / (1.0 + s), 0.5 * s**2, 318.0 * c + s], rtol=1e-14)


def test_names_in_any_letters():
    refuse_name("größe_1")
    assert Compiled(symbols(["größe_1"]), [parsed("2*größe_1", ["größe_1"])])(np.array([3.0]))[0] == 6.0
