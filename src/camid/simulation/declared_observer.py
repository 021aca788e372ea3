"""The observer that a simulation file declares."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from camid.chain.observer import Observer, acceleration_of
from camid.errors import InputError
from camid.simulation.schema import SimulationFile
from camid.simulation.yaml_file import Where


def declared_observer(file: SimulationFile, plant: Mapping[str, Any], where: Where) -> Observer | None:
    """The observer of a file, if there is one.

    Raises
    ------
    InputError
        If the simulation cannot have one, or the plant runs away with it all the same.
    """
    if file.observer is None:
        return None
    if file.controller is not None:
        raise InputError(
            "a controller is declared, and holds the plant as the real one does",
            where=where("observer"),
            hint="remove the observer, or the controller",
        )
    if file.input is None:
        raise InputError(
            "without input there is no controller that holds the plant", where=where("observer"), hint="remove it"
        )
    physical = plant.get("physical")
    if "pendulum" in plant or (physical is not None and physical.equations is not None):
        raise InputError(
            "an observer pulls a plant that is linear but for its effects",
            where=where("observer"),
            hint="write the plant as a transfer function, and what bends it among the effects",
        )
    acceleration = acceleration_of(plant["plant"])
    if acceleration is None:
        raise InputError(
            "an observer accelerates the plant, which its input does not where it has not two poles more than zeros",
            where=where("observer"),
            hint="remove it, or declare the controller",
        )
    observer = Observer(file.observer.rate, acceleration if file.observer.gain is None else file.observer.gain)
    if observer.gain * acceleration <= 0.0 or not observer.holds(plant["plant"]):
        raise InputError(
            "the plant runs away from the recording in spite of this observer",
            where=where("observer"),
            hint="take a rate above that of the fastest pole in the right half plane, and leave out the gain",
        )
    return observer
