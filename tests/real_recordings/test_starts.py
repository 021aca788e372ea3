"""Nominal plants that are off by up to a half."""

import numpy as np
import pytest

from camid.real_recordings.starts import SPREAD, first_names, nominal_draws
from tests.support.mass_on_spring import effect, record, simulation


def test_poles_and_gain_are_drawn_and_nothing_else():
    content = simulation()
    before = content["plant"]["transfer_function"]
    drawn = list(nominal_draws(content, 20, 3))
    frequency = np.sqrt(before["denominator"][-1] / before["denominator"][0])
    found = [d["plant"]["transfer_function"] for d in drawn]
    shares = [np.sqrt(f["denominator"][-1] / f["denominator"][0]) / frequency for f in found]
    assert min(shares) >= 1.0 - SPREAD
    assert max(shares) <= 1.0 + SPREAD
    assert max(shares) - min(shares) > SPREAD
    gains = [f["numerator"][-1] / f["denominator"][-1] for f in found]
    assert len({round(g, 9) for g in gains}) == 20
    assert all(
        {k: v for k, v in d.items() if k != "plant"} == {k: v for k, v in content.items() if k != "plant"}
        for d in drawn
    )
    assert content == simulation()


def test_a_third_order_plant_stays_stable_and_a_pendulum_a_pendulum():
    denominator = np.polymul([0.2, 1.0], [1.0, 0.4, 400.0]).tolist()
    content = {"plant": {"transfer_function": {"numerator": [400.0], "denominator": denominator}}}
    for drawn in nominal_draws(content, 50, 1):
        poles = np.roots(drawn["plant"]["transfer_function"]["denominator"])
        assert len(poles) == 3
        assert np.all(poles.real < 0.0)
    content = {"plant": {"pendulum": {"natural_frequency": 4.0, "damping": 0.01, "rest": 3.0}}}
    (drawn,) = nominal_draws(content, 1, 1)
    assert drawn["plant"]["pendulum"]["rest"] == 3.0
    assert drawn["plant"]["pendulum"]["natural_frequency"] != 4.0
    again = next(nominal_draws(content, 1, 1))
    assert again == drawn


def test_every_draw_is_diagnosed(tmp_path):
    import json

    record(effect("coulomb-friction", force=0.2), count=400).to_csv(tmp_path / "rig.csv", index=False)
    (tmp_path / "rig.yaml").write_text(json.dumps(simulation()), encoding="utf-8")
    table = first_names(tmp_path / "rig.csv", tmp_path / "rig.yaml", 2, 5)
    assert table["first"].tolist() == ["coulomb-friction"] * 2
    assert table["error"].max() == pytest.approx(table["error"].min(), rel=0.05)
