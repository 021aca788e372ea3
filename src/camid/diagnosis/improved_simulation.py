"""The simulation with what was found: re-estimated plant, corrected declarations, effects, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import Effect
from camid.effects.declared import declared
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem
from camid.simulation.model import Simulation

Deviations = dict[str, Any]


def improved_simulation(
    believed: Simulation,
    problem: Problem,
    fitted: Fitted,
    effects: Sequence[tuple[Effect, Deviations]],
    remainder: float | None,
) -> Simulation:
    """The simulation with what a diagnosis found.

    What was declared rightly stays as it was written, an exposure left out included.

    Parameters
    ----------
    believed : Simulation
    problem : Problem
    fitted : Fitted
        The improved model.
    effects : sequence of (Effect, dict)
        Its effects and those on the noise, with the standard deviations of their parameters.
    remainder : float, optional
        Root mean square of what is left unexplained, which the next diagnosis does not look into again.
    """
    as_declared, acquisition = problem.acquisition, problem.chain(fitted.model, 0).declared()
    exposure = believed.exposure if acquisition.exposure == as_declared.exposure else acquisition.exposure
    kept = [(effect, deviations) for effect, deviations in effects if not effect.corrects_declaration]
    return replace(
        problem.kind.written_back(believed, problem.structure, fitted),
        hold=acquisition.hold,
        sensor=acquisition.sensor,
        exposure=exposure if acquisition.sensor == "camera" else None,
        latency=acquisition.latency,
        effects=declared([e for e, _ in kept], [d for _, d in kept]),
        remainder=remainder,
    )


def remainder_of(
    modelled: bool,
    structured: bool,
    believed: Simulation,
    problem: Problem,
    final: Fitted,
    validation: Sequence[NDArray[np.bool_]],
) -> float | None:
    """What the improved simulation says is left unexplained: root mean square, on fitted or validation rows.

    ``modelled`` says whether anything is, with or without a name, and ``structured`` whether all that is leaves more
    than noise.
    """
    if not structured:
        return None if modelled else believed.remainder
    simulated = problem.simulate(final.model)
    held_out = np.concatenate(
        [(e.output - s)[r] for e, s, r in zip(problem.experiments, simulated, validation, strict=True)]
    )
    return float(np.sqrt(max(np.mean(problem.in_units(final.residual) ** 2), np.mean(held_out**2))))
