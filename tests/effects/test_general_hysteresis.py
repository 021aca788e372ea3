"""Hysteresis with loops of any shape: the exact step against an integrator, and how it is found."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.effects.general_hysteresis import HysteresisOfAnyLoop
from camid.effects.hysteresis import Hysteresis
from tests.support.mass_on_spring import record, simulation


def after(law, way, memory):
    """What becomes of the memory over a way, by the compiled part."""
    return law.memory_after.at(0.0, way, 0.0, 0.0, memory, values=law.vector.tolist())


def integrated(law, way, memory):
    """The same by an integrator, over the way."""
    side, back, shape = np.sign(way), law.values["curvature_back"], law.values["shape"]

    def slope(_, z):
        return shape * side * (1.0 - 0.5 * side * z - (0.5 - back) * np.abs(z))

    def crossing(_, z):
        return z[0]

    found = solve_ivp(
        slope, (0.0, abs(way)), [memory], rtol=1e-11, atol=1e-13, max_step=abs(way) / 200, events=crossing
    )
    return found.y[0, -1]


@pytest.mark.parametrize("back", [-0.4, 0.0, 0.3, 1.0, 1.1875])
@pytest.mark.parametrize("memory", [-0.8, -0.1, 0.0, 0.6])
@pytest.mark.parametrize("way", [-0.9, -0.05, 0.2, 1.3])
def test_the_step_is_exact(back, memory, way):
    law = HysteresisOfAnyLoop(strength=1.0, shape=1.3, curvature_back=back)
    np.testing.assert_allclose(after(law, way, memory), integrated(law, way, memory), rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("way", [-2.0, 0.3])
def test_without_a_curvature_back_it_is_the_law_that_saturates(way):
    law = HysteresisOfAnyLoop(strength=1.0, shape=1.3, curvature_back=0.0)
    plain = law.simplified()
    assert isinstance(plain, Hysteresis)
    expected = plain.memory_after.at(0.0, way, 0.0, 0.0, 0.4, values=plain.vector.tolist())
    np.testing.assert_allclose(after(law, way, 0.4), expected)


@pytest.mark.slow
def test_a_loop_that_hardens_is_found():
    """As in the benchmark of Noël & Schoukens (2016), whose force hardens along and bends on its way back."""
    law = HysteresisOfAnyLoop(strength=0.5, shape=1.5, curvature_back=1.2)
    found = camid.diagnose(record(law, noise=0.002, count=2000), simulation())
    assert [f.identifier for f in found.findings] == ["hysteresis"]
    for name, truth in law.values.items():
        estimate = found.findings[0].parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < truth
