"""The simulation with what was found: re-estimated plant, corrected declarations, effects, and what is left."""

from __future__ import annotations

from dataclasses import replace

from camid.chain.acquisition import Acquisition
from camid.diagnosis.diagnose import Outcome
from camid.effects.declared import declared
from camid.fitting.estimated_simulation import with_plant
from camid.identification.structure import Structure
from camid.simulation.model import Simulation

# Effects that a simulation declares in other words.
DECLARATIONS = ("input-hold", "exposure", "delay")


def improved(believed: Simulation, structure: Structure, outcome: Outcome, declared_as: Acquisition) -> Simulation:
    """The simulation with what a diagnosis found.

    What was declared rightly stays as it was written, an exposure left out included.
    """
    acquisition = outcome.acquisition
    exposure = believed.exposure if acquisition.exposure == declared_as.exposure else acquisition.exposure
    kept = [i for i, e in enumerate(outcome.effects) if e.identifier not in DECLARATIONS]
    return replace(
        with_plant(believed, structure, outcome.decision.fitted),
        hold=acquisition.hold,
        sensor=acquisition.sensor,
        exposure=exposure if acquisition.sensor == "camera" else None,
        latency=acquisition.latency,
        effects=declared([outcome.effects[i] for i in kept], [outcome.deviations[i] for i in kept]),
        remainder=_remainder(believed, outcome),
    )


def _remainder(believed: Simulation, outcome: Outcome) -> float | None:
    """What is left unexplained: told in the file, so that the next diagnosis asks for what is beyond it."""
    if outcome.verdict == "adequate":
        return believed.remainder
    if outcome.verdict == "explained":
        return None
    return outcome.left
