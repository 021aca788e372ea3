"""The motion at the first sample, as the first recorded positions show it."""

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.companion_form import time_scale
from camid.engine.mechanics import companion_block
from camid.fitting.initial_motion import recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import LinearPlant
from camid.fitting.problem import Problem
from camid.fitting.recorded_zero import recorded_zero
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from tests.support.mass_on_spring import PERIOD, PLANT, record

STATE = np.array([0.4, -0.7])


@pytest.mark.parametrize("left_out", [0, 3, 200, pytest.param(10**6, id="all: it judges only")])
def test_rows_that_are_not_fitted_show_the_motion_where_the_first_fitted_ones_are_far(left_out):
    table = record(sensor="instant", exposure=None, state=STATE, noise=1e-4)
    used = np.arange(len(table)) >= left_out
    acquisition = Acquisition(PERIOD, sensor="instant")
    structure = Structure.fixed(PLANT)
    experiment = Experiment(table["u"].to_numpy(), table["y"].to_numpy(), acquisition, used, True)
    problem = Problem(structure, [experiment], [table["t"].to_numpy()], LinearPlant(), 0.1)
    (state,) = recorded_start(problem, Model(structure.coefficients())).initial
    matrix, row, _ = companion_block(PLANT, time_scale(PLANT.monic.denominator))
    seen = np.vstack([row, row @ matrix])
    np.testing.assert_allclose(seen @ state, seen @ STATE, atol=0.05 * np.max(np.abs(seen @ STATE)))


@pytest.mark.parametrize(("at_rest", "shown"), [(True, 3.0), (False, 7.0)])
def test_a_plant_that_is_said_to_begin_at_its_zero_shows_the_sensor_s(at_rest, shown):
    table = record(sensor="instant", exposure=None, noise=1e-4)
    acquisition = Acquisition(PERIOD, sensor="instant")
    structure = Structure.fixed(PLANT)
    output = table["y"].to_numpy() + 3.0
    experiment = Experiment(table["u"].to_numpy(), output, acquisition, np.ones(len(output), bool), not at_rest)
    plant = LinearPlant(offset_free=True)
    problem = Problem(structure, [experiment], [table["t"].to_numpy()], plant, 0.1)
    model = Model(structure.coefficients(), constants={"offset": 7.0})
    assert recorded_zero(problem, model).constants["offset"] == pytest.approx(shown, abs=0.01)
