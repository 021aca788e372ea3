import control
import numpy as np
import pytest

from camid.chain.plant import TransferFunction, second_order


def test_second_order_is_equation_15():
    plant = second_order(2.0, 10.0, 0.1)
    assert plant.numerator == (200.0,)
    assert plant.denominator == (1.0, 2.0, 100.0)
    assert plant.static_gain() == 2.0


def test_leading_zeros_are_structure_and_are_stripped():
    assert TransferFunction((0.0, 3.0), (0.0, 1.0, 2.0)).numerator == (3.0,)


@pytest.mark.parametrize(
    ("numerator", "denominator", "message"),
    [
        ((1.0, 0.0, 0.0), (1.0, 1.0), "improper"),
        ((0.0,), (1.0, 1.0), "numerator is zero"),
        ((1.0,), (0.0,), "denominator is zero"),
        ((np.nan,), (1.0, 1.0), "not a finite number"),
    ],
)
def test_what_is_no_plant_is_refused(numerator, denominator, message):
    with pytest.raises(ValueError, match=message):
        TransferFunction(numerator, denominator)


@pytest.mark.parametrize(
    ("denominator", "unstable"),
    [
        ((1.0, 2.0, 100.0), 0),
        ((1.0, 0.0, 100.0), 0),
        ((1.0, 2.0, 0.0), 0),
        ((1.0, 0.0, 2.0, 0.0, 1.0), 0),
        ((1.0, -2.0, 100.0), 2),
        ((1.0, 1.0, -1.0), 1),
    ],
)
def test_integrators_and_undamped_modes_are_stable(denominator, unstable):
    assert len(TransferFunction((1.0,), denominator).unstable_poles()) == unstable


@pytest.mark.parametrize(
    ("denominator", "fastest"),
    [((1.0, 2.0, 100.0), 10.0), ((1.0, 5.0, 4.0), 4.0), ((2.0, 6.0, 0.0), 3.0), ((1.0, 0.0), 0.0), ((3.0,), 0.0)],
)
def test_the_fastest_pole_lies_farthest_from_zero(denominator, fastest):
    assert TransferFunction((1.0,), denominator).fastest_pole == pytest.approx(fastest)


def test_exchange_with_python_control():
    plant = second_order(1.0, 10.0, 0.1) * TransferFunction((1.0, 3.0), (1.0, 5.0))
    returned = TransferFunction.from_control(plant.to_control())
    assert np.allclose(returned.numerator, plant.numerator)
    assert np.allclose(returned.denominator, plant.denominator)
    frequencies = np.array([0.1, 5.0, 10.0, 70.0])
    assert np.allclose(plant.to_control()(1j * frequencies), plant.frequency_response(frequencies))
    state_space = TransferFunction.from_control(control.ss(plant.to_control()))
    assert np.allclose(state_space.frequency_response(frequencies), plant.frequency_response(frequencies))


def test_systems_with_several_inputs_and_discrete_time_are_refused():
    with pytest.raises(ValueError, match="2 inputs and 1 outputs"):
        TransferFunction.from_control(control.ss([[-1.0]], [[1.0, 2.0]], [[1.0]], [[0.0, 0.0]]))
    with pytest.raises(ValueError, match="discrete time"):
        TransferFunction.from_control(control.tf([1.0], [1.0, 0.5], 0.1))
