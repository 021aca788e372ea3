"""Clean data are recovered to 1e-9 at every frequency, order, hold, exposure and latency, 10 % off or from nothing."""

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure

PERIOD = 0.02
PRODUCTS = [0.05, 0.2, 0.8, 1.6, 2.4, 2.8, 0.98 * np.pi]
ACQUISITIONS = {
    "paper": Acquisition(PERIOD),
    "first-order hold, short exposure, latency": Acquisition(PERIOD, "foh", "camera", 0.3 * PERIOD, 0.4 * PERIOD),
    "long latency": Acquisition(PERIOD, "zoh", "camera", 0.9 * PERIOD, 2.3 * PERIOD),
    "instant": Acquisition(PERIOD, "zoh", "instant"),
    "first-order hold, instant, latency": Acquisition(PERIOD, "foh", "instant", None, 1.7 * PERIOD),
}


def plants(omega):
    mode = second_order(1.0, omega, 0.1)
    slow = second_order(1.0, 0.45 * omega, 0.05)
    return {
        "two": second_order(1.3, omega, 0.1),
        "two, well damped": second_order(1.0, omega, 0.7),
        "two, zero": TransferFunction((0.5 * omega, omega**2), (1.0, 0.2 * omega, omega**2)),
        "three": mode * TransferFunction((0.6 * omega,), (1.0, 0.6 * omega)),
        "three, zero": TransferFunction((0.5, omega), (1.0, 0.7 * omega, 1.2 * omega**2, 0.5 * omega**3)),
        "four": mode * slow,
        "four, zeros": TransferFunction(
            (2.0 * omega**2, 0.1 * omega**3, omega**4), tuple(np.polymul(mode.denominator, slow.denominator))
        ),
        "four, mode past Shannon": mode * second_order(1.0, 2.5 * omega, 0.05),
    }


def coefficients(plant):
    return np.array([*plant.numerator, *plant.denominator[1:]])


@pytest.mark.parametrize("start", ["none", "ten percent off"])
@pytest.mark.parametrize("acquisition", ACQUISITIONS.values(), ids=ACQUISITIONS)
@pytest.mark.parametrize("name", list(plants(1.0)))
def test_clean_data_are_recovered(name, acquisition, start, excitation):
    signs, recovered = np.random.default_rng(3), 0
    for product in PRODUCTS:
        plant = plants(product / PERIOD)[name]
        structure = Structure.of_order(plant.order, len(plant.numerator) - 1)
        truth = coefficients(plant)
        nominal = None
        if start != "none":
            nominal = structure.plant(truth * (1.0 + 0.1 * signs.choice([-1.0, 1.0], len(truth))))
            if nominal.unstable_poles().size:
                continue
        output = sample(plant, excitation, acquisition)
        experiment = Experiment(excitation, output, acquisition, np.ones(len(output), bool))
        result = estimate(structure, [experiment], nominal=nominal)
        assert result.converged
        assert np.max(np.abs(coefficients(result.plant) / truth - 1.0)) < 1e-9, f"Tω0 = {product}"
        recovered += 1
    assert recovered == len(PRODUCTS) if start == "none" else recovered >= 5
