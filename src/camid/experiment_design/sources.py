"""What a design starts from: a diagnosis, or simulations that are held against each other."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.remaining_hypotheses import conditions_of, information_of
from camid.diagnosis.weights import Member, relative_weight
from camid.effects.declared import effects_of
from camid.errors import InputError
from camid.experiment_design.columns import Columns
from camid.experiment_design.earlier_recordings import of_diagnosis, of_files, of_problem
from camid.experiment_design.hypothesis import GIVEN, Hypothesis, Played, hypothesis_of
from camid.experiment_design.limits import Limits
from camid.experiment_design.prediction import NoiseModel, travelled
from camid.experiment_design.sums import without_sums
from camid.experiment_design.together import Earlier
from camid.fitting.fit import Fitted
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import RecordingSource, experiments_of
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

DIAGNOSIS = "diagnosis.json"
# Version of diagnosis.json that is read.
SCHEMA = 1
# Names that weigh less are not designed for: all that a diagnosis lists.
LEAST_WEIGHT = 0.01
# How far the travel may reach beyond that of the recordings where nothing is said, as a share of it.
BEYOND = 0.1
# Rows that show where a rig rests.
STILL_ROWS = 10


@dataclass(frozen=True)
class Known:
    """What is known before a design.

    Attributes
    ----------
    hypotheses : list of Hypothesis
    noise : float or None
        Standard deviation in units of y; None where nothing is known of it.
    whitening : ndarray
    rows, experiments : int
        Rows that were fitted, and different inputs.
    conditions : dict
        How the recordings were made, as in diagnosis.json; empty where there are none.
    source : str
    warnings : tuple of str
        What a design cannot take into account.
    earlier : Earlier or None
        The recordings that were diagnosed; None where only what hypotheses know of them is known.
    """

    hypotheses: list[Hypothesis]
    noise: float | None
    whitening: Array
    rows: int
    experiments: int
    conditions: Mapping[str, Any]
    source: str
    warnings: tuple[str, ...] = ()
    earlier: Earlier | None = None

    @property
    def columns(self) -> Columns:
        """Of the rig's files."""
        return Columns.of(self.hypotheses[0].simulation)


def known_from_folder(folder: Path, recordings: Sequence[RecordingSource] = ()) -> Known:
    """What the folder of a diagnosis says, or its diagnosis.json.

    With the ``recordings`` that were diagnosed they are known as well, and not only what the hypotheses know of them.

    Raises
    ------
    InputError
        If these are others, or there is no diagnosis, one of a version that is not known, or one without the remaining
        hypotheses, as the first ones of version 1 were.
    """
    path = folder / DIAGNOSIS if folder.is_dir() else folder
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(
            f"no {DIAGNOSIS}", where=str(folder), hint="name the output folder of camid diagnose, or simulations"
        ) from None
    except (ValueError, UnicodeError) as error:
        raise InputError(f"this is no JSON ({error})", where=str(path), hint="diagnose again") from None
    if isinstance(content, dict) and content.get("schema") != SCHEMA:
        raise InputError(
            f"version {content.get('schema')!r} is not known",
            where=str(path),
            hint=f"this camid reads schema: {SCHEMA}; diagnose again",
        )
    if not isinstance(content, dict) or not content.get("hypotheses") or not content.get("conditions"):
        raise InputError(
            "it does not hold the simulations of the remaining hypotheses", where=str(path), hint="diagnose again"
        )
    try:
        known = known_from_mapping(content, str(folder))
        if not recordings or not known.noise:
            return known
        simulation = load_simulation(content["hypotheses"][0]["simulation"])
        noise, period = NoiseModel(known.noise, known.whitening), float(known.conditions["period"])
        return replace(known, earlier=of_files(path.parent, recordings, simulation, noise, period))
    except (KeyError, TypeError) as error:
        raise InputError(f"{error} is missing or of another kind", where=str(path), hint="diagnose again") from None


def known_from_diagnosis(diagnosis: Diagnosis) -> Known:
    """What a diagnosis says, and the recordings that it was made of."""
    known = known_from_mapping(diagnosis.to_mapping(), "diagnosis")
    if not known.noise:
        return known
    noise = NoiseModel(known.noise, known.whitening)
    return replace(known, earlier=of_diagnosis(diagnosis, noise, float(known.conditions["period"])))


