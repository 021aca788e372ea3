"""From recordings and a simulation to what is fitted: structure, problem and nominal model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.controller import Loop
from camid.chain.exact import time_scale
from camid.effects.base import Effect
from camid.errors import InputError
from camid.fitting.problem import Model, Problem
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
    # A free decay says nothing of the numerator: it keeps its believed value.
    free = believed.free_numerator & (believed.input_column is not None)
    return Structure(np.array(monic.numerator), np.array(monic.denominator), free, believed.free_denominator)


def problem_of(
    believed: Simulation, structure: Structure, recordings: list[Recording], experiments: list[Experiment]
) -> Problem:
    """What is diagnosed; in a closed loop the control is what is compared."""
    loops: tuple[Loop, ...] = ()
    positions: tuple[Array, ...] = ()
    if believed.controller is not None:
        loops = tuple(Loop(believed.controller, r.columns[believed.controller.reference]) for r in recordings)
        positions = tuple(e.output for e in experiments)
        experiments = [replace(e, output=e.signal) for e in experiments]
    pendulum = believed.pendulum
    gain_fixed = pendulum is not None and not bool(structure.free_numerator[0])
    return Problem(
        structure,
        experiments,
        [r.time for r in recordings],
        time_scale(tuple(structure.denominator)),
        loops=loops,
        positions=positions,
        rest_free=pendulum is not None and pendulum.is_free("rest"),
        fixed_gain=pendulum.gain if pendulum is not None and gain_fixed else None,
        remainder=believed.remainder,
    )


def model_of(believed: Simulation, structure: Structure, effects: Sequence[Effect]) -> Model:
    """The nominal model, with the effects that the simulation declares."""
    rest = None if believed.pendulum is None else believed.pendulum.rest
    return Model(structure.coefficients(), tuple(effects), rest=rest)
