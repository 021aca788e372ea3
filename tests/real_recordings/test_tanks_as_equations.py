"""The cascaded tanks written as two tanks that empty with the square root of their level."""

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

import camid
from tests.real_recordings.test_real_recordings import recording
from tests.support import ROOT

FILE = ROOT / "config/simulations/cascaded_tanks_equations.yaml"
# Root mean square in V that an optimiser of its own leaves with an integrator of its own: least squares from 30 random
# starts, explicit Euler steps of 0.5 s, the same unknowns.
INDEPENDENT = 0.566


@pytest.fixture(scope="module")
def tables():
    source = pd.read_csv(recording("cascaded_tanks"))
    time = 4.0 * np.arange(len(source))
    return [pd.DataFrame({"t": time, "u": source[f"u{run}"], "y": source[f"y{run}"]}) for run in ("Est", "Val")]


@pytest.fixture(scope="module")
def believed():
    content = YAML(typ="safe").load(FILE)
    content.pop("recording")
    return content | {"time": {"column": "t"}}


def error(table, simulation):
    simulated = camid.simulate(table, simulation)["simulated"]
    return float(np.sqrt(np.mean((simulated - table["y"]) ** 2)))


@pytest.mark.slow
def test_the_optimum_is_that_of_an_independent_search(tables, believed):
    found = camid.identify(tables[0], believed)
    assert found.converged
    assert found.nrmse * np.std(tables[0]["y"]) == pytest.approx(INDEPENDENT, abs=2e-3)
    assert any("the residual is not white" in sentence for sentence in found.warnings())


@pytest.mark.slow
def test_the_overflow_of_the_upper_tank_is_named(tables, believed):
    found = camid.diagnose(tables[0], believed)
    first = found.findings[0]
    assert first.identifier == "overflow"
    assert first.parameters["state"].value == "upper"
    assert error(tables[0], found.improved) < 0.20
    assert error(tables[1], found.improved) < 0.30
