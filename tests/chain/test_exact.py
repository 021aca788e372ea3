import numpy as np
import pytest
from scipy.linalg import expm

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.matrix_exponential import exponential_and_integral
from camid.chain.plant import TransferFunction, second_order
from tests.support.adaptive_integration import Reference, pieces_of

PERIOD = 0.02
PLANTS = {
    "mode": second_order(1.3, 10.0, 0.1),
    "fast mode": second_order(1.0, 140.0, 0.05),
    "mode with a zero": TransferFunction((3.0, 100.0), (1.0, 4.0, 100.0)),
    "third order": TransferFunction((1.0, 3.0), (1.0, 2.0, 5.0, 7.0)),
    "integrator": TransferFunction((5.0,), (1.0, 2.0, 0.0)),
    "two equal poles": TransferFunction((25.0,), (1.0, 10.0, 25.0)),
}


ROWS = 12


@pytest.fixture(scope="module")
def integrated(excitation):
    """Motions of all plants under both holds, by an adaptive integrator that shares nothing with camid."""
    return {
        (name, hold): Reference(plant.numerator, plant.denominator, tolerance=1e-12).run(
            pieces_of(excitation[:ROWS], PERIOD, hold, past=0)
        )
        for name, plant in PLANTS.items()
        for hold in ("zoh", "foh")
    }


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize(
    ("exposure", "latency"),
    [
        (1.0, 0.0),
        (0.35, 0.0),
        (0.35, 0.25),
        (0.75, 0.65),
        (1.0, 0.55),
        (0.5, 2.25),
        (0.5, 0.5),
        (None, 0.0),
        (None, 1.3),
    ],
)
@pytest.mark.parametrize("name", list(PLANTS))
def test_output_equals_adaptive_integration(name, exposure, latency, hold, excitation, integrated):
    plant, reference = PLANTS[name], integrated[name, hold]
    sensor = "instant" if exposure is None else "camera"
    tau = None if exposure is None else exposure * PERIOD
    acquisition = Acquisition(PERIOD, hold, sensor, tau, latency * PERIOD)
    end = PERIOD * np.arange(ROWS) - latency * PERIOD
    expected = reference.seen(end) if tau is None else reference.mean(end - tau, end)
    assert np.max(np.abs(sample(plant, excitation, acquisition)[:ROWS] - expected)) < 1e-9


def testexponential_and_integral_equal_scipy():
    generator = np.random.default_rng(5)
    for scale in (1e-3, 1.0, 30.0):
        matrix = scale * generator.standard_normal((5, 5))
        matrix[4] = 0.0  # singular, as with an integrator
        exponential, integral = exponential_and_integral(matrix, 0.3)
        block = np.block([[matrix, np.eye(5)], [np.zeros((5, 10))]])
        whole = expm(0.3 * block)
        assert np.allclose(exponential, whole[:5, :5], rtol=1e-9, atol=1e-12 * np.abs(whole).max())
        assert np.allclose(integral, whole[:5, 5:], rtol=1e-9, atol=1e-12 * np.abs(whole).max())


def test_sample_before_anything_moves_is_zero_and_length_is_kept():
    output = sample(second_order(1.0, 10.0, 0.1), np.ones(7), Acquisition(0.1))
    assert len(output) == 7
    assert output[0] == 0.0


def test_single_sample():
    assert sample(second_order(1.0, 10.0, 0.1), np.ones(1), Acquisition(0.1, "foh")).shape == (1,)


def test_direct_feedthrough_reaches_an_instant_sensor_at_once():
    lead = TransferFunction((2.0, 1.0), (1.0, 1.0))
    assert sample(lead, np.ones(3), Acquisition(0.1, sensor="instant"))[0] == pytest.approx(2.0)


def test_static_gain_without_poles():
    output = sample(TransferFunction((3.0,), (1.0,)), np.array([1.0, 2.0, 4.0]), Acquisition(1.0))
    assert np.allclose(output, [0.0, 3.0, 6.0])  # the mean over the period that has just ended


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"period": 0.0}, "period"),
        ({"period": 0.1, "exposure": 0.2}, "longer than the period"),
        ({"period": 0.1, "exposure": 0.0}, "must be positive"),
        ({"period": 0.1, "latency": -0.01}, "latency"),
        ({"period": 0.1, "hold": "soh"}, "hold"),
        ({"period": 0.1, "sensor": "eye"}, "sensor"),
        ({"period": 0.1, "exposure": float("nan")}, "exposure"),
    ],
)
def test_impossible_acquisitions_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Acquisition(**arguments)


def test_exposure_within_a_millionth_of_the_period_is_the_period():
    assert Acquisition(0.02, exposure=0.02 * (1.0 + 5e-7)).exposure == 0.02
