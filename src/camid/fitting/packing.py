"""The free numbers of a model as one vector, each divided by what it is measured by."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import time_scale
from camid.effects.parameter import Parameter
from camid.engine.mechanics import companion_block
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# What the names of initial states begin with.
INITIAL = "initial"


@dataclass(frozen=True)
class Packing:
    """How a model's free numbers lie in one vector, each divided by what it is measured by."""

    template: Model
    free: NDArray[np.bool_]
    units: Array
    lower: Array
    upper: Array
    names: list[str]
    problem: Problem
    constants: tuple[Parameter, ...] = ()
    fixed: int = 0

    @classmethod
    def of(cls, problem: Problem, model: Model, fixed: int = 0) -> Packing:
        """Packing of the free coefficients, the effects' parameters, the plant's constants and the initial states.

        The first ``fixed`` effects keep their values.
        """
        free = problem.kind.packed(problem.structure)
        scale = np.array(
            [problem.unit**-(power) for power in _powers(problem)]
        )  # a coefficient that is zero is measured by what would be of the order of one
        coefficients = model.coefficients[free]
        units = list(np.maximum(np.abs(coefficients), 1e-2 * scale[free] * _gain(problem, free)))
        names = [f"coefficient {i}" for i in np.flatnonzero(free)]
        lower, upper = _stable(problem)[free].tolist(), [np.inf] * len(units)
        for i, effect in enumerate(model.effects):
            if i < fixed:
                continue
            bounds = effect.bounds(problem.acquisition)
            for parameter, value, (least, largest) in zip(effect.numeric(), effect.vector, bounds, strict=True):
                units.append(_measure(problem, parameter.scale, float(value)))
                lower.append(least)
                upper.append(largest)
                names.append(f"{i} {parameter.name}")
        constants = problem.kind.free_constants()
        for constant in constants:
            units.append(_measure(problem, constant.scale, float(model.constants[constant.name]) or constant.size))
            lower.append(constant.lower)
            upper.append(constant.upper)
            names.append(constant.name)
        model = problem.with_states_of_effects(model)
        linear = problem.kind.nonlinear(model) is None
        modes, memories = (model.modes(), model.memories()) if linear else ([], [])
        for i, state in enumerate(model.initial):
            if state is not None:
                order = len(state) - len(modes) - len(memories)
                size = float(np.linalg.norm(state[:order])) or 1.0
                units += [size] * order + (_mode_sizes(problem, model) if modes else []) + [1.0] * len(memories)
                names += [f"{INITIAL} {i}"] * order
                names += [f"{INITIAL} {i} of {effect}" for effect in modes + memories]
                unbounded = [np.inf] * (order + len(modes))
                farthest = [*unbounded, *(float(model.effects[m].largest_memory or 0.0) for m in memories)]
                lower += [-bound for bound in farthest]
                upper += farthest
        measures = np.array(units)
        low, high = np.array(lower) / measures, np.array(upper) / measures
        return cls(model, free, measures, low, high, names, problem, constants, fixed)

    def pack(self, model: Model) -> Array:
        """Vector of a model."""
        model = self.problem.with_states_of_effects(model)
        parts = [model.coefficients[self.free], *(e.vector for e in model.effects[self.fixed :])]
        parts.append(np.array([model.constants[c.name] for c in self.constants]))
        parts += [s for s in model.initial if s is not None]
        return np.concatenate(parts) / self.units

    def unpack(self, vector: Array) -> Model:
        """Model of a vector."""
        values = vector * self.units
        coefficients = self.template.coefficients.copy()
        position = int(np.count_nonzero(self.free))
        coefficients[self.free] = values[:position]
        effects = list(self.template.effects[: self.fixed])
        for effect in self.template.effects[self.fixed :]:
            size = len(effect.numeric())
            effects.append(effect.with_vector(values[position : position + size]) if size else effect)
            position += size
        constants = dict(self.template.constants)
        for constant in self.constants:
            constants[constant.name] = float(values[position])
            position += 1
        coefficients = self.problem.kind.completed(coefficients, constants)
        initial: list[Array | None] = []
        for state in self.template.initial:
            if state is None:
                initial.append(None)
            else:
                initial.append(values[position : position + len(state)])
                position += len(state)
        return Model(coefficients, tuple(effects), tuple(initial), constants)

    def moved_together(self, columns: Iterable[int]) -> list[dict[int, int | None]]:
        """Columns in groups that one simulation differentiates by, each with the run alone whose output it moves.

        The initial states of different runs are such a group (Curtis, Powell & Reid 1974, J. Inst. Math. Appl. 13,
        117-119); a column that moves all runs, of which None is said, is one of its own.
        """
        groups: dict[tuple[int, int], dict[int, int | None]] = {}
        seen: dict[int, int] = {}
        wanted = set(columns)
        for column, name in enumerate(self.names):
            if name.startswith(INITIAL):
                run = int(name.split()[1])
                seen[run] = seen.get(run, 0) + 1
                key, moved = (0, seen[run]), run
            else:
                key, moved = (1, column), None
            if column in wanted:
                groups.setdefault(key, {})[column] = moved
        return list(groups.values())


def _mode_sizes(problem: Problem, model: Model) -> list[float]:
    """What the initial states of modes are measured by: motions as large as the output, and lags as the input."""
    plant = problem.structure.plant(model.coefficients)
    unit = time_scale(plant.monic.denominator)
    spread = float(np.std(problem.recorded)) or 1.0
    parts = [(e.beside_plant(), spread) for e in model.effects] + [(e.after_plant(), spread) for e in model.effects]
    parts += [(e.before_plant(), _largest_input(problem)) for e in model.effects]
    sizes: list[float] = []
    for part, extent in parts:
        if part is not None:
            row = companion_block(part, unit)[1]
            sizes += [extent / (float(np.linalg.norm(row)) or 1.0)] * part.order
    return sizes


def _largest_input(problem: Problem) -> float:
    return max(float(np.max(np.abs(e.signal), initial=0.0)) for e in problem.experiments) or 1.0


def _stable(problem: Problem) -> Array:
    """Lower bounds of all coefficients: up to two poles a plant is stable if those of its denominator are not negative.

    An effect that takes energy away would else be paired with a plant that makes it.
    """
    structure = problem.structure
    lower = np.full(len(structure.free), -np.inf)
    if structure.order <= 2 and np.all(structure.denominator >= 0.0):
        lower[structure.degree + 1 :] = 0.0
    return lower


def _powers(problem: Problem) -> list[float]:
    order, degree = problem.structure.order, problem.structure.degree
    return [*(order - degree + np.arange(degree + 1.0)), *(1.0 + np.arange(order))]


def _gain(problem: Problem, free: NDArray[np.bool_]) -> Array:
    """Output over input, for the numerator; one for the denominator."""
    signal = _largest_input(problem)
    gain = np.ones(len(free))
    gain[: problem.structure.degree + 1] = (float(np.ptp(problem.recorded)) or 1.0) / signal
    return gain[free]


def _measure(problem: Problem, scale: str, value: float) -> float:
    if scale == "slip":
        return float(problem.acquisition.period) / problem.duration
    if scale == "period":
        return float(problem.acquisition.period)
    if scale == "output":
        return problem.output_spread
    if scale == "input":
        return _largest_input(problem)
    if scale == "resolution":
        return 1.0 / problem.duration
    return 1.0 if scale == "one" or value == 0.0 else abs(value)
