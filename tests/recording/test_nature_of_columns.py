"""What columns look like, what an error offers, and scatter of the times."""

import re

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camid.recording.nature import nature_of, quantisation_step
from tests.support.recordings import T, U, Y, read, refusal

# What an error offers, and what columns look like


def test_an_error_offers_the_columns_that_would_do():
    table = pd.DataFrame({"clock": T, "volts": U, "angle": Y, "note": "a"})
    assert "columns that would do as the time: clock (a clock, steps of 0.02)" in refusal(table)
    assert "columns that would do as the input: volts (held, 2 levels), angle" in refusal(table, time="clock")
    said = refusal(table, time="clock", columns=("volts", "y"), holds=("volts",))
    assert "columns that would do as the output: angle (smooth)" in said
    assert "note" not in said.partition("would do")[2]


def test_natures():
    generator = np.random.default_rng(1)
    assert nature_of(T).kind == "clock"
    assert nature_of(np.delete(T, [5, 20])).period == pytest.approx(0.02)
    assert nature_of(np.ones(9)).kind == "constant"
    assert nature_of(U).kind == "held"
    assert nature_of(np.repeat(generator.normal(size=20), 5)).kind == "held"
    assert nature_of(generator.normal(size=500)).kind == "rough"
    swing = np.sin(0.05 * np.arange(2000))
    assert nature_of(swing).kind == "smooth"
    encoder = nature_of(0.05 * np.round(swing / 0.05))
    assert encoder.kind == "smooth"  # a slow encoder repeats its readings and is no command
    assert encoder.step == pytest.approx(0.05)
    assert nature_of(np.array([np.nan, 1.0])) is None


@given(st.floats(1e-6, 1e6), st.floats(-1e3, 1e3), st.integers(0, 100))
@settings(max_examples=50, deadline=None)
def test_the_step_of_an_encoder_is_found_in_any_unit(step, offset, seed):
    counts = np.cumsum(np.random.default_rng(seed).integers(-1, 2, 1000))
    assert quantisation_step(step * (counts + offset)) == pytest.approx(step, rel=1e-3)
    assert quantisation_step(np.random.default_rng(seed).normal(size=1000)) is None


# Scatter of the times


@pytest.mark.parametrize(("scatter", "said"), [(2e-5, False), (0.2, True)])
def test_scatter_of_the_times_is_told_by_its_size_where_it_matters(scatter, said):
    generator = np.random.default_rng(5)
    time = 0.01 * (np.arange(500) + scatter * generator.uniform(-1.0, 1.0, 500))
    output = np.round(np.sin(2.0 * time), 3)
    (found,) = read(pd.DataFrame({"t": time, "y": output}), columns=("y",), holds=())
    assert any("off a regular grid of 10" in w for w in found.warnings) is said
    assert not any("100 %" in w for w in found.warnings)
    if said:
        size = re.search(r"by (\S+) ms RMS and at most \S+ ms \((\d+) % of the period\)", found.warnings[0])
        assert float(size[1]) == pytest.approx(2.0 / np.sqrt(3.0), rel=0.1)
        assert int(size[2]) == pytest.approx(20, abs=2)
