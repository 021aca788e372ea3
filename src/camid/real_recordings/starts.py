"""Whether a diagnosis depends on its start: other nominal plants, and other rows of the recording."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from ruamel.yaml import YAML

from camid.commands.diagnose import diagnose
from camid.diagnosis.diagnosis import Diagnosis

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
        One row per draw: ``draw``, ``verdict``, ``first`` (the first effect named, or nothing), ``value`` and
        ``deviation`` (its first parameter, with its standard deviation), ``error`` (on rows that were not fitted, over
        the standard deviation of the output), ``seconds``.
    """
    content = YAML(typ="safe").load(Path(simulation))
    return _diagnosed(recording, "draw", enumerate(nominal_draws(content, draws, seed)))


def names_by_first_row(recording: str | Path, simulation: str | Path, starts: Sequence[float]) -> pd.DataFrame:
    """Diagnose a recording from several of its rows on.

    Parameters
    ----------
    recording, simulation : path
    starts : sequence of float
        Times in s from which it is read.

    Returns
    -------
    DataFrame
        One row per start, as of :func:`first_names`, with ``start`` in the place of ``draw``.
    """
    content = YAML(typ="safe").load(Path(simulation))
    later = [{**content, "recording": {**content.get("recording", {}), "start": start}} for start in starts]
    return _diagnosed(recording, "start", zip(starts, later, strict=True))


def _diagnosed(recording: str | Path, key: str, cases: Iterable[tuple[float, dict[str, Any]]]) -> pd.DataFrame:
    rows = []
    for value, believed in cases:
        started = time.perf_counter()
        diagnosis = diagnose(recording, believed, time_limit=None)
        rows.append({key: value, **_said(diagnosis), "seconds": time.perf_counter() - started})
    return pd.DataFrame(rows, columns=[key, "verdict", "first", "value", "deviation", "error", "seconds"])


def _said(diagnosis: Diagnosis) -> dict[str, Any]:
    """Verdict, first name with its first number, and the error."""
    said: dict[str, Any] = {"verdict": diagnosis.verdict, "first": "", "error": diagnosis.fit.improved}
    if diagnosis.findings:
        first = diagnosis.findings[0]
        numbers = (p for p in first.parameters.values() if not isinstance(p.value, str))
        number = next(numbers, None)
        said["first"] = first.identifier
        if number is not None:
            said |= {"value": number.value, "deviation": number.standard_deviation}
    return said


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
