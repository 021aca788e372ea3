"""Noise that grows with the position is structure; noise that a few far rows make look so is not."""

import numpy as np

from camid.diagnosis.residual.noise_recognition import depends_on_position
from tests.diagnosis.test_noise_of_uneven_rows import fitted_to
from tests.support.mass_on_spring import effect, record

NOISE = 0.005


def p_value(noise, seed=0, count=600):
    """Of the test, for readings with this noise, which is given the readings and a generator."""
    table = record(count=count, noise=0.0)
    reading = table["y"].to_numpy()
    found = noise(reading, np.random.default_rng([7, seed]))
    problem, fitted = fitted_to(table.assign(y=reading + found))
    return depends_on_position(problem, fitted)


def test_noise_in_proportion_to_the_position_is_told():
    assert p_value(lambda y, random: 0.03 * y * random.standard_normal(len(y))) < 1e-8


def test_even_noise_is_told_as_often_as_chance_has_it():
    found = [p_value(lambda y, random: NOISE * random.standard_normal(len(y)), seed) for seed in range(60)]
    assert 0.25 < np.mean(np.array(found) < 0.5) < 0.75
    assert min(found) > 1e-4


def test_one_far_reading_where_the_motion_is_far_says_nothing():
    """Its square outweighs all others together."""

    def noise(y, random):
        values = NOISE * random.standard_normal(len(y))
        values[np.argmax(np.abs(y))] = 20.0 * NOISE
        return values

    assert p_value(noise) > 1e-2


def test_readings_at_a_limit_say_nothing():
    """They carry no noise, and are where the motion is far."""
    table = record(count=600, noise=0.0)
    reading = table["y"].to_numpy() + NOISE * np.random.default_rng(7).standard_normal(600)
    limit = float(np.quantile(np.abs(reading), 0.8))
    clipped = table.assign(y=np.clip(reading, -limit, limit))
    problem, fitted = fitted_to(clipped, effect("clipping", low=-limit, high=limit))
    assert depends_on_position(problem, fitted) > 1e-3
