"""What a rig allows: in the units of its files, about where it rests, and with the option that changes it."""

from dataclasses import replace

import numpy as np
import pytest

from camid.diagnosis.watch import Watch
from camid.errors import InputError
from camid.experiment_design.columns import Column, Columns
from camid.experiment_design.hypothesis import Played
from camid.experiment_design.limits import Limits
from camid.experiment_design.prediction import travelled
from camid.experiment_design.run import Task, design_for
from camid.experiment_design.sources import Wishes, known_from_diagnosis, limits_of, noise_of

MILLIMETRES = Columns("t", "u", "y", Column(), Column(), Column(1e-3), "V", "mm")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"low": 2.0, "high": 2.0}, "slide: the input can only be 2 V; give two limits with --amplitude"),
        (
            {"travel": (-0.01, 0.02), "positions": (0.05,)},
            "50 mm lies outside of the travel; it lies within −10 to 20",
        ),
        ({"rate": -1.0}, "slide: rate −1 V/s"),
        ({"duration": 0.0}, "with --duration"),
    ],
)
def test_what_cannot_be_kept_is_said_in_the_units_of_the_files(changes, said):
    allowed = {"low": -1.0, "high": 1.0, "rate": 10.0, "duration": 10.0, "periods": (0.02,)}
    with pytest.raises(InputError) as refused:
        Limits(**{**allowed, **changes}, columns=MILLIMETRES, where="slide")
    assert said in str(refused.value)


def test_the_travel_of_a_recording_is_widened_to_where_the_rig_rests(diagnosis):
    """A recording in motion that never came to rest: an experiment begins there all the same."""
    known = known_from_diagnosis(diagnosis)
    usual = limits_of(known, Wishes()).travel
    away = {**known.conditions, "output": {"low": 2.0, "high": 3.0}}
    low, high = limits_of(replace(known, conditions=away), Wishes()).travel
    rests = [r for h in known.hypotheses for r in travelled(h, Played(np.zeros(10), 0.02))]
    assert low < min(rests) - 0.05 * (high - low)
    assert high == pytest.approx(3.0 + 0.1 * (3.0 - min(rests)))
    output = known.conditions["output"]
    assert usual == pytest.approx(
        (1.1 * output["low"] - 0.1 * output["high"], 1.1 * output["high"] - 0.1 * output["low"])
    )


def test_a_travel_without_the_rest_names_the_folder_and_the_option(diagnosis):
    known = replace(known_from_diagnosis(diagnosis), source="slide")
    limits = replace(limits_of(known, Wishes(travel=(0.2, 0.9))), columns=MILLIMETRES)
    with pytest.raises(InputError, match=r"slide: the rig rests at .* mm, .* 200 to 900 mm; allow more with --"):
        design_for(Task(known.hypotheses, limits, noise_of(known, Wishes()), known.rows), Watch(None, None))


@pytest.mark.slow
def test_a_smaller_input_stays_in_its_range(diagnosis):
    """A pump that always runs: what is too much for the travel comes nearer to its least input, and not to none."""
    known = known_from_diagnosis(diagnosis)
    limits = limits_of(known, Wishes(amplitude=(0.1, 1.0), travel=(-0.6, 0.6), duration=4.0))
    found = design_for(Task(known.hypotheses, limits, noise_of(known, Wishes()), known.rows), Watch(None, None))
    assert 0.1 <= found.played.signal.min() < found.played.signal.max() < 0.7


def test_an_input_that_is_rounded_to_zero_has_no_sign():
    limits = Limits(-1.0, 1.0, 10.0, 10.0, (0.02,))
    assert not np.any(np.signbit(limits.written(np.array([-1e-9, 0.0, -0.0]))))
