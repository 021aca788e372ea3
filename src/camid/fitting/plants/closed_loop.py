"""A plant in a closed loop: the control signal carries the information, as the position follows the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.controller import Loop
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.situation import Situation
from camid.engine.mechanics import Chain
from camid.engine.run import move, observed
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.held import HeldPlant
from camid.fitting.problem import Problem
from camid.fitting.views import Views
from camid.identification.experiment import Experiment
from camid.identification.srivc import reflect

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ClosedLoop(HeldPlant):
    """A plant of any other kind whose input a controller makes.

    Attributes
    ----------
    loops : tuple of Loop
        The controller of each recording with its reference.
    positions : tuple of ndarray, each of shape (N,)
        Recorded positions; the outputs that are compared are what the controller put out.
    """

    loops: tuple[Loop, ...]
    positions: tuple[Array, ...] = ()

    prescribes_order: ClassVar[str | None] = "a closed loop"
    why_no_other_orders: ClassVar[tuple[str, str] | None] = (
        "plants driven by an open-loop input, and this one has a controller",
        "write the plant, and let identify or diagnose estimate it in its loop",
    )
    shown_sign: ClassVar[float] = -1.0
    residual_of: ClassVar[str] = "control"
    simulated_columns: ClassVar[tuple[str, ...]] = ("simulated", "simulated_input")
    hidden_places: ClassVar[frozenset[str]] = frozenset({"sensor"})
    why_hidden: ClassVar[str] = (
        "in a closed loop the control signal reflects the plant; the controller has its own sensor"
    )
    why_coloured: ClassVar[str] = (
        "the controller answers to the noise of its sensor, so that the control that is left has a colour of its own"
    )

    def loop(self, index: int) -> Loop:
        """The controller with the reference of a recording."""
        return self.loops[index]

    def output_and_control(self, chain: Chain, signal: Array, time: Array) -> tuple[Array, Array | None]:
        """Samples of the sensor, and what the controller puts out."""
        motion = move(chain, signal, time)
        put_out = signal if motion.control is None else motion.control
        return observed(chain, motion, time, put_out), motion.control

    def compared(self, experiments: list[Experiment]) -> list[Experiment]:
        """Experiments whose outputs are what the controller put out."""
        return [replace(e, output=e.signal) for e in experiments]

    def start_of(self, rows: int) -> Self:
        """The same for recordings that are cut off after this many rows."""
        loops = tuple(replace(loop, reference=loop.reference[:rows]) for loop in self.loops)
        return replace(self, loops=loops, positions=tuple(p[:rows] for p in self.positions))

    def recorded_positions(self, problem: Problem) -> Sequence[Array]:
        """Recorded positions of each recording, shapes (N,)."""
        return self.positions

    def position_seen(self, problem: Problem, model: Model, index: int, position: Array) -> Array:
        """The motion itself: the controller's sensor is not the camera."""
        return position

    def unseen(self, effect: type[Effect]) -> str | None:
        """Nothing of the camera, and of what is declared of it; nor a colour of the noise, which the loop gives it."""
        if effect.colours_noise:
            return self.why_coloured
        behind = effect.carry is not Effect.carry
        hidden = effect.place in self.hidden_places or effect.corrects_declaration or behind
        return self.why_hidden if hidden else None

    def situations(self, problem: Problem, model: Model, index: int) -> Views:
        """Position and velocity are the simulated ones, the residual is that of the control."""
        experiment, time = problem.experiments[index], problem.times[index]
        motion = move(problem.chain(model, index), experiment.signal, time)
        nodes = np.round((time - motion.start) / motion.step).astype(int)
        simulated = np.zeros(len(time)) if motion.control is None else motion.control
        plant = problem.structure.plant(model.coefficients)
        situation = Situation(
            time,
            experiment.output,
            self.positions[index],
            motion.position[nodes],
            motion.velocity[nodes],
            np.where(experiment.used, experiment.output - simulated, 0.0),
            _mirrored(plant),
            # The control is compared as it is, whatever the camera does.
            Acquisition(experiment.acquisition.period, experiment.acquisition.hold, "instant"),
            experiment.used,
            controlled=True,
            answer=_mirrored(self.loops[index].controller.answer_to_force(plant)),
            others=problem.signals_beside(index),
        )
        return Views(situation, situation, situation)

    def equivalent_input(self, problem: Problem, model: Model, residual: Array) -> Array:
        """The residual of the control is an input already."""
        return residual

    def force_seen(self, problem: Problem, model: Model, force: Array) -> Array:
        """The controller makes up for the force as it is."""
        return force

    def position_errors(
        self, problem: Problem, models: tuple[Model, Model], rows: Sequence[NDArray[np.bool_]]
    ) -> tuple[float, float] | None:
        """Root mean square error over the standard deviation of the recorded position, with each model."""
        recorded = np.concatenate([p[r] for p, r in zip(self.positions, rows, strict=True)])
        spread = float(np.std(recorded)) or 1.0

        def error(model: Model) -> float:
            moved = np.concatenate([m[0][r] for m, r in zip(problem.motion(model), rows, strict=True)])
            return float(np.sqrt(np.mean((recorded - moved) ** 2))) / spread

        before, after = models
        return error(before), error(after)


def _mirrored(plant: TransferFunction) -> TransferFunction:
    """A stable plant of the same gain at each frequency: first guesses simulate one without its controller."""
    return TransferFunction(plant.numerator, tuple(reflect(np.asarray(plant.denominator))))
