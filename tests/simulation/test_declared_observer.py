"""An observer in a simulation file: what is refused, and that it comes back as it was written."""

import pytest

from camid.errors import InputError
from camid.simulation.file import load_simulation

FALLING = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [8.0], "denominator": [1.0, 0.5, -22.0]}},
    "sensor": {"column": "y", "kind": "camera", "exposure": 0.004},
}
PENDULUM = {"plant": {"pendulum": {"natural_frequency": 3.0, "damping": 0.01, "rest": 0.0, "gain": 1.0}}}
CONTROLLER = {"controller": {"reference": "r", "position_gain": 3.0, "velocity_gain": 2.0}}
FIRST_ORDER = {"plant": {"transfer_function": {"numerator": [8.0], "denominator": [1.0, 0.5]}}}


def refusal(**more):
    with pytest.raises(InputError) as caught:
        load_simulation(FALLING | more)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_a_plant_that_falls_is_refused_with_a_rate_that_holds_it():
    message = refusal()
    assert "the transfer function is unstable: poles at 4.447 rad/s" in message
    assert "observer: {rate: 6.7}" in message
    assert load_simulation(FALLING | {"observer": {"rate": 6.7}}).observer.rate == 6.7


def test_no_observer_is_proposed_where_none_would_do():
    message = refusal(plant={"transfer_function": {"numerator": [8.0], "denominator": [1.0, -0.5]}})
    assert "the transfer function is unstable" in message
    assert "observer" not in message


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"observer": {"rate": 2.0}}, "runs away from the recording in spite of this observer"),
        ({"observer": {"rate": 9.0, "gain": -8.0}}, "runs away from the recording in spite of this observer"),
        ({"observer": {"rate": 0.0}}, "0.0 is not greater than 0"),
        ({"observer": {"rate": 9.0}} | CONTROLLER, "a controller is declared"),
        ({"observer": {"rate": 9.0}, "input": None}, "without input there is no controller"),
        ({"observer": {"rate": 9.0}} | PENDULUM, "an observer pulls a plant that is linear but for its effects"),
        ({"observer": {"rate": 9.0}} | FIRST_ORDER, "not two poles more than zeros"),
    ],
)
def test_what_is_refused(more, said):
    assert said in refusal(**more)


def test_it_is_written_as_it_was_read():
    declared = load_simulation(FALLING | {"observer": {"rate": 9.0, "gain": 6.0}})
    assert declared.to_mapping()["observer"] == {"rate": 9.0, "gain": 6.0}
    again = load_simulation(declared.to_mapping())
    assert again.observer == declared.observer
    assert load_simulation(FALLING | {"observer": {"rate": 9.0}}).observer.gain == 8.0
