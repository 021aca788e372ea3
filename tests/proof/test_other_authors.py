"""Tables of other authors: scores of recordings whose truth is known."""

import numpy as np
import pandas as pd
import pytest

from camid.proof import other_authors
from camid.proof.other_authors import author_lines, diagnose_and_score, recovered_share
from camid.proof.second_author.concealment import NotShownError
from camid.proof.second_author.recordings import kinds, make
from camid.simulation.file import load_simulation, write_simulation

SEED, COUNT = 19, 20


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    first = [kinds(SEED, COUNT).index(kind) for kind in ("none", "single")]
    return diagnose_and_score("second_author", first, SEED, COUNT, tmp_path_factory.mktemp("second"))


def test_recordings_are_diagnosed_and_scored(tables):
    scores, parameters, weights = tables
    assert scores["kind"].tolist() == ["none", "single"]
    assert scores.loc[0, "verdict"] == "adequate"
    assert not scores.loc[0, "false_alarm"]
    assert set(weights["index"]) <= set(scores["index"])
    assert set(parameters["index"]) <= set(scores["index"])
    assert (scores["seconds"] > 0.0).all()


@pytest.mark.slow
def test_laws_that_no_rig_shows_together_end_no_table(tmp_path, monkeypatch):
    """The numbers of the others stay, and the table has their count."""
    nothing = kinds(SEED, COUNT).index("none")

    def made(seed, index, count):
        if index != nothing:
            raise NotShownError("no rig shows actuator-lag, backlash")
        return make(seed, index, count)

    monkeypatch.setitem(other_authors.AUTHORS, "second_author", made)
    scores, _, _ = diagnose_and_score("second_author", [nothing, nothing + 1], SEED, COUNT, tmp_path)
    assert scores["index"].tolist() == [nothing]


def test_every_line_counts_what_it_says(tables):
    found = {line.quantity: line for line in author_lines(*tables)}
    assert (found["false_alarms"].value, found["false_alarms"].count) == (0.0, 1)
    assert found["several_in_class_2"].count == 0
    assert found["named_in_class"].count <= 1


def test_a_model_that_is_right_recovers_everything_and_the_nominal_one_nothing(tmp_path):
    """Of a plain rig with an effect: the refitted simulation is where the share begins."""
    singles = (i for i, kind in enumerate(kinds(SEED, COUNT)) if kind == "single")
    shares = (share(index, tmp_path) for index in singles)
    assert next(s for s in shares if np.isfinite(s)) == pytest.approx(0.0, abs=1e-6)


def share(index, folder):
    """Of the refitted simulation itself."""
    import camid

    case = make(SEED, index, COUNT)
    if case.again is None or "controller" in case.simulation:
        return np.nan
    refitted = camid.identify(case.recording, load_simulation(case.simulation)).simulation
    write_simulation(refitted, folder / "refitted.yaml")
    return recovered_share(case, folder / "refitted.yaml")


def test_a_table_without_effects_is_no_error():
    scores = pd.DataFrame(
        {"kind": ["none"], "truth": [""], "multiple": [np.nan], "inexact": [False], "false_alarm": [False]}
        | {name: [False] for name in ("detected", "top", "in_class", "place_top", "place_in_class")}
        | {name: [0] for name in ("strong", "strong_in_class", "wrong_names")}
        | {"recovered": [np.nan], "seconds": [1.0]}
    )
    lines = author_lines(scores, pd.DataFrame({"covered": []}), pd.DataFrame({"weight": [], "right": []}))
    assert {line.quantity: line.value for line in lines}["false_alarms"] == 0.0
