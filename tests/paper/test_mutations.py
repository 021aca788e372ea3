"""What is declared or made wrongly leaves the stored tolerances: the guards of Fig. 7, on three of its periods."""

import copy

import pytest
from ruamel.yaml import YAML

from camid.paper.datasets import noise_samples, sampling_period_outputs
from camid.paper.excitation import excitation_table
from camid.paper.fig7_sampling_period.runs import identify_sampling_period
from camid.paper.quantities import Quantities, excitation_quantities, sampling_period_quantities
from camid.workflow.tolerances import compare
from tests.support import ROOT

GUARDED = {"largest_error_camera", "largest_error_foh-argument", "largest_side_of_autocorrelation"}


@pytest.fixture(scope="module")
def configuration():
    content = YAML(typ="safe").load(ROOT / "config/config.yaml")
    content["sampling_period_sweep"] |= {"start": 0.1, "stop": 0.3, "step": 0.1}
    return content


def failed(configuration, taps=None):
    """Names of the guarded quantities that leave their tolerances."""
    from scipy.signal import max_len_seq

    sweep = configuration["sampling_period_sweep"]
    excitation = excitation_table(**configuration["excitation"])
    if taps is not None:
        sequence, _ = max_len_seq(configuration["excitation"]["order"], taps=taps, length=len(excitation))
        excitation = excitation.assign(u=2.0 * sequence - 1.0)
    outputs = sampling_period_outputs(excitation, configuration["plant"], sweep)
    noise = noise_samples(excitation, sweep, configuration["seed"])
    estimates = identify_sampling_period(outputs, noise, configuration["plant"], sweep, sweep["cases"])
    quantities = Quantities()
    excitation_quantities(quantities, excitation)
    sampling_period_quantities(quantities, estimates, configuration)
    tolerances = YAML(typ="safe").load(ROOT / "config/tolerances.yaml")
    guards = [entry for entry in tolerances if entry["quantity"] in GUARDED]
    assert {entry["quantity"] for entry in guards} == GUARDED
    comparison = compare(quantities.table(), guards)
    return set(comparison.loc[~comparison["passed"], "quantity"])


def test_nothing_leaves_its_tolerance_as_it_is(configuration):
    assert failed(configuration) == set()


@pytest.mark.parametrize(
    ("case", "change", "quantity"),
    [
        ("foh-argument", {"hold": "zoh"}, "largest_error_foh-argument"),
        ("foh-argument", {"shift": 0}, "largest_error_foh-argument"),
        ("camera", {"sensor": "instant"}, "largest_error_camera"),
    ],
    ids=["zero-order hold for the first-order hold", "one-sample shift dropped", "camera declared an instant sensor"],
)
def test_a_wrong_declaration_leaves_its_tolerance(configuration, case, change, quantity):
    mutated = copy.deepcopy(configuration)
    mutated["sampling_period_sweep"]["cases"][case] |= change
    assert failed(mutated) == {quantity}


def test_a_sequence_with_wrong_taps_leaves_its_tolerance(configuration):
    taps = [configuration["excitation"]["order"] - 1]
    assert "largest_side_of_autocorrelation" in failed(configuration, taps)