def known_from_mapping(content: Mapping[str, Any], source: str) -> Known:
    """The same from what diagnosis.json holds."""
    conditions = content["conditions"]
    period = float(conditions["period"])
    every = _merged(content["hypotheses"])
    named = [h for h in every if h["id"] is not None]
    kept = [h for h in named if h["weight"] >= LEAST_WEIGHT] or named[:1]
    questions = {h["instead_of"] for h in kept}
    kept += [h for h in every if h["id"] is None and h["instead_of"] in questions]
    hypotheses = [
        hypothesis_of(
            replace(load_simulation(h["simulation"]), source=source),
            h["id"] or "",
            period,
            weight=float(h["weight"]),
            question=h["instead_of"],
            parameters=list(h["parameters"]),
            information=np.array(h["information"], float),
            criterion=float(h["criterion"]),
            misfit=float(h["misfit"]),
        )
        for h in kept
    ]
    noise = conditions["noise"]
    return Known(
        without_sums(hypotheses),
        float(noise["standard_deviation"]),
        np.array(noise["whitening"], float),
        int(conditions["rows"]),
        int(conditions["experiments"]),
        conditions,
        source,
        _unlisted_law(content["effects"]),
    )


def _merged(every: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The hypotheses of a diagnosis, a name that stands there twice once: with the better of both and their weights."""
    found: dict[tuple[str | None, str], Mapping[str, Any]] = {}
    for one in every:
        key = one["id"], one["instead_of"]
        same = [one] if key not in found else [found[key], one]
        better = min(same, key=lambda h: float(h["criterion"]))
        found[key] = {**better, "weight": sum(float(h["weight"]) for h in same)}
    return list(found.values())


def _unlisted_law(effects: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """A sentence where a diagnosis holds a law without a name, which has no rival that could be simulated."""
    if not any(str(effect["id"]).startswith("learned-") for effect in effects):
        return ()
    return (
        "the diagnosis holds a law without a name: nothing is designed to tell it from names, and what is predicted is "
        "without it",
    )


def known_from_simulations(
    sources: Sequence[Any], recordings: Sequence[RecordingSource], period: float | None
) -> Known:
    """Simulations as hypotheses; with recordings of the rig each is fitted to them first.

    Raises
    ------
    InputError
        If two have one name, or the period of the frames is not known.
    """
    simulations = [load_simulation(source) for source in sources]
    names = [
        Path(source).name if isinstance(source, str | Path) else f"simulation {i}"
        for i, source in enumerate(sources, 1)
    ]
    if len(set(names)) < len(names):
        names = [s.source for s in simulations]
    if len(set(names)) < len(names):
        raise InputError("the same simulation is named twice", where=names[0], hint="name different ones")
    source = ", ".join(names)
    if not recordings:
        if period is None:
            raise InputError(
                "the frame rate is not known", where=source, hint="say --frame-rate, or --recording with a recording"
            )
        kept = [
            hypothesis_of(s, name, period, weight=1.0 / len(names), question=GIVEN)
            for s, name in zip(simulations, names, strict=True)
        ]
        _refuse_one_structure(kept)
        return Known(kept, None, np.ones(1), 0, 0, {}, source)
    fits = [_fitted(simulation, recordings) for simulation in simulations]
    best = min(fits, key=lambda fitted: fitted.cost)
    conditions = conditions_of(best.problem, best)
    gaps = [fitted.criterion_beyond(best) for fitted in fits]
    weights = np.array([relative_weight(Member("", gap, 0.0)) for gap in gaps])
    hypotheses = []
    for simulation, name, fitted, gap, weight in zip(
        simulations, names, fits, gaps, weights / weights.sum(), strict=True
    ):
        parameters, information = information_of(fitted, conditions)
        misfit = (fitted.cost - best.cost) / (conditions.noise**2 or 1.0)
        found = hypothesis_of(
            simulation,
            name,
            conditions.period,
            weight=float(weight),
            question=GIVEN,
            parameters=parameters,
            information=information,
            criterion=float(gap),
            misfit=misfit,
        )
        hypotheses.append(replace(found, model=replace(fitted.model, initial=(None,))))
    _refuse_one_structure(hypotheses)
    noise, whitening = conditions.noise, np.array(conditions.whitening)
    rows, experiments = conditions.rows, conditions.experiments
    earlier = of_problem(best.problem, NoiseModel(noise, whitening)) if noise > 0.0 else None
    return Known(hypotheses, noise, whitening, rows, experiments, conditions.to_mapping(), source, earlier=earlier)


def _refuse_one_structure(hypotheses: Sequence[Hypothesis]) -> None:
    """Refuse simulations that differ in the values of what is fitted alone: any recording makes them the same.

    Raises
    ------
    InputError
        If two have one structure.
    """
    for i, one in enumerate(hypotheses):
        for other in hypotheses[:i]:
            if one.structure == other.structure:
                raise InputError(
                    f"{other.identifier} and {one.identifier} are the same law with other values, which every "
                    f"recording decides",
                    where=one.simulation.source,
                    hint="name one of them, and its coefficients are determined",
                )


def _fitted(simulation: Simulation, recordings: Sequence[RecordingSource]) -> Fitted:
    """A simulation fitted to recordings."""
    found, experiments, _ = experiments_of(list(recordings), simulation, None)
    problem = problem_of(simulation, structure_of(simulation), found, experiments)
    effects = tuple(e for e in effects_of(simulation) if not e.noise_like)
    return problem.kind.refit(problem, problem.with_initial_states(model_of(problem, effects)))


@dataclass(frozen=True)
class Wishes:
    """Limits as a user states them, in the units of the rig's files; None: as in the recordings.

    Attributes
    ----------
    amplitude, travel : tuple of float or None
    rate, duration, noise : float or None
    frame_rates, exposures, positions : tuple of float
        What can be changed beside the input: frames per second, seconds, readings of the sensor.
    """

    amplitude: tuple[float, float] | None = None
    rate: float | None = None
    duration: float | None = None
    travel: tuple[float, float] | None = None
    frame_rates: tuple[float, ...] = ()
    exposures: tuple[float, ...] = ()
    positions: tuple[float, ...] = ()
    noise: float | None = None


def limits_of(known: Known, wishes: Wishes) -> Limits:
    """Limits in the units of the simulation: as they are wished for, and otherwise those of the recordings.

    Raises
    ------
    InputError
        If one is neither wished for nor known, or cannot be kept.
    """
    columns, conditions = known.columns, known.conditions
    for name, wish in (("amplitude", wishes.amplitude), ("duration", wishes.duration), ("noise", wishes.noise)):
        if wish is None and not conditions:
            raise InputError(
                f"the {name} is not known", where=known.source, hint=f"say --{name}, or --recording with a recording"
            )
    signal = conditions.get("input", {})
    amplitude = (
        (signal["low"], signal["high"]) if wishes.amplitude is None else columns.inputs.values_of(wishes.amplitude)
    )
    if wishes.rate is not None:
        rate = abs(columns.inputs.factor) * wishes.rate
    else:
        rate = signal["largest_step"] / conditions["period"] if conditions else inf
    periods = tuple(1.0 / f for f in wishes.frame_rates if f > 0.0) or (
        (float(conditions["period"]),) if conditions and not wishes.frame_rates else ()
    )
    return Limits(
        amplitude[0],
        amplitude[1],
        rate,
        conditions["duration"] if wishes.duration is None else wishes.duration,
        periods,
        wishes.exposures,
        _travel(known, wishes),
        tuple(columns.outputs.value(p) for p in wishes.positions),
        columns,
        known.source or None,
    )


def _travel(known: Known, wishes: Wishes) -> tuple[float, float] | None:
    if wishes.travel is not None:
        return known.columns.outputs.values_of(wishes.travel)
    if not known.conditions:
        return None
    output = known.conditions["output"]
    # An experiment begins where the rig rests, which a recording in motion need not have reached.
    still = Played(np.zeros(STILL_ROWS), float(known.conditions["period"]))
    rests = [r for h in known.hypotheses for r in travelled(h, still) if isfinite(r)]
    low, high = min([output["low"], *rests]), max([output["high"], *rests])
    more = BEYOND * (high - low)
    return low - more, high + more


def noise_of(known: Known, wishes: Wishes) -> NoiseModel:
    """Noise as it is wished for, or as the recordings had it.

    Raises
    ------
    InputError
        If it is not positive.
    """
    if wishes.noise is None:
        return NoiseModel(float(known.noise or 0.0) or _tiny(known), known.whitening)
    if not 0.0 < wishes.noise < inf:
        raise InputError(f"noise {wishes.noise:g}", hint="give the standard deviation of a reading, above zero")
    return NoiseModel(abs(known.columns.outputs.factor) * wishes.noise, np.ones(1))


def _tiny(known: Known) -> float:
    """Noise of a recording that a model explains to the last digit."""
    output = known.conditions["output"]
    return float(1e-6 * (output["high"] - output["low"]) or 1e-9)
