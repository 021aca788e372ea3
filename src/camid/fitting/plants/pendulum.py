"""A pendulum: a plant whose restoring force follows the sine of the angle from rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import time_scale
from camid.chain.pendulum import PARAMETERS, Pendulum
from camid.effects.base import Effect
from camid.effects.parameter import Parameter
from camid.effects.pendulum import SineRestoringForce
from camid.fitting.fit import Fitted, evaluate
from camid.fitting.initial_motion import FEWEST_SMOOTHED, MOST_SMOOTHED, SMOOTHED, recorded_start, with_positions_moved
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import with_constants
from camid.fitting.plants.kind import PlantKind
from camid.fitting.problem import Problem
from camid.identification.structure import Structure
from camid.simulation.model import Simulation

Array = NDArray[np.float64]
# Rise of the sum of squares, as a share, with which a motion is the same.
SAME_MOTION = 1e-6
# Swing to either side, in rad, up to which another angle at rest is a constant torque.
SMALL_SWING = 0.5
(REST,) = SineRestoringForce.parameters


@dataclass(frozen=True)
class PendulumKind(PlantKind):
    """ÿ + 2ξωẏ + ω² sin(y − rest) = gain ω² u: its coefficients are those of small motions.

    Attributes
    ----------
    rest : float
        Believed angle in rad at which it hangs still.
    rest_free : bool
        Whether that is re-estimated.
    fixed_gain : float, optional
        Ratio of b_0 to a_n that is kept where the natural frequency is re-estimated and the gain is not.
    """

    rest: float
    rest_free: bool = True
    fixed_gain: float | None = None

    prescribes_order: ClassVar[str | None] = "a pendulum"

    @property
    def phases_add_up(self) -> bool:
        """The frequency depends on how far it swings."""
        return True

    def constants(self) -> dict[str, float]:
        """The angle at rest."""
        return {**super().constants(), REST.name: self.rest}

    def free_constants(self) -> tuple[Parameter, ...]:
        """The angle at rest, unless it is known."""
        return (*super().free_constants(), REST) if self.rest_free else super().free_constants()

    def constant_beside(self, problem: Problem) -> bool:
        """Of one that hardly swings the angle at rest is such a constant, too."""
        hardly = float(np.ptp(problem.recorded)) < 2.0 * SMALL_SWING
        return super().constant_beside(problem) or (self.rest_free and hardly)

    def completed(self, coefficients: Array, constants: Mapping[str, float]) -> Array:
        """Coefficients with the numerator that a known gain prescribes."""
        if self.fixed_gain is None:
            return coefficients
        return np.array([self.fixed_gain * coefficients[-1], *coefficients[1:]])

    def all_fixed(self) -> Self:
        """The same with nothing to be re-estimated."""
        return replace(self, rest_free=False, fixed_gain=None)

    def forces(self, model: Model) -> tuple[Effect, ...]:
        """By how much the sine reduces the linear restoring force."""
        return (*super().forces(model), SineRestoringForce(rest=model.constants[REST.name]))

    def at_plant(self, positions: Array, model: Model) -> Array:
        """Angles from rest."""
        return super().at_plant(positions, model) - model.constants[REST.name]

    def starts_from_regression(self, problem: Problem, model: Model) -> list[Model]:
        """From the linear regression ÿ = -a_1 ẏ - a_2 (sin y cos r - cos y sin r) + b_0 u; none where it fails.

        A believed frequency that is a tenth too low lets a pendulum that swings far turn over, from where no fit
        returns; smoothed derivatives need no simulation and no start. What is not free keeps its value.
        """
        table, acceleration = _derivatives(problem, model)
        driven = bool(np.any(table[:, 3])) and bool(problem.structure.free_numerator[0])
        solution = np.linalg.lstsq(table if driven else table[:, :3], acceleration, rcond=None)[0]
        square = float(np.hypot(solution[1], solution[2]))
        if not np.isfinite(square) or square <= 0.0:
            return []
        coefficients = model.coefficients.copy()
        found = np.array([solution[3] if driven else coefficients[0], max(solution[0], 0.0), square])
        free = problem.structure.free
        coefficients[free] = found[free]
        constants = dict(model.constants)
        if self.rest_free:
            angle = float(np.arctan2(solution[2], solution[1]))
            constants[REST.name] = angle + 2.0 * np.pi * round((constants[REST.name] - angle) / (2.0 * np.pi))
        suggested = replace(model, coefficients=self.completed(coefficients, constants), constants=constants)
        return [recorded_start(problem, suggested)]

    def refit(self, problem: Problem, start: Model) -> Fitted:
        """The same, with the angle at rest in the turn in which it is believed to be: a fit may end in any of them."""
        found = super().refit(problem, start)
        rest = found.model.constants[REST.name]
        turns = 2.0 * np.pi * round((rest - self.rest) / (2.0 * np.pi))
        if turns == 0.0 or not found.model.initial:
            return found
        constants = {**found.model.constants, REST.name: rest - turns}
        turned = evaluate(problem, with_positions_moved(problem, replace(found.model, constants=constants), turns))
        # What counts the angle itself, as an effect beside it may, is not the same a turn further.
        return turned if turned.cost <= (1.0 + SAME_MOTION) * found.cost else found

    def estimates(self, structure: Structure, model: Model, fitted: Fitted | None) -> list[tuple[str, float, float]]:
        """Natural frequency, damping, gain and rest, as they are declared."""
        coefficients, rest = model.coefficients, float(model.constants[REST.name])
        gain_fixed = not structure.free_numerator[0]
        pendulum = Pendulum(1.0, 0.0, gain=float(coefficients[0] / coefficients[-1])).estimated(
            structure.plant(coefficients),
            rest,
            np.zeros((4, 4)) if fitted is None else _covariance(fitted, structure),
            gain_fixed=gain_fixed,
        )
        deviations = pendulum.standard_deviations or dict.fromkeys(PARAMETERS, np.inf)
        rows = pendulum.coefficient_rows()
        return [(name, value, deviations[name.replace(" ", "_")]) for name, value, _, _ in rows]

    def written_back(self, believed: Simulation, structure: Structure, fitted: Fitted) -> Simulation:
        """The simulation with natural frequency, damping, gain and rest, and their accuracy."""
        assert believed.pendulum is not None
        pendulum = believed.pendulum.estimated(
            structure.plant(fitted.model.coefficients),
            fitted.model.constants[REST.name],
            _covariance(fitted, structure),
            gain_fixed=not structure.free_numerator[0],
        )
        return replace(
            with_constants(believed, fitted, self.free_constants()),
            pendulum=pendulum,
            plant=pendulum.transfer_function(),
        )


def _derivatives(problem: Problem, model: Model) -> tuple[Array, Array]:
    """Regressors -ẏ, -sin y, cos y and u of all recordings, shape (N, 4), and ÿ, shape (N,); smoothed."""
    from scipy.signal import savgol_filter

    constant = time_scale((1.0, *model.coefficients[problem.structure.degree + 1 :]))
    tables, accelerations = [], []
    for experiment in problem.experiments:
        period = experiment.acquisition.period
        half = int(np.clip(SMOOTHED * constant / period, FEWEST_SMOOTHED, MOST_SMOOTHED)) // 2
        window = 2 * half + 1
        smooth, velocity, acceleration = (
            savgol_filter(experiment.output, window, min(4, window - 1), derivative, period) for derivative in range(3)
        )
        tables.append(np.column_stack([-velocity, -np.sin(smooth), np.cos(smooth), experiment.signal]))
        accelerations.append(acceleration)
    return np.concatenate(tables), np.concatenate(accelerations)


def _covariance(fitted: Fitted, structure: Structure) -> Array:
    """Covariance of b_0, a_1, a_2 and the angle at rest, shape (4, 4)."""
    names = fitted.packing.names
    free, rows = [*np.flatnonzero(structure.free)], [*range(int(np.count_nonzero(structure.free)))]
    if REST.name in names:
        free.append(3)
        rows.append(names.index(REST.name))
    result = np.zeros((4, 4))
    result[np.ix_(free, free)] = fitted.covariance[np.ix_(rows, rows)]
    return result
