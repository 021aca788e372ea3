"""Nominal plants that are off by up to a half, later rows, and the page on both."""

import numpy as np
import pandas as pd
import pytest

from camid.real_recordings.starts import SPREAD, first_names, names_by_first_row, nominal_draws
from camid.real_recordings.starts_page import starts_page
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


@pytest.mark.slow
def test_every_draw_is_diagnosed(tmp_path):
    import json

    record(effect("coulomb-friction", force=0.2), count=400).to_csv(tmp_path / "rig.csv", index=False)
    (tmp_path / "rig.yaml").write_text(json.dumps(simulation()), encoding="utf-8")
    table = first_names(tmp_path / "rig.csv", tmp_path / "rig.yaml", 2, 5)
    assert table["first"].tolist() == ["coulomb-friction"] * 2
    assert np.all(np.abs(table["value"] - 0.2) < 5.0 * table["deviation"])
    assert table["error"].max() == pytest.approx(table["error"].min(), rel=0.05)


@pytest.mark.slow
def test_later_rows_are_diagnosed(tmp_path):
    import json

    record(effect("coulomb-friction", force=0.2), count=600).to_csv(tmp_path / "rig.csv", index=False)
    content = {**simulation(), "initial_state": "estimate"}
    (tmp_path / "rig.yaml").write_text(json.dumps(content), encoding="utf-8")
    table = names_by_first_row(tmp_path / "rig.csv", tmp_path / "rig.yaml", [0.0, 2.0])
    assert table["start"].tolist() == [0.0, 2.0]
    assert table["first"].tolist() == ["coulomb-friction"] * 2
    # Fewer rows say less.
    assert table["deviation"][1] > table["deviation"][0]


def test_page_counts_the_draws():
    columns = ["draw", "verdict", "first", "value", "deviation", "error", "seconds"]
    names = ["clipping"] * 3 + [None]
    draws = pd.DataFrame(
        [[i, "explained", n, 1.0, 0.1, 0.1 + 0.1 * i, 2.0] for i, n in enumerate(names)], columns=columns
    )
    columns[0] = "start"
    windows = pd.DataFrame(
        [
            [3.1, "explained", "coulomb-friction", 0.0016, 0.0001, 0.004, 5.0],
            [15.0, "adequate", None, None, None, 0.01, 1.0],
        ],
        columns=columns,
    )
    text = starts_page({"a_rig": draws}, windows)
    (line,) = [row for row in text.splitlines() if row.startswith("| a rig")]
    assert [cell.strip() for cell in line.strip("|").split("|")] == [
        "a rig", "4", "clipping", "75 %", "10.0 to 40.0",
    ]  # fmt: skip
    assert "| 0.00160 ± 0.00010" in text
    assert [cell.strip() for cell in text.splitlines()[-1].strip("|").split("|")] == ["15", "none", "", "1.0"]
