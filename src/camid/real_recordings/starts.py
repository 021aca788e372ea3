"""Whether a diagnosis depends on its start: one recording, and nominal plants that are off by up to a half."""

from __future__ import annotations

import time
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from ruamel.yaml import YAML

from camid.commands.diagnose import diagnose

Array = NDArray[np.float64]

# Largest change of natural frequencies, damping ratios, real poles and the static gain, as a share.
SPREAD = 0.5


def first_names(recording: str | Path, simulation: str | Path, draws: int, seed: int) -> pd.DataFrame:
    """Diagnose a recording from several nominal plants.

    Parameters
    ----------
    recording, simulation : path
    draws : int
    seed : int

    Returns
    -------
    DataFrame
        One row per draw: ``draw``, ``verdict``, ``first`` (the first effect named, or nothing), ``error`` (on rows that
        were not fitted, over the standard deviation of the output), ``seconds``.
    """
    content = YAML(typ="safe").load(Path(simulation))
    rows = []
    for draw, believed in enumerate(nominal_draws(content, draws, seed)):
        started = time.perf_counter()
        diagnosis = diagnose(recording, believed, time_limit=None)
        rows.append(
            {
                "draw": draw,
                "verdict": diagnosis.verdict,
                "first": diagnosis.findings[0].identifier if diagnosis.findings else "",
                "error": diagnosis.fit.improved,
                "seconds": time.perf_counter() - started,
            }
        )
    return pd.DataFrame(rows, columns=["draw", "verdict", "first", "error", "seconds"])


def nominal_draws(content: dict[str, Any], draws: int, seed: int) -> Iterator[dict[str, Any]]:
    """Simulations whose nominal plant is another one, with everything else as it is.

    Parameters
    ----------
    content : dict
        Of a simulation file.
    draws, seed : int
    """
    random = np.random.default_rng(np.random.SeedSequence([seed, draws]))
    for _ in range(draws):
        changed = deepcopy(content)
        plant = changed["plant"]
        if "pendulum" in plant:
            for key in {"natural_frequency", "damping"} & set(plant["pendulum"]):
                plant["pendulum"][key] *= float(random.uniform(1.0 - SPREAD, 1.0 + SPREAD))
        else:
            function = plant["transfer_function"]
            numerator, denominator = (np.asarray(function[part], float) for part in ("numerator", "denominator"))
            moved = _moved(denominator, random)
            # An integrator has no static gain; its numerator is drawn alone.
            gain = moved[-1] / denominator[-1] if denominator[-1] else 1.0
            function["denominator"] = moved.tolist()
            function["numerator"] = (gain * random.uniform(1.0 - SPREAD, 1.0 + SPREAD) * numerator).tolist()
        yield changed


def _moved(denominator: Array, random: np.random.Generator) -> Array:
    """Polynomial, descending powers, with each pole's frequency and damping ratio times a factor of its own."""
    poles = np.roots(denominator)
    polynomial = denominator[:1]
    for pole in sorted(poles[poles.imag >= 0.0], key=abs):
        size = abs(pole) * random.uniform(1.0 - SPREAD, 1.0 + SPREAD)
        if pole.imag == 0.0:
            polynomial = np.polymul(polynomial, [1.0, -np.sign(pole.real) * size])
        else:
            ratio = min(-pole.real / abs(pole) * random.uniform(1.0 - SPREAD, 1.0 + SPREAD), 1.0)
            polynomial = np.polymul(polynomial, [1.0, 2.0 * ratio * size, size**2])
    return np.asarray(polynomial)
