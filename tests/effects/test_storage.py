"""Two storages, one above the other, against the differential equations of their levels."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects import Situation, known_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run

RATES = {"upper": 1.0 / 60.0, "lower": 1.0 / 150.0}
GAIN, PERIOD, COUNT = 2.0, 4.0, 200
OUTFLOW, FULL, SHARE = 0.8, 2.2, 0.6
# Of the square root's flow beside that in proportion to the level.
EXCESS = OUTFLOW * GAIN


def over_the_edge(level, full, width=0.03):
    """The flow sets in over a stretch about the height of the edge."""
    beyond, stretch = level - (1.0 - 0.5 * width) * full, width * full
    if beyond <= 0.0:
        return 0.0
    return beyond - 0.5 * stretch if beyond > stretch else 0.5 * beyond**2 / stretch


def levels(signal, upper, lower, *, excess, full, share):
    """Level of the lower storage at each row; what comes over the edge of the full upper one is lost or passes on."""

    def flow(level):
        return level + excess * np.sqrt(max(level, 0.0))

    state, found = np.zeros(2), []
    for value in signal:
        found.append(state[1])

        def slopes(_, levels, given=GAIN * value):
            over = 30.0 * over_the_edge(levels[0], full)
            leaving = flow(levels[0])
            return [upper * (given - over - leaving), lower * (leaving + share * over - flow(levels[1]))]

        state = solve_ivp(slopes, (0.0, PERIOD), state, "LSODA", rtol=1e-8, atol=1e-10).y[:, -1]
    return np.array(found)


def simulated(signal, effects):
    fast, slow = RATES.values()
    plant = TransferFunction((GAIN * fast * slow,), (1.0, fast + slow, fast * slow))
    acquisition = Acquisition(period=PERIOD, hold="zoh", sensor="instant")
    return run(Chain(plant, acquisition, effects), signal, PERIOD * np.arange(len(signal)))


@pytest.fixture(scope="module")
def signal():
    return np.repeat(np.random.default_rng(0).uniform(1.0, 5.0, COUNT // 5), 5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("below", ["slow", "fast"])
@pytest.mark.parametrize("laws", ["outflow", "overflow", "both"])
def test_levels(signal, laws, below, sign):
    upper, lower = RATES.values() if below == "slow" else reversed(RATES.values())
    kinds, effects, truth = known_effects(), [], {"excess": 0.0, "full": 1e9, "share": 0.0}
    if laws != "overflow":
        effects.append(kinds["square-root-outflow"](coefficient=OUTFLOW, below=below))
        truth["excess"] = EXCESS
    if laws != "outflow":
        full = FULL if laws == "both" else 2.0 * FULL
        effects.append(kinds["overflow"](height=sign * full, share=SHARE, below=below))
        truth |= {"full": full, "share": SHARE}
    expected = levels(signal, upper, lower, **truth)
    found = sign * simulated(sign * signal, tuple(effects))
    assert np.max(np.abs(found - expected)) < 4e-3 * np.std(expected)
    assert np.max(np.abs(sign * simulated(sign * signal, ()) - expected)) > 0.3 * np.std(expected)


def test_the_height_of_an_edge_changes_the_motion_smoothly(signal):
    """Else no fit finds it: the third differences of a smooth function of the height are tiny."""
    heights = 4.0 * (1.0 + np.linspace(-2e-3, 2e-3, 21))
    kind = known_effects()["overflow"]
    motions = np.array([simulated(signal, (kind(height=h, share=SHARE, below="slow"),)) for h in heights])
    change = np.max(np.abs(motions[-1] - motions[0]))
    assert change > 1e-3
    assert np.max(np.abs(np.diff(motions, 3, axis=0))) < 1e-3 * change


def test_the_law_begins_beside_the_plant_whose_tangent_it_is():
    """The estimated plant goes on straight from the mean level to an outflow of nothing, below the empty tank."""
    gain, linear, outflow, level = 0.004, 0.03, 8.0, 0.12
    rate = linear + 0.5 * gain * outflow / np.sqrt(level)
    begins = level - (linear * level + gain * outflow * np.sqrt(level)) / rate
    reading = level + 0.01 * np.sin(np.arange(200.0))
    nothing = np.zeros(200)
    situation = Situation(
        PERIOD * np.arange(200.0),
        np.ones(200),
        reading - begins,
        nothing,
        nothing,
        nothing,
        TransferFunction((gain,), (1.0, rate)),
        Acquisition(period=PERIOD, hold="zoh", sensor="instant"),
        np.ones(200, bool),
    )
    law = known_effects()["square-root-outflow"]
    effect, plant, constants = law.with_plant(situation, {"offset": begins})
    assert effect.values["coefficient"] == pytest.approx(outflow, rel=0.01)
    assert plant.monic.denominator[1] == pytest.approx(linear, rel=0.01)
    assert constants == {"offset": 0.0}
    assert law.with_plant(situation, {"offset": begins - 1.0}) is None


@pytest.mark.parametrize("linear", [0.0, 1e-4, 0.02])
def test_a_tank_need_not_lose_anything_in_proportion_to_its_level(linear):
    """It runs empty between: ḣ = a u − c √h − r h."""
    rate, outflow, period = 0.05, 6.0, 0.1
    signal = np.repeat([3.0, 0.0, 2.0, 0.0], 250)

    def slope(_, level, given):
        return rate * (given - outflow * np.sqrt(np.maximum(level, 0.0))) - linear * level

    level, expected = np.zeros(1), []
    for given in signal:
        expected.append(level[0])
        found = solve_ivp(slope, (0.0, period), level, "LSODA", args=(given,), rtol=1e-8, atol=1e-10)
        level = np.maximum(found.y[:, -1], 0.0)
    effect = known_effects()["square-root-outflow"](coefficient=outflow)
    plant = TransferFunction((rate,), (1.0, linear))
    chain = Chain(plant, Acquisition(period=period, hold="zoh", sensor="instant"), (effect,))
    found = run(chain, signal, period * np.arange(len(signal)))
    assert max(expected) > 0.2
    np.testing.assert_allclose(found, expected, atol=1e-4)
