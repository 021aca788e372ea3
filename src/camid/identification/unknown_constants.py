"""Which constants are estimated beside a plant: the zero of the sensor and the bias of the input.

The zero of a camera is never the rest of the rig, so where a simulation says nothing the offset is unknown. A bias of
the input is an offset to every plant but one that integrates, for which it is a ramp. What cannot be told apart is not
estimated twice: the free motion of an integrator holds its offset, and a gain that only a constant input shows is one
with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from camid.effects.known import declarable_effects
from camid.identification.experiment import Experiment
from camid.simulation.model import Simulation


def with_unknown_constants(experiments: Sequence[Experiment], believed: Simulation) -> list[Experiment]:
    """The experiments of a rig with what is unknown of them beside the plant.

    Parameters
    ----------
    experiments : sequence of Experiment
    believed : Simulation
    """
    offset, bias = estimates_offset(experiments, believed), estimates_bias(believed)
    return [replace(e, estimate_offset=offset, estimate_bias=bias) for e in experiments]


def integrates(believed: Simulation) -> bool:
    """Whether the plant is known to have a pole at zero."""
    last = believed.plant.denominator[-1]
    return believed.plant.order > 0 and last == 0.0 and not believed.free_denominator[-1]


def why_no_offset(experiments: Sequence[Experiment], believed: Simulation) -> str | None:
    """Why a sensor's offset of which nothing is said is not estimated, in words; None where it is, or is declared."""
    if not _unsaid(believed, believed.offset) or believed.output_columns:
        return None
    if believed.estimates_initial_state and integrates(believed):
        return "the sensor's offset is not estimated: the plant integrates, and its initial state holds it"
    if believed.estimates_initial_state and _constant_input(experiments, believed):
        return "the sensor's offset is not estimated: the input is constant, and the gain may make up for it"
    return None


def estimates_offset(experiments: Sequence[Experiment], believed: Simulation) -> bool:
    """Whether the sensor's offset is estimated."""
    if believed.output_columns:  # constants of what they read
        return False
    return _unsaid(believed, believed.offset) and why_no_offset(experiments, believed) is None


def estimates_bias(believed: Simulation) -> bool:
    """Whether the input's bias is estimated."""
    if not _unsaid(believed, believed.bias) or believed.input_column is None:
        return False
    return believed.bias == "estimate" or integrates(believed)


def _unsaid(believed: Simulation, constant: float | str | None) -> bool:
    """Whether a constant of a linear plant in an open loop is unknown."""
    if believed.pendulum is not None or believed.controller is not None or isinstance(constant, float):
        return False
    return not any(declarable_effects()[effect.identifier].is_constant for effect in believed.effects)


def _constant_input(experiments: Sequence[Experiment], believed: Simulation) -> bool:
    return believed.input_column is not None and all(np.ptp(e.signal) == 0.0 for e in experiments)
