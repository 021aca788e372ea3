"""From recordings and a simulation to what is fitted: structure, kind of plant, problem and nominal model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import time_scale
from camid.chain.controller import Loop
from camid.effects.base import Effect
from camid.errors import InputError
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.closed_loop import ClosedLoop
from camid.fitting.plants.equations import EquationsKind
from camid.fitting.plants.kind import PlantKind
from camid.fitting.plants.linear import FreeDecay, LinearPlant
from camid.fitting.plants.named_constants import NamedConstants
from camid.fitting.plants.observed import ObservedPlant
from camid.fitting.plants.pendulum import PendulumKind
from camid.fitting.plants.physical import PhysicalFreeDecay, PhysicalKind
from camid.fitting.plants.several_readings import SeveralReadings
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

Array = NDArray[np.float64]


def structure_of(believed: Simulation) -> Structure:
    """Structure of the plant, and what of it is free; InputError if it has no dynamics."""
    monic = believed.plant.monic
    if monic.order == 0:
        raise InputError("the plant has no dynamics", where=believed.source, hint="give it at least one pole")
    free = _free_numerator(believed)
    return Structure(np.array(monic.numerator), np.array(monic.denominator), free, believed.free_denominator)


def refuse_stillness(believed: Simulation) -> None:
    """Refuse a plant that nothing drives and that starts at rest."""
    if believed.input_column is None and not believed.estimates_initial_state:
        raise InputError(
            "without input and at rest nothing moves",
            where=believed.source,
            hint="set initial_state: estimate for a free decay",
        )


def _free_numerator(believed: Simulation) -> NDArray[np.bool_]:
    """A free decay says nothing of the numerator: it keeps its believed value."""
    return believed.free_numerator & (believed.input_column is not None)


def kind_of(believed: Simulation, recordings: Sequence[Recording]) -> PlantKind:
    """The kind of plant that a simulation declares, for these recordings."""
    plant = _uncontrolled(believed)
    controller = believed.controller
    if believed.observer is not None:
        return ObservedPlant.of(plant, believed, believed.observer)
    if controller is None:
        return plant
    loops = tuple(Loop(controller, r.columns[controller.reference]) for r in recordings)
    positions = tuple(r.columns[believed.output_column] for r in recordings if believed.output_column in r.columns)
    return ClosedLoop(plant, loops, positions)


def _uncontrolled(believed: Simulation) -> PlantKind:
    pendulum = believed.pendulum
    if pendulum is not None:
        gain_free = bool(_free_numerator(believed)[0])
        fixed_gain = None if gain_free else pendulum.gain
        return PendulumKind(pendulum.rest, pendulum.is_free("rest"), fixed_gain, skew=believed.known_skew)
    driven = believed.input_column is not None
    if believed.physical is not None:
        named: type[NamedConstants] = EquationsKind
        if believed.physical.equations is None:
            named = PhysicalKind if driven else PhysicalFreeDecay
        elif believed.output_columns:
            named = SeveralReadings
        structure, offset = structure_of(believed), believed.known_offset
        return named(physical=believed.physical, structure=structure, offset=offset, skew=believed.known_skew)
    kind = LinearPlant if driven else FreeDecay
    return kind(offset=believed.known_offset, skew=believed.known_skew)


def problem_of(
    believed: Simulation, structure: Structure, recordings: list[Recording], experiments: list[Experiment]
) -> Problem:
    """What is fitted and diagnosed."""
    kind = kind_of(believed, recordings).with_unknown(experiments)
    problem = Problem(
        structure,
        kind.compared(experiments),
        [r.time for r in recordings],
        kind,
        time_scale(tuple(structure.denominator)),
        remainder=believed.remainder,
    )
    return replace(problem, kind=kind.prepared(problem))


def model_of(problem: Problem, effects: Sequence[Effect]) -> Model:
    """The nominal model, with the effects that the simulation declares."""
    return Model(problem.structure.coefficients(), tuple(effects), constants=problem.kind.constants())
