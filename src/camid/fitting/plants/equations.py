"""A plant of nonlinear equations with named constants."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from camid.engine.nonlinear_plant import NonlinearPlant
from camid.fitting.fit import Fitted
from camid.fitting.growing_horizon import fit_growing
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.kind import PlantKind
from camid.fitting.plants.linear import misfit
from camid.fitting.plants.named_constants import PREFIX, NamedConstants
from camid.fitting.problem import Problem
from camid.physical.equations import Equations, coefficients_at, sensitive_to, state_at_rest
from camid.physical.undetermined import POINTS, SIMULATED, Undetermined, undetermined_by

if TYPE_CHECKING:
    from camid.identification.identification import Identification

Array = NDArray[np.float64]

# Relative change of what is fitted for a central difference of simulations, and rows that it is looked at on.
CHANGE = 1e-4
ROWS = 1500
# First values of the constants are searched over this factor to both sides, by 2^STARTS quasi-random points, of which
# the best KEPT are fitted.
REACH = 3.0
STARTS = 6
KEPT = 6
SEED = 0
# First rows whose mean is the output where a recording starts.
FIRST_ROWS = 5


@dataclass(frozen=True)
class EquationsKind(NamedConstants):
    """ẋ = f(x, u, constants), y = h(x).

    Attributes
    ----------
    left_open : Undetermined
        What the recordings leave open of the constants; see :meth:`prepared`.
    """

    left_open: Undetermined = field(default_factory=Undetermined, kw_only=True)

    @property
    def phases_add_up(self) -> bool:
        """Where it oscillates, the frequency may depend on how far it goes."""
        plant = self.structure.plant(self.structure.coefficients())
        return bool(np.any(np.abs(plant.poles().imag) > 0.0))

    @property
    def undetermined(self) -> Undetermined:
        """What the recordings leave open of the constants."""
        return self.left_open

    @property
    def equations(self) -> Equations:
        """As they are declared."""
        found = self.physical.equations
        assert found is not None
        return found

    def coefficients(self, values: Array) -> Array:
        """Of small motions about the start."""
        return coefficients_at(self.equations, values, len(self.structure.free))

    @cached_property
    def sensitive(self) -> Array:
        """Changes of the coefficients by relative changes of the constants."""
        return sensitive_to(self.equations, self.physical.values)

    def nonlinear(self, model: Model, seen: int | None = None) -> NonlinearPlant:
        """The equations with the constants of a model, as a column of the sensor sees them."""
        return NonlinearPlant(self.equations, self.values_of(model), seen)

    def rest_of(self, model: Model) -> Callable[[float], dict[str, float] | None]:
        """State at rest, by name, at an output; None where it rests nowhere."""
        return partial(state_at_rest, self.equations, self.values_of(model))

    def with_coefficients(self, model: Model, coefficients: Array) -> Model:
        """The model as it is: equations are not made from coefficients."""
        return model

    def with_initial_states(self, problem: Problem, model: Model) -> Model:
        """The model with the declared start, and with the first recorded outputs where a state is the output."""
        initial: list[Array | None] = []
        measured = self.nonlinear(model).function.measured_state
        for experiment in problem.experiments:
            if not experiment.estimate_initial_state:
                initial.append(None)
                continue
            state = np.array(self.equations.start, dtype=float)
            if measured is not None and experiment.seen is None:
                first = self.at_plant(experiment.output, model)[experiment.used][:FIRST_ROWS]
                state[measured] = float(np.mean(first))
            initial.append(state)
        return replace(model, initial=tuple(initial))

    def _searched(self, problem: Problem, start: Model) -> Fitted:
        """Fits from the model and from those about it that follow the recordings best; the best of them."""
        start = self.with_best_latency(problem, start)
        starts = [start, *self.models_about(problem, start)]
        return min((fit_growing(problem, one) for one in starts), key=lambda fitted: fitted.cost)

    def models_about(self, problem: Problem, start: Model) -> list[Model]:
        """Models with constants over a range of a factor of three to both sides, the best first; few of them."""
        # Constants that a fit has found need no search.
        if not self.estimated or start.effects or not np.array_equal(self.values_of(start), self.physical.values):
            return []
        from scipy.stats import qmc

        rough, judged = problem.start_of(ROWS).rough(), []
        columns = [self.physical.names.index(name) for name in self.estimated]
        points = qmc.Sobol(len(columns), rng=SEED).random_base2(STARTS)
        for order, point in enumerate(points):
            values = self.values_of(start)
            values[columns] *= REACH ** (2.0 * point - 1.0)
            try:
                model = problem.with_initial_states(self.with_values(start, values))
                cost = misfit(rough, model)
            except (ValueError, ArithmeticError):
                continue
            judged.append((cost, order, model))
        judged.sort(key=lambda item: item[:2])
        return [model for _, _, model in judged[:KEPT] if np.isfinite(judged[0][0])]

    def prepared(self, problem: Problem) -> Self:
        """The same with what the recordings leave open of the constants: found by simulations with others."""
        free = self.physical.free
        short = problem.start_of(ROWS)
        tables, points = [], []
        for odd, even in POINTS:
            values = self.physical.values
            columns = [self.physical.names.index(name) for name in free]
            values[columns] *= np.where(np.arange(len(columns)) % 2, even, odd)
            table = self._changes(short, values)
            if table is not None:
                tables.append(table)
                points.append(values[columns])
        return replace(self, left_open=undetermined_by(free, tables, points, SIMULATED))

    def _changes(self, problem: Problem, values: Array) -> Array | None:
        """Changes of the output by relative changes of the free constants that nothing else makes up for."""
        nominal = Model(problem.structure.coefficients(), constants=self.constants())
        try:
            model = problem.with_initial_states(self.with_values(nominal, values))
            packing = Packing.of(problem, model)
            vector, columns = packing.pack(model), []
            for i in range(len(vector)):
                ends = []
                for side in (CHANGE, -CHANGE):
                    moved = vector.copy()
                    moved[i] += side
                    ends.append(problem.simulate_fitted(packing.unpack(moved)))
                columns.append((ends[0] - ends[1]) / (2.0 * CHANGE))
        except (ValueError, ArithmeticError):
            return None
        table = np.column_stack(columns)
        if not np.all(np.isfinite(table)):
            return None
        named = [packing.names.index(PREFIX + name) for name in self.physical.free]
        others = [i for i in range(len(vector)) if i not in named]
        if others:
            lengths = np.linalg.norm(table[:, others], axis=0)
            basis, _ = np.linalg.qr(table[:, others][:, lengths > 0.0] / lengths[lengths > 0.0])
            return np.asarray(table[:, named] - basis @ (basis.T @ table[:, named]))
        return np.asarray(table[:, named])

    def identified(self, problem: Problem, task: IdentificationTask) -> Identification:
        """By output error through the engine.

        Raises
        ------
        InputError
            If no constant is free.
        """
        self.refuse_nothing_free(task)
        return PlantKind.identified(self, problem, task)
