"""Models as people name them: simulation files, simulations, systems of python-control and results of camid."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from camid.errors import InputError
from camid.simulation.control_systems import continuous_plant, is_control_system
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

ModelSource = str | os.PathLike[str] | Mapping[str, Any] | Simulation | Any
# More lines than these are not told apart in one picture.
MOST_MODELS = 6
IDENTIFIED, IMPROVED = "identified", "improved"


def named_models(sources: Sequence[ModelSource], *, plants_alone: bool = False) -> dict[str, Simulation]:
    """The simulations that models are, by the name that a legend shows.

    Parameters
    ----------
    sources : sequence
        Paths, mappings, simulations, what ``camid.identify`` or ``camid.diagnose`` returned.
    plants_alone : bool
        Whether a continuous-time system of python-control is a model, too: it says nothing of input and sensor.

    Raises
    ------
    InputError
        If a file is none, a model is named twice, or there are none or too many.
    """
    if not sources:
        raise InputError("no model is given", hint="name at least one simulation file")
    if len(sources) > MOST_MODELS:
        raise InputError(f"{len(sources)} models", hint=f"at most {MOST_MODELS} are told apart in one picture")
    paths = [os.path.realpath(source) for source in sources if isinstance(source, str | os.PathLike)]
    if len(set(paths)) < len(paths):
        raise InputError("the same model is named twice", where=str(sources[0]), hint="leave it out once")
    found = [_named(source, number, plants_alone) for number, source in enumerate(sources, 1)]
    short = [name for name, _, _ in found]
    # Two files of one name are told apart by their folders.
    unique = [full if short.count(name) > 1 else name for name, full, _ in found]
    return {
        name if unique.count(name) == 1 else f"{name} ({number})": simulation
        for number, (name, (_, _, simulation)) in enumerate(zip(unique, found, strict=True), 1)
    }


def _named(source: ModelSource, number: int, plants_alone: bool) -> tuple[str, str, Simulation]:
    """Short and full name, and the simulation."""
    if isinstance(source, str | os.PathLike):
        return Path(source).name, str(source), load_simulation(source)
    for attribute, name in (("simulation", IDENTIFIED), ("improved", IMPROVED)):
        if isinstance(held := getattr(source, attribute, None), Simulation):
            return name, name, held
    name = f"model {number}"
    if plants_alone and is_control_system(source):
        plant = continuous_plant(source, name)
        return name, name, Simulation("t", "u", "y", plant, sensor="instant", source=name)
    if not (isinstance(source, Mapping | Simulation) or is_control_system(source)):
        raise InputError(
            f"a {type(source).__name__} is not a model",
            where=name,
            hint="give a simulation (a path, a mapping) or what camid.identify or camid.diagnose returned",
        )
    simulation = load_simulation(source)
    if simulation.source in {"simulation", "options"}:
        return name, name, replace(simulation, source=name)
    return Path(simulation.source).name, simulation.source, simulation
