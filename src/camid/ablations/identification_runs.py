"""What the ablations of identification have in common: the paper's data, percent and noise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.excitation import pseudo_random_binary_sequence
from camid.chain.plant import TransferFunction
from camid.identification.accuracy import cramer_rao_bound
from camid.identification.experiment import Experiment
from camid.paper.cases import PARAMETERS, parameter_vector
from camid.paper.datasets import with_closing_frame

Array = NDArray[np.float64]

# Errors below this many percent are rounding and the stopping rule, not bias.
NO_BIAS = 1e-6


def excitation_signal(excitation: Mapping[str, Any]) -> Array:
    """The paper's PRBS with its closing frame, from the section ``excitation`` of the configuration."""
    return with_closing_frame(
        pseudo_random_binary_sequence(excitation["order"], amplitude=float(excitation["amplitude"]))
    )


def whole_experiment(signal: Array, output: Array, acquisition: Acquisition) -> Experiment:
    """A record that starts at rest and is fitted in every row."""
    return Experiment(signal, output, acquisition, np.ones(len(output), bool))


def percent_errors(estimated: TransferFunction, truth: TransferFunction) -> Array:
    """Errors of b0, a1 and a0 in percent of the true values, shape (3,)."""
    found, true = (parameter_vector(p.monic.numerator, p.monic.denominator) for p in (estimated, truth))
    return 100.0 * (found / true - 1.0)


def percent_bound(
    truth: TransferFunction,
    signal: Array,
    acquisition: Acquisition,
    noise_variance: float,
    *,
    estimate_initial_state: bool = False,
) -> Array:
    """Cramér–Rao bound on the covariance of the errors in percent of b0, a1 and a0, shape (3, 3)."""
    bound = cramer_rao_bound(truth, signal, acquisition, noise_variance, estimate_initial_state=estimate_initial_state)
    scale = 100.0 / parameter_vector(truth.monic.numerator, truth.monic.denominator)
    return bound * np.outer(scale, scale)


def by_parameter(name: str, values: Array) -> dict[str, float]:
    """Columns ``<name>_b0``, ``<name>_a1`` and ``<name>_a0`` of a row."""
    return {f"{name}_{p}": float(v) for p, v in zip(PARAMETERS, values, strict=True)}


def unit_noise(length: int, seed: int, *stream: int) -> Array:
    """White Gaussian noise of unit variance from a stream of its own: ``SeedSequence(seed, spawn_key=stream)``."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=stream)).standard_normal(length)
