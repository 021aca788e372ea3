"""What a reader is advised to record next."""

import pytest

from camid.effects.separating_experiment import SeparatingExperiment, advice

ALL = list(SeparatingExperiment)


@pytest.mark.parametrize("driven", [True, False])
@pytest.mark.parametrize("experiment", ALL)
def test_without_a_camera_nothing_is_filmed(experiment, driven):
    said = experiment.advised(driven=driven, filmed=False)
    for word in ("camera", "shutter", "exposure", "image", "marker", "light", "frame rate"):
        assert said is None or word not in said


def test_what_both_name_is_advised():
    first, *_, last = ALL
    assert advice([first, last], [[last]]) == last.value
    assert advice([first, last], [[last], [first]]) == first.value
    assert advice([first], [[first]], filmed=False).startswith("Input and output at one rate")
    assert advice([first], []) is None
