"""``camid effects``: the catalogue in the terminal."""

import re

import pytest

from camid.cli import main
from camid.effects import known_effects
from camid.effects.law_text import law_text


def test_the_list_names_every_effect(capsys):
    assert main(["effects"]) == 0
    listed = re.findall(r"^  (\S+)  +\S", capsys.readouterr().out, flags=re.MULTILINE)
    assert sorted(listed) == sorted(known_effects())


def test_law_sign_parameters_and_units_of_every_effect(capsys):
    assert main(["effects", *known_effects()]) == 0
    said = capsys.readouterr().out
    assert "\\" not in said  # no LaTeX
    for kind in known_effects().values():
        for parameter in kind.parameters:
            assert f"    {parameter.name} [" in said
    assert main(["effects", "end-stop"]) == 0
    said = capsys.readouterr().out
    assert "against the motion: what drives the plant is u - f" in said
    assert "law:    f = k_s max(y - y_s, 0)  (y_s > 0)," in said
    assert "stiffness [u/y]: stiffness k_s of the contact, from 0" in said
    assert "file:   - {id: end-stop, parameters: {position: …, stiffness: …}}" in said
    assert "with loss: " in said


@pytest.mark.parametrize("identifier", known_effects())
def test_what_stands_in_a_file_for_a_law_is_that_law(identifier, capsys):
    assert main(["effects", identifier]) == 0
    entries = re.findall(r"file:   - \{id: (\S+), parameters: \{(.*)\}\}", capsys.readouterr().out)
    kind = known_effects()[identifier]
    more = [law for law in kind.finer_laws if set(law.parameters) - set(kind.parameters)]
    laws = [kind, *(law for law in more if kind.with_keys(p.name for p in law.parameters) is law)]
    assert [name for name, _ in entries] == [identifier] * len(laws)
    for law, (_, keys) in zip(laws, entries, strict=True):
        given = dict(pair.split(": ") for pair in keys.split(", ") if pair)
        assert kind.with_keys(given) is law
        for parameter in law.parameters:
            assert given.get(parameter.name, parameter.default) is not None
            assert given.get(parameter.name, "…") in ("…", *(parameter.choices or ()))


def test_an_effect_that_is_not_known_is_refused_with_the_nearest(capsys):
    assert main(["effects", "endstop"]) == 2
    assert capsys.readouterr().err == "camid: error: no effect 'endstop'; did you mean 'end-stop'?\n"


@pytest.mark.parametrize(
    ("latex", "text"),
    [
        (r"\dot z = \kappa\left(\dot y - \frac{1}{2}|\dot y|\,z\right)", "z\u0307 = κ(y\u0307 - 1/2|y\u0307| z)"),
        (
            r"y = \frac{\omega_1^2}{s^2 + 2\xi_1\omega_1 s + \omega_1^2}\;G(s)\,u",
            "y = (ω₁²)/(s² + 2ξ₁ω₁ s + ω₁²) G(s) u",
        ),
        (r"f = c\,\mathrm{sgn}(y)\,\sqrt{|y|}", "f = c sgn(y) sqrt(|y|)"),
    ],
)
def test_equations_as_text(latex, text):
    assert law_text(latex) == text
