"""What follows from its own past nearly to the last is a motion, whatever colour a noise may have."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from camid.diagnosis.residual import residual_structure
from camid.diagnosis.residual.residual_structure import reasons_for_structure

ROWS = 2000


def reasons(monkeypatch, pole, *, effects=("quadratic-drag",), p_value=1e-3):
    """Of an autoregression of first order that a model of effects leaves, with tests of places that hint at more."""
    for name in ("_larger_on_validation_rows", "force_like"):
        monkeypatch.setattr(residual_structure, name, lambda *arguments: False)
    monkeypatch.setattr(residual_structure, "depends_on_position", lambda *arguments: 1.0)
    shocks = np.random.default_rng(4).standard_normal(ROWS)
    residual = lfilter([1.0], [1.0, -pole], shocks)
    problem = SimpleNamespace(whitened=lambda values, whitening: shocks, recorded=1e3 * np.arange(ROWS))
    final = SimpleNamespace(
        cost=float(residual @ residual),
        residual=residual,
        noise=SimpleNamespace(whitening=np.array([1.0, -pole])),
        model=SimpleNamespace(effects=effects),
    )
    places = [SimpleNamespace(place="plant", p_value=p_value)]
    return reasons_for_structure(problem, final, places, [], {"coloured-noise"}, None)


@pytest.mark.parametrize(
    ("pole", "options", "smooth"),
    [
        (0.995, {}, True),
        (0.9, {}, False),  # the colour of a noise
        (0.995, {"effects": ()}, False),  # nothing is named whose law may be inexact
        (0.995, {"p_value": 0.2}, False),  # and nothing tells where it sits
    ],
)
def test_colour_is_no_noise_where_hardly_anything_in_it_is_new(monkeypatch, pole, options, smooth):
    assert ("smooth" in reasons(monkeypatch, pole, **options)) == smooth
