"""What comes first of several findings, and what is said of one that sets in where nothing was recorded."""

from types import SimpleNamespace

import numpy as np
import pytest

import camid
from camid.diagnosis.finding import ParameterEstimate
from camid.diagnosis.moments_in_gaps import moments_in_gaps
from camid.diagnosis.report.page import render
from camid.diagnosis.verdict import _evidence
from tests.support import written_diagnoses
from tests.support.mass_on_spring import PERIOD, effect, record, simulation


@pytest.mark.slow
def test_what_costs_most_to_leave_out_comes_first_and_the_largest_share_is_the_place():
    """An impulse takes most of the error in the rows that were fitted, and less in those that were not."""
    table = record(effect("impulse-disturbance", size=0.08, time=3.01), effect("coulomb-friction", force=0.1))
    diagnosis = camid.diagnose(table, simulation())
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction", "impulse-disturbance"]
    without = [f.evidence["nrmse_without"] for f in diagnosis.findings]
    assert without == sorted(without, reverse=True)
    places = diagnosis.location.places
    assert diagnosis.location.place == "disturbance" == max(places, key=lambda place: places[place])
    page = render(diagnosis)
    assert "<p>At the <strong>disturbance</strong>.</p>" in page
    assert page.count("▲ here") == 1


def ranked(name, beyond):
    return SimpleNamespace(identifier=name, fitted=None, penalty=0.0, beyond=lambda lead: beyond)


def test_what_is_worse_than_nothing_is_no_next_best(monkeypatch):
    monkeypatch.setattr("camid.diagnosis.verdict.p_value", lambda *_: 0.0)
    without = SimpleNamespace(criterion_beyond=lambda fitted: 1750.0)
    lead = effect("coulomb-friction", force=1.0)
    for beyond, named in ((1920.0, None), (1700.0, "hysteresis")):
        rivals = [[ranked(lead.identifier, 0.0), ranked("hysteresis", beyond)]]
        decision = SimpleNamespace(rivals=rivals, without=[without], fitted=None)
        evidence = _evidence(None, decision, 0, lead, [0.1, 0.05])
        assert evidence["next_best"] == named
        assert (evidence["delta_bic_to_next_best"] is None) == (named is None)


def test_an_impulse_in_a_gap_is_said_to_be_there():
    time = PERIOD * np.arange(100)
    missing = (time > 0.99) & (time < 1.21)
    recording = SimpleNamespace(source="run.csv", time=time, missing=missing)
    finding = written_diagnoses.finding()
    impulse = SimpleNamespace(
        identifier="impulse-disturbance",
        title="Impulse disturbance",
        parameters={"time": ParameterEstimate(1.1, 0.01, "s")},
    )
    beside = SimpleNamespace(**{**vars(impulse), "parameters": {"time": ParameterEstimate(0.5, 0.01, "s")}})
    assert moments_in_gaps([finding, beside], [recording]) == []
    (said,) = moments_in_gaps([finding, impulse], [recording])
    assert said.startswith("run.csv: the time of impulse disturbance, 1.1 s, lies in a gap of the recording (0.98 to")
