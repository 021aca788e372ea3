"""An effect counts by what it does beside the others, which may be nothing."""

from dataclasses import replace

import numpy as np
import pytest

from camid.proof.concealed.camera_readings import motion, record
from camid.proof.concealed.cases import CATALOGUE, Case
from camid.proof.concealed.drawn_recording import Built, draw_recording
from camid.proof.concealed.generator import make
from camid.proof.concealed.size_in_company import sizes_in_company


def built(drawn, strengths, seed=0):
    """The recording with effects of the catalogue's laws, each by its strength."""
    draws = np.random.default_rng(seed)
    effects = [CATALOGUE[name].law(draws, drawn.context(), False) for name in strengths]
    drawn.effects = [Built(e, s, None) for e, s in zip(effects, strengths.values(), strict=True)]
    return drawn


def drawn_for(*names, seed=1, index=0, snr_db=30.0):
    case = Case(seed, index, "several", names, snr_db)
    return draw_recording(case, np.random.default_rng([seed, index]))


def test_alone_the_size_is_what_the_coefficients_leave():
    drawn = built(drawn_for("quadratic-drag"), {"quadratic-drag": 0.001})
    (beside,) = sizes_in_company(drawn)
    (effect,) = drawn.effects
    # A small effect changes the output in proportion, so that a fit and a projection leave the same.
    assert beside == pytest.approx(drawn.size(effect.effect, effect.strength), rel=0.02)


def test_an_effect_that_never_acts_has_no_size():
    drawn = built(drawn_for("end-stop", "dead-zone"), {"end-stop": 0.5, "dead-zone": 0.3})
    stop, zone = sizes_in_company(drawn)
    assert stop > 1.0
    # What the dead zone leaves of the input moves the machine too little to get there.
    drawn.effects[1] = replace(drawn.effects[1], strength=0.9)
    stop, zone = sizes_in_company(drawn)
    assert stop < 1e-3
    assert zone > 10.0


def test_of_two_that_do_the_same_neither_shows():
    drawn = drawn_for("input-bias", "sensor-offset")
    drawn = built(drawn, {"input-bias": 0.3, "sensor-offset": 0.3})
    together = sizes_in_company(drawn)
    for number, effect in enumerate(drawn.effects):
        drawn.effects = [effect]
        assert together[number] < 0.2 * sizes_in_company(drawn)[0]


def test_jitter_hides_what_is_beside_it():
    drawn = built(drawn_for("quadratic-drag", "timestamp-jitter"), {"quadratic-drag": 0.05, "timestamp-jitter": 0.0})
    before, _ = sizes_in_company(drawn)
    drawn.effects[1] = replace(drawn.effects[1], strength=0.3)
    after, none = sizes_in_company(drawn)
    assert none is None
    assert after < 0.7 * before


@pytest.mark.parametrize("names", [("end-stop", "dead-zone"), ("delay", "timestamp-jitter")])
def test_the_truth_states_both_sizes(names):
    made = make(Case(3, 0, "several", names, None))
    for effect in made.truth["effects"]:
        assert effect["multiple"] >= 0.0
        assert effect["multiple_alone"] >= 0.0


def test_the_recording_is_that_of_the_effects_that_are_measured():
    """What is sized and what is recorded are the same machine."""
    drawn = built(drawn_for("dead-zone"), {"dead-zone": 0.2})
    setup = drawn.setup_with(drawn.effects)
    read = record(setup, motion(setup, drawn.command), 0.0, *map(np.random.default_rng, (0, 1)))
    np.testing.assert_allclose(read, drawn.output(setup, drawn.command))
