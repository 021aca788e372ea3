"""Which effects are static laws of one variable, and their values, found by trying them."""

import numpy as np
import pytest

from camid.chain.plant import TransferFunction
from camid.effects import known_effects
from camid.effects.learned import FORCES, LearnedForce
from camid.fitting.static_laws import static_values
from tests.support.mass_on_spring import effect

AT = np.linspace(-2.0, 3.0, 41)
PLANT = TransferFunction((100.0,), (1.0, 2.0, 100.0))
TURNED = TransferFunction((-100.0,), (1.0, 2.0, 100.0))


@pytest.mark.parametrize(
    ("law", "variables", "expected"),
    [
        (effect("cubic-stiffness", coefficient=0.2), "position", lambda y: 0.2 * y**3),
        (effect("end-stop", position=1.0, stiffness=3.0), "position", lambda y: 3.0 * np.maximum(y - 1.0, 0.0)),
        (effect("quadratic-drag", coefficient=0.3), "velocity", lambda v: 0.3 * v * np.abs(v)),
        (effect("coulomb-friction", force=0.4), "velocity", lambda v: 0.4 * np.sign(v)),
        (effect("amplitude-dependent-damping", coefficient=0.1), "damping over position", lambda y: 0.1 * y**2),
        (effect("saturation", limit=1.0), "input", lambda u: np.clip(u, -1.0, 1.0) - u),
        (effect("dead-zone", half_width=0.5), "input", lambda u: -np.clip(u, -0.5, 0.5)),
        (effect("lens-distortion", k1=0.02), "reading", lambda y: 0.02 * y**3),
        (effect("perspective", obliqueness=0.1), "reading", lambda y: y / (1.0 + 0.1 * y) - y),
        (effect("clipping", low=-1.0, high=2.0), "reading", lambda y: np.clip(y, -1.0, 2.0) - y),
    ],
    ids=lambda each: getattr(each, "identifier", None),
)
def test_static_laws_have_their_values(law, variables, expected):
    values = static_values(law, variables, AT, PLANT, 0.02)
    assert values == pytest.approx(expected(AT), abs=1e-9)
    others = {"position", "velocity", "damping over position", "gain over position", "input", "reading"} - {variables}
    assert all(static_values(law, other, AT, PLANT, 0.02) is None for other in others)


def test_what_depends_on_more_is_none():
    for law, variables in [
        (effect("position-dependent-friction", force=0.4, gradient=0.1), "velocity"),
        (effect("backlash", half_width=0.3), "input"),
        (effect("rate-limit", rate=3.0), "input"),
        (effect("hysteresis", strength=0.3, shape=2.0), "position"),
        (effect("sensor-offset", offset=0.3), "reading"),
        (effect("delay", delay=0.01), "reading"),
        (effect("speed-weighted-centroid"), "reading"),
    ]:
        assert static_values(law, variables, AT, PLANT, 0.02) is None, law.identifier


def test_against_the_motion_whatever_the_sign_of_the_gain():
    drag, friction = effect("quadratic-drag", coefficient=0.3), effect("coulomb-friction", force=0.4)
    for law in (drag, friction):
        there, turned = (static_values(law, "velocity", AT, plant, 0.02) for plant in (PLANT, TURNED))
        assert turned == pytest.approx(there)
    learned = LearnedForce(variables="velocity", knots=[-1.0, 1.0], values=[-0.5, 0.5])
    assert static_values(learned, "velocity", np.array([0.5]), TURNED, 0.02) == pytest.approx([0.25])
    assert static_values(learned, "position", AT, PLANT, 0.02) is None


@pytest.mark.parametrize("identifier", [name for name, kind in known_effects().items() if not kind.noise_like])
def test_every_effect_of_the_catalogue_can_be_tried(identifier):
    kind = known_effects()[identifier]
    law = kind(**{p.name: p.choices[0] if p.choices else 0.5 for p in kind.parameters if not p.is_name})
    for variables in (*FORCES, "input", "reading"):
        values = static_values(law, variables, AT, PLANT, 0.02)
        assert values is None or np.all(np.isfinite(values))
