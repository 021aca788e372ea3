"""The deviation of an onset where the likelihood has several maxima, and where it has one."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.fitting import likelihood_profile, onset_profile


class Onset:
    of_one_recording = True

    def __init__(self, time):
        self.values = {"time": time}

    def restarts(self, situation):
        return ()


@pytest.mark.parametrize(("maxima", "expected"), [((0.0,), 0.1), ((0.0, 0.8), 0.8 / np.sqrt(2.0))])
def test_an_onset_is_as_uncertain_as_its_likelihood_has_maxima(monkeypatch, maxima, expected):
    def fall(time):
        # Twice the fall of the log likelihood from equally high maxima, each a Gaussian of 0.1 s.
        return -2.0 * np.log(sum(np.exp(-0.5 * ((time - 5.0 - m) / 0.1) ** 2) for m in maxima))

    fitted = one_onset(fall)
    monkeypatch.setattr(likelihood_profile, "replace", lambda model, **new: new["effects"][0].values["time"])
    (found,) = onset_profile.onset_deviations(fitted, None).values()
    assert found == pytest.approx(expected, rel=0.08)


def one_onset(fall):
    rows = 100

    class Problem:
        fitted_runs = (0,)
        times = (np.linspace(0.0, 10.0, rows),)
        output = np.zeros(rows)

        def simulate_fitted(self, time):
            return np.full(rows, np.exp(0.5 * fall(time) / rows))

        def whitened(self, values, whitening):
            return values

        def situations(self, model):
            return SimpleNamespace(of=lambda kind: None)

    class Fitted:
        problem = Problem()
        nuisance, weighted = None, False
        residual = np.ones(rows)
        sensitivities = np.column_stack([np.zeros(rows), np.ones(rows)])
        covariance = np.diag([0.0, 0.01])
        inflation = staticmethod(lambda change: 1.0)

        class model:  # noqa: N801
            effects = (Onset(5.0),)

        class packing:  # noqa: N801
            names = ("gain", "0 time")

        class noise:  # noqa: N801
            whitening = np.ones(1)

    return Fitted()
