"""A wrong declaration biases, the residual test says so, and the conclusion follows the numbers."""

import numpy as np
import pytest

from camid.ablations.identification_runs import excitation_signal, whole_experiment
from camid.ablations.wrong_hold import runs as wrong_hold
from camid.ablations.wrong_hold.drawing import draw
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import second_order
from camid.identification.declaration_search import refitted
from camid.identification.estimate import estimate
from camid.identification.structure import Structure

SETTINGS = {
    "periods": [0.02, 0.1],
    "decibels": [10, 20],
    "seeds": 6,
    "named": {"decibels": [10, 20], "seeds": 1},
    "cases": {
        "right": {"recorded": "zoh", "hold": "zoh", "sensor": "camera", "exposure": 1.0},
        "ZOH declared FOH": {"recorded": "zoh", "hold": "foh", "sensor": "camera", "exposure": 1.0},
        "camera declared instant": {"recorded": "zoh", "hold": "zoh", "sensor": "instant", "exposure": 1.0},
    },
}


@pytest.fixture(scope="module")
def shared(configuration):
    return {key: configuration[key] for key in ("plant", "excitation", "seed")}


@pytest.fixture(scope="module")
def table(shared):
    return wrong_hold.compute(SETTINGS, shared)


def values(table):
    return {name: number for name, (number, _) in wrong_hold.quantities(table).items()}


def test_right_declarations_are_unbiased_and_wrong_ones_are_not(table):
    """Independent of this project: a held input declared instant and unshifted is off by −7.3 % in a1 at T = 0.1 s,
    and by −15 % in b0, which are some two and eight standard deviations at 10 dB."""
    right = table[table["right"]]
    assert len(right) == 2 * 2 * 6
    assert np.abs(right[["standardised_b0", "standardised_a1", "standardised_a0"]]).max().max() < 4.5
    wrong = table[(table["case"] == "camera declared instant") & (table["period"] == 0.1) & (table["decibel"] == 10)]
    assert wrong["standardised_b0"].mean() < -5.0
    assert wrong["standardised_a0"].mean() < -5.0
    assert wrong["bias"].nunique() == 1


def test_power_grows_and_names_are_right(table):
    wrong = table[~table["right"]]
    assert wrong.loc[(wrong["period"] == 0.1), "alarm"].all()
    assert table.loc[table["right"], "independence_p"].min() > 1e-5
    assert wrong["named"].dropna().mean() == 1.0
    assert table.loc[table["right"], "named"].isna().all()


def test_the_optimum_nearby_is_the_one_that_the_default_method_finds(shared):
    signal = excitation_signal(shared["excitation"])
    output = sample(second_order(1.0, 10.0, 0.1), signal, Acquisition(0.1))
    declared = Acquisition(0.1, sensor="instant")
    structure = Structure.of_order(2, 0)
    start = estimate(structure, [whole_experiment(signal, output, declared)]).plant
    noisy = output + 0.1 * np.std(output) * np.random.default_rng(0).standard_normal(len(output))
    experiment = whole_experiment(signal, noisy, declared)
    near, found = refitted(structure, start, [experiment])[1], estimate(structure, [experiment])
    difference = np.array([*near.numerator, *near.denominator[1:]]) - [
        *found.plant.numerator,
        *found.plant.denominator[1:],
    ]
    assert np.all(np.abs(difference) < 0.05 * found.standard_deviations)


def test_the_conclusion_follows_the_numbers(table):
    value = values(table)
    sentence = wrong_hold.conclusion(value)
    assert "at 10 dB with short periods it cannot be relied upon" in sentence
    assert "at 20 dB from T = 20 ms on" in sentence
    blind = wrong_hold.conclusion({**value, "warns_from_at_20": np.inf, "bias_unwarned_at_20": 7.0})
    assert "at 20 dB at no period tried" in blind
    assert "at 10, 20 dB" in blind
    always = wrong_hold.conclusion({**value, "bias_unwarned_at_10": 1.0, "warns_from_at_10": 0.02})
    assert "so it warns before the bias exceeds 2" in always
    assert "in 5 %" in wrong_hold.conclusion({**value, "false_alarms": 5.0})
    assert "none was asked" in wrong_hold.conclusion({**value, "right_name_given": np.nan})


def test_the_figure_and_its_numbers(table):
    figure, numbers = draw(table)
    assert len(figure.axes) == 2 * 2
    assert len(numbers) == 3 * 2 * 2
    assert set(numbers.columns) == {"case", "right", "period", "decibel", "bias", "alarms"}
