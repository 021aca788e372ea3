"""End stops whose force grows with any power of the depth."""

import numpy as np
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.effects.end_stop_of_any_power import DampedEndStopOfAnyPower, EndStopOfAnyPower
from camid.effects.hertz_contact import HertzEndStop
from camid.effects.stiffness import EndStop
from tests.support.mass_on_spring import PLANT, record, simulation


@pytest.mark.parametrize("gain", [1.0, -1.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_force_grows_with_the_power_of_the_depth(gain, side):
    plant = TransferFunction(tuple(gain * np.array(PLANT.numerator)), PLANT.denominator)
    law = EndStopOfAnyPower(position=0.5 * side, stiffness=4.0, power=2.2)
    damped = DampedEndStopOfAnyPower(position=0.5 * side, stiffness=4.0, loss=0.5, power=2.2)
    for depth in (-0.1, 0.1, 0.4):
        force = 4.0 * 0.5 * (max(depth, 0.0) / 0.5) ** 2.2
        at = side * (0.5 + depth)
        assert gain * side * law.force.at(0.0, at, 0.0, 0.0, 0.0, values=law.force_values(plant)) == pytest.approx(
            force
        )
        for rate, factor in ((1.0, 1.5), (-1.0, 0.5), (-3.0, 0.0)):
            found = damped.force.at(0.0, at, side * rate, 0.0, 0.0, values=damped.force_values(plant))
            assert gain * side * found == pytest.approx(factor * force)


def test_of_the_powers_one_and_three_halves_it_is_the_plain_laws():
    straight = EndStopOfAnyPower(position=0.5, stiffness=4.0, power=1.0)
    assert type(straight.simplified()) is EndStop
    hertz = HertzEndStop(position=0.5, hertz=3.0)
    power = hertz.finer(type("Seen", (), {"velocity": np.ones(3)})())[0]
    assert type(power) is EndStopOfAnyPower
    for law, other in ((straight, straight.simplified()), (power, hertz)):
        for at in (0.4, 0.55, 1.2):
            forces = [e.force.at(0.0, at, 0.0, 0.0, 0.0, values=e.force_values(PLANT)) for e in (law, other)]
            assert forces[0] == pytest.approx(forces[1])


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [
        EndStopOfAnyPower(position=0.5, stiffness=2.0, power=2.3),
        DampedEndStopOfAnyPower(position=0.5, stiffness=3.0, loss=0.6, power=2.0),
    ],
    ids=["without a loss", "with a loss"],
)
def test_a_contact_of_another_power_is_found(law):
    found = camid.diagnose(record(law, noise=0.0005, count=2000), simulation())
    assert [f.identifier for f in found.findings] == ["end-stop"]
    for name, truth in law.values.items():
        estimate = found.findings[0].parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.3 * abs(truth)
