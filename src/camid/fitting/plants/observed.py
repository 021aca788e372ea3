"""A plant that an observer pulls towards the recorded motion, as only an undeclared controller holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from camid.chain.observer import Observer, Pull
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import OFFSET
from camid.fitting.plants.held import HeldPlant
from camid.fitting.plants.kind import PlantKind
from camid.fitting.problem import Problem
from camid.fitting.views import Views
from camid.identification.experiment import Experiment
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Rows in a row at most that are left out because they are no readings of the motion.
MOST_SPOILED = 5
# Difference of a frame from the cubic through two on either side of it; its size, in the median of all, from which the
# frame is no reading of the motion, and the share of frames that are none at most.
CUBIC = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 6.0
FAR_OFF, MOST_FAR_OFF = 30.0, 0.02


@dataclass(frozen=True)
class ObservedPlant(HeldPlant):
    """A linear plant that a recorded input drives and an observer pulls towards what was recorded.

    Attributes
    ----------
    observer : Observer
    integrates : bool
        Whether the zero of the position is where the initial state says.
    """

    observer: Observer
    integrates: bool = False

    prescribes_order: ClassVar[str | None] = "an observer"
    why_no_other_orders: ClassVar[tuple[str, str] | None] = (
        "plants that follow a recording by themselves, and this one has an observer",
        "write the plant, and let identify or diagnose estimate it as it is pulled",
    )
    why_hidden: ClassVar[str] = "the observer takes what the sensor reads for the position that it pulls towards"
    why_coloured: ClassVar[str] = (
        "the observer answers to the noise of the sensor, so that what is left has a colour of its own"
    )

    @classmethod
    def of(cls, plant: PlantKind, believed: Simulation, observer: Observer) -> ObservedPlant:
        """A plant as a simulation believes it, with an observer."""
        integrates = believed.plant.denominator[-1] == 0.0
        return cls(plant, observer, integrates, offset=plant.offset, skew=plant.skew)

    def with_unknown(self, experiments: Sequence[Experiment]) -> Self:
        """Of a plant that integrates the zero is where its initial state says."""
        experiments = self.compared(list(experiments))
        return replace(super().with_unknown(experiments), plant=self.plant.with_unknown(experiments))

    def compared(self, experiments: list[Experiment]) -> list[Experiment]:
        """Experiments whose initial states are what they show."""
        return [
            replace(e, estimate_initial_state=True, estimate_offset=e.estimate_offset and not self.integrates)
            for e in experiments
        ]

    def pull(self, experiment: Experiment, model: Model, effects: Sequence[Effect]) -> Pull:
        """The observer with the recorded positions, but those that are no readings of the motion."""
        acquisition = experiment.acquisition
        for effect in effects:
            acquisition = effect.declare(acquisition)
        none = _spoiled(experiment.used) | _far_off(experiment.output)
        frames = np.where(none, np.nan, experiment.output - model.constants.get(OFFSET.name, 0.0))
        return Pull(self.observer, frames, acquisition)

    def _searched(self, problem: Problem, start: Model) -> Fitted:
        """Output error with the best of some latencies, where that is open."""
        return super()._searched(problem, self.with_best_latency(problem, start))

    def remarks(self, found: Simulation) -> tuple[str, ...]:
        """That the simulation is pulled, as errors of one that is are no errors of a prediction."""
        return (
            *super().remarks(found),
            f"an observer pulls the simulated motion towards the recorded one, at {self.observer.rate:.3g} rad/s: the "
            "errors are those of the next frames, and sensor effects cannot show",
        )

    def unseen(self, effect: type[Effect]) -> str | None:
        """Nothing of what bends the reading, and no colour of the noise; what is declared of the frames is seen."""
        if effect.colours_noise:
            return self.why_coloured
        if effect.place == "sensor" and not (effect.corrects_declaration or effect.noise_like):
            return self.why_hidden
        return super().unseen(effect)

    def situations(self, problem: Problem, model: Model, index: int) -> Views:
        """What is pulled answers a force by less than the plant alone."""
        answer = self.seen_plant(problem, model)
        views = super().situations(problem, model, index)
        return Views(*(replace(view, answer=answer) for view in (views.reading, views.sensor, views.plant)))

    def seen_plant(self, problem: Problem, model: Model) -> TransferFunction:
        """From a force to what the sensor sees, as the observer holds against it."""
        return self.observer.answer_to_force(problem.structure.plant(model.coefficients))


def _spoiled(used: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rows, shape (N,), that are left out one by one, and not as a part that judges."""
    from scipy.ndimage import binary_closing

    return np.asarray(binary_closing(used, np.ones(MOST_SPOILED + 1, bool)) & ~used)


def _far_off(output: Array) -> NDArray[np.bool_]:
    """Frames, shape (N,), that lie far from the cubic through those around them, such as those of another marker.

    One that pulls shows for long. Where many are far off a cubic, it is the motion that is.
    """
    if len(output) < len(CUBIC):
        return np.zeros(len(output), bool)
    distance = np.zeros(len(output))
    distance[2:-2] = np.abs(np.convolve(np.nan_to_num(output), CUBIC, mode="valid"))
    far = distance > FAR_OFF * np.median(distance)
    return far if np.mean(far) < MOST_FAR_OFF else np.zeros(len(output), bool)
