"""The paper's task, which every tool gets: a PRBS into G0, seen by a camera, in noise of 10 dB (section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.excitation import pseudo_random_binary_sequence
from camid.chain.plant import TransferFunction
from camid.paper.cases import parameter_vector
from camid.paper.datasets import believed_plant, noise_level, with_closing_frame
from camid.simulation.yaml_file import read_yaml

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[1]
# Keys of the random streams: those of the benchmarks are apart from all others of the seed.
BENCHMARKS, IDENTIFICATION, SCALING, MEASUREMENT = 9000, 0, 1, 2
# The nominal plant of a warm start: each coefficient 10 % off, in the direction that moves mode and damping most.
NOMINAL_FACTORS = np.array([1.1, 1.1, 0.9])


@dataclass(frozen=True)
class Recording:
    """Data of one identification.

    Attributes
    ----------
    signal, output : ndarray, shape (N + 1,)
        Input u_k and noisy camera output w_k; the last input is the zero that closes the last frame, so that there are
        N pairs of u_k and w_{k+1}.
    period : float
        Seconds.
    noise_variance : float
        Of the output noise.
    """

    signal: Array
    output: Array
    period: float
    noise_variance: float

    def pairs(self) -> tuple[Array, Array]:
        """u_k and w_{k+1}, shape (N,) each, which are those of a first-order hold and an instant sensor."""
        return self.signal[:-1], self.output[1:]


@cache
def configuration() -> dict[str, Any]:
    """Content of config/config.yaml."""
    return read_yaml(ROOT / "config" / "config.yaml")


def plant() -> TransferFunction:
    """G0 of equation (15)."""
    return believed_plant(configuration()["plant"])


def truth() -> Array:
    """[b0, a1, a0] of G0."""
    return parameter_vector(plant().numerator, plant().denominator)


def nominal() -> Array:
    """[b0, a1, a0] of the believed plant of a warm start, 10 % off."""
    return NOMINAL_FACTORS * truth()


def generator(*key: int) -> np.random.Generator:
    """Random stream of the configured seed with this key."""
    return np.random.default_rng(np.random.SeedSequence(configuration()["seed"], spawn_key=(BENCHMARKS, *key)))


def excitation(length: int | None = None) -> Array:
    """The paper's PRBS, or the first ``length`` samples of the shortest PRBS long enough; a closing zero is added."""
    section = configuration()["excitation"]
    order = section["order"] if length is None else int(length).bit_length()
    return with_closing_frame(pseudo_random_binary_sequence(order, amplitude=section["amplitude"])[:length])


def record(signal: Array, period: float, noise: np.random.Generator | None) -> Recording:
    """Camera output of G0 with noise of the configured signal-to-noise ratio, or without."""
    clean = sample(plant(), signal, Acquisition(period))
    sweep = configuration()["sampling_period_sweep"]
    level = noise_level(clean, sweep["signal_to_noise_ratio"], sweep["ratio_of"]) if noise is not None else 0.0
    output = clean if noise is None else clean + level * noise.standard_normal(len(clean))
    return Recording(signal, output, period, level**2)
