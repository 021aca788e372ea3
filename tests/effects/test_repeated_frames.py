"""Repeated values: frames that were lost, and frames of a codec that sends nothing new of a marker at rest."""

from dataclasses import replace

import numpy as np
import pytest

from camid.effects.noise import DroppedFrames
from camid.effects.printed_values import resolution
from tests.effects.test_catalogue import situation

COUNT, NOISE = 1000, 0.005
SEEDS = range(20)


def swings_and_stops(seed):
    """A recording that follows a lively input, and hardly moves where each tenth of the rows begins."""
    generator = np.random.default_rng(np.random.SeedSequence([seed, 3]))
    given = situation(seed=seed, count=COUNT)
    position = given.position.copy()
    stops = np.arange(50, COUNT, 100)
    for stop in stops:  # sticks for as many frames as friction would hold it, and goes on from there
        held = int(generator.integers(7, 12))
        position[stop + held :] += position[stop] - position[stop + held]
        position[stop : stop + held] = position[stop]
    residual = NOISE * generator.standard_normal(COUNT)
    return replace(given, position=position, recorded=position + residual, residual=residual)


def coded(given):
    """The frames that a codec would repeat: in the midst of a stop, where the marker has not moved."""
    still = np.diff(given.position) == 0.0
    return 2 + np.flatnonzero(still[:-3] & still[1:-2] & still[2:-1] & still[3:])


def repeating(given, rows):
    """The recording with the last value again at these rows."""
    recorded = given.recorded.copy()
    for row in np.sort(rows):
        recorded[row] = recorded[row - 1]
    return replace(given, recorded=recorded, residual=recorded - given.position)


def recognised(given):
    found = DroppedFrames.recognise(given)
    return found is not None and found.p_value < 1e-4


@pytest.mark.parametrize("count", [2, 5, 30])
def test_frames_that_a_codec_repeats_are_not_lost(count):
    for seed in SEEDS:
        given = swings_and_stops(seed)
        rows = np.random.default_rng(seed).choice(coded(given), count, replace=False)
        assert not recognised(repeating(given, rows))


@pytest.mark.parametrize("count", [1, 3, 12, 60])
def test_lost_frames_are_found_in_the_same_recording(count):
    missed = 0
    for seed in range(100):
        given = swings_and_stops(seed)
        rows = np.random.default_rng(np.random.SeedSequence([seed, count])).choice(COUNT, count, replace=False)
        missed += not recognised(repeating(given, rows))
    assert missed <= (10 if count < 12 else 1)


def test_frames_are_lost_beside_those_that_a_codec_repeats():
    missed = 0
    for seed in SEEDS:
        given = swings_and_stops(seed)
        random = np.random.default_rng(np.random.SeedSequence([seed, 5]))
        rows = np.concatenate([random.choice(coded(given), 5, replace=False), random.choice(COUNT, 12, replace=False)])
        missed += not recognised(repeating(given, np.unique(rows)))
    assert missed <= 1


def test_nothing_tells_them_apart_where_noise_hides_the_motion():
    """Values with that much noise are no codec's: a repetition is a lost frame."""
    for seed in SEEDS:
        given = situation(seed=seed, count=COUNT)
        loud = replace(given, recorded=given.position + 50.0 * given.residual)
        assert recognised(repeating(loud, np.arange(100, COUNT, 250)))


def printed_in_degrees(given, missing=0):
    """The recording as a file holds it, in thousandths of a degree, and as it is read; some rows are interpolated."""
    recorded = np.deg2rad(np.round(np.rad2deg(given.recorded), 3))
    rows = np.arange(10, COUNT - 10, COUNT // missing) if missing else np.array([], int)
    recorded[rows] = 0.5 * (recorded[rows - 1] + recorded[rows + 1])
    return replace(given, recorded=recorded, residual=recorded - given.position)


@pytest.mark.parametrize("missing", [0, 40])
def test_values_that_repeat_by_chance_in_a_file_of_another_unit_are_no_lost_frames(missing):
    repeats = 0
    for seed in SEEDS:
        given = printed_in_degrees(swings_and_stops(seed), missing)
        repeats += int(np.sum(np.diff(given.recorded) == 0.0))
        assert not recognised(given), seed
        lost = repeating(swings_and_stops(seed), np.arange(20, COUNT, 25))
        assert recognised(printed_in_degrees(lost, missing)), seed
    assert repeats > 0


def test_digits_of_values_in_another_unit_are_those_of_their_file():
    values = np.deg2rad(np.round(30.0 * np.random.default_rng(5).standard_normal(2000), 3)) + 0.7
    assert resolution(values) == pytest.approx(np.deg2rad(1e-3), rel=1e-9)
    assert resolution(np.random.default_rng(6).standard_normal(2000)) < 1e-14
