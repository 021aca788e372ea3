"""Rigs that a first recording leaves open: what the generator promises, and what is counted."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

import camid
from camid.proof.designed_experiment import rigs
from camid.proof.designed_experiment.campaign import COLUMNS, IDENTIFIERS, is_open, judged, summary, to_markdown
from camid.proof.designed_experiment.drawing import draw
from camid.proof.designed_experiment.quantities import TARGET, quantities
from tests.support import ROOT

# Parameters of the effects that the generator's laws are.
PARAMETERS = {
    "dry friction": "force",
    "quadratic drag": "coefficient",
    "damping that grows with the position": "coefficient",
    "cubic spring": "coefficient",
    "quadratic spring": "coefficient",
    "dead zone": "half_width",
    "saturation": "limit",
    "play": "half_width",
    "uneven gain": "ratio",
    "lens": "k1",
    "perspective": "obliqueness",
}


def test_the_generator_knows_nothing_of_the_tool():
    source = Path(rigs.__file__).read_text(encoding="utf-8")
    assert not re.search(r"^\s*(import|from) camid", source, flags=re.MULTILINE)


@pytest.mark.parametrize("law", rigs.LISTED)
def test_a_law_is_that_of_the_catalogue(law):
    """The two integrators share nothing, and agree to a small part of the noise that is added."""
    drawn = next(r for r in (rigs.draw(1, n) for n in range(400)) if r.law == law)
    rig = replace(drawn, rows=200, wrong=(1.0, 1.0, 1.0))
    signal = rigs.first_input(rig)
    content = rig.simulation()
    content["effects"] = [{"id": IDENTIFIERS[law], "parameters": {PARAMETERS[law]: rig.strength}}]
    table = pd.DataFrame({"t": rig.period * np.arange(len(signal)), "u": signal})
    simulated = camid.simulate(table, content)["simulated"].to_numpy()
    made = rigs.readings(rig, signal, law)
    assert np.std(made - simulated) < 2e-3 * np.std(made)
    without = rigs.readings(rig, signal, None)
    assert np.std(made - without) > 3e-3 * np.std(made)


def test_rigs_are_those_of_their_numbers():
    one, two = rigs.draw(3, 7), rigs.draw(3, 7)
    assert one == two != rigs.draw(3, 8)
    pd.testing.assert_frame_equal(
        rigs.recording(one, rigs.first_input(one), 0), rigs.recording(two, rigs.first_input(two), 0)
    )
    laws = [rigs.draw(3, n).listed for n in range(12)]
    assert laws == [n % 6 != 5 for n in range(12)]


def test_what_is_open_and_what_is_decided():
    assert is_open({"a": 0.5, "b": 0.2, "unlisted": 0.3})
    assert not is_open({"a": 0.7, "b": 0.05, "unlisted": 0.25})
    found = judged({"a": 0.96, "b": 0.01, "unlisted": 0.03}, "a", "designed", 12.0)
    assert (found["designed_right"], found["designed_decided"], found["designed_gap"]) == (True, True, 12.0)
    wrong = judged({"a": 0.96, "unlisted": 0.04}, "b", "designed", 12.0)
    assert (wrong["designed_right"], wrong["designed_truth_weight"]) == (False, 0.0)
    nothing = judged({}, "b", "designed", 12.0)
    assert (nothing["designed_name"], nothing["designed_decided"]) == ("", False)


def rows():
    base = {"open": True, "failure": "", "kind": "steps", "seconds": 10.0, "first_truth_weight": 0.4}
    base |= {"first_names": "", "law": "lens", "predicted_evidence": 20.0}
    designed = [
        ("a", {"a": 0.97}, 0.99),
        ("a", {"a": 0.6, "b": 0.4}, 0.5),
        ("a", {"b": 0.96}, 0.99),
        (None, {"a": 0.97}, np.nan),
    ]
    return pd.DataFrame(
        [
            base
            | {"number": n, "truth": truth or "", "predicted_weight": predicted}
            | judged(names, truth, "designed", 10.0)
            | judged({"a": 0.5, "b": 0.3, "unlisted": 0.2}, truth, "repeated", 1.0)
            for n, (truth, names, predicted) in enumerate(designed)
        ]
        + [base | {"number": 9, "truth": "a", "open": False}]
    ).reindex(columns=COLUMNS)


def test_shares_are_counted():
    found = summary(rows()).set_index(["law", "experiment"])
    listed = found.loc[("listed", "designed")]
    assert (listed["rigs"], listed["decided"], listed["wrong"], listed["right"]) == (3, 1, 1, 2)
    assert listed["share"] == pytest.approx(1 / 3)
    assert (found.loc[("promised", "designed"), "rigs"], found.loc[("promised", "designed"), "decided"]) == (2, 1)
    assert (found.loc[("outside", "designed"), "rigs"], found.loc[("outside", "designed"), "decided"]) == (1, 1)
    assert found.loc[("listed", "repeated"), "decided"] == 0
    text = to_markdown(summary(rows()), rows(), "made by a test")
    assert "1 (33 %)" in text
    assert "made by a test" in text
    _, table = draw(rows())
    assert len(table) == 3


def test_quantities_are_of_the_rigs_with_a_law_of_the_catalogue():
    found = quantities(rows()).set_index("quantity")["value"]
    assert (found["rigs"], found["wrong"], found["longest_design"]) == (3, 1, 10.0)
    assert found["decided"] == found["decided_without_dry_friction"] == pytest.approx(100 / 3)
    assert (found["decided_where_promised"], found["decided_by_repetition"]) == (50.0, 0.0)
    assert found["right"] == pytest.approx(200 / 3)


def test_the_committed_table_meets_what_is_asked():
    shares = pd.read_csv(ROOT / "paper_figs/designed_experiment_shares.csv").set_index(["law", "experiment"])
    listed = shares.loc[("listed", "designed")]
    tolerances = YAML(typ="safe").load(ROOT / "config/tolerances.yaml")
    asked = {entry["quantity"]: entry for entry in tolerances if entry["target"] == TARGET}
    assert listed["rigs"] >= asked["rigs"]["at_least"]
    assert listed["wrong"] <= asked["wrong"]["at_most"]
    assert 100.0 * listed["right"] / listed["rigs"] >= asked["right"]["at_least"]
    text = (ROOT / "paper_figs/designed_experiment.md").read_text(encoding="utf-8")
    longest = re.search(r"(\d+) s at most", text)
    assert longest is not None
    assert float(longest[1]) <= asked["longest_design"]["at_most"]
