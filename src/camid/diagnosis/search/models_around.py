"""Starts beside other plants, for effects without which re-estimated coefficients mean nothing.

A sensor without sign makes the plant of best fit one that stands still in the middle of what it reads. From
coefficients that are off by a half no fit finds the way back, so the poles of the nominal plant are moved over more
than that, and each plant is judged by how well its output with the effect follows the recording. Other effects say
themselves beside which plant they hold, as an outflow does whose tangent the estimated plant is.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.search_hooks import SearchHooks
from camid.fitting.fit import Fitted
from camid.fitting.growing_horizon import fitted_as_far_as_it_follows, rows_followed
from camid.fitting.initial_motion import recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import BIAS, OFFSET
from camid.fitting.problem import Problem
from camid.fitting.recorded_zero import recorded_zero
from camid.side_by_side import side_by_side

Array = NDArray[np.float64]

# Factors of the natural frequencies and damping ratios of complex poles, and of real poles.
FREQUENCIES = np.geomspace(0.3, 3.5, 13)
DAMPINGS = (0.3, 1.0, 3.0, 10.0)
REAL_POLES = np.geomspace(0.2, 5.0, 6)
# Of the largest damping ratio with which complex poles are tried.
MOST_DAMPED = 3.0
# Models that fits start from.
KEPT = 4


def models_around(problem: Problem, nominal: Model) -> list[Model]:
    """The models with moved poles that follow the recordings best, the best first.

    Parameters
    ----------
    problem : Problem
    nominal : Model
        With the effect, which has no parameters and a size that grows with that of the output.

    Returns
    -------
    list of Model
        Their numerators are scaled to the recordings.
    """
    rough, recorded = problem.rough(), problem.output
    judged: list[tuple[float, int, Model]] = []
    # Those that were estimated without the effect are of a plant that there is not.
    constants = {**nominal.constants, **dict.fromkeys({OFFSET.name, BIAS.name} & set(nominal.constants), 0.0)}
    initial = tuple(None if state is None else np.zeros_like(state) for state in nominal.initial)
    for coefficients in _moved(problem, nominal.coefficients):
        model = replace(nominal, coefficients=coefficients, initial=initial, constants=constants)
        try:
            simulated = rough.simulate_fitted(model)
        except (ValueError, ArithmeticError):
            continue
        power = float(simulated @ simulated)
        gain = float(simulated @ recorded) / power if 0.0 < power < np.inf else 0.0
        if gain <= 0.0:
            continue
        error = recorded - gain * simulated
        judged.append(
            (float(error @ error), len(judged), problem.kind.with_coefficients(model, _scaled(problem, model, gain)))
        )
    return [model for _, _, model in sorted(judged, key=lambda item: item[:2])[:KEPT]]


def models_with_plants(problem: Problem, base: Fitted, identifiers: Iterable[str]) -> list[Model]:
    """A model with each effect that says itself beside which plant it holds, in addition to those of a base.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        Whose coefficients were estimated without the effect.
    identifiers : iterable of str
        Of the effects that are looked for.

    Returns
    -------
    list of Model
        Coefficients that are not free are those of the base; none of a plant that is not made from coefficients.
    """
    say_so = [name for name in sorted(set(identifiers)) if _says_its_plant(known_effects()[name])]
    found = side_by_side(partial(_with_its_plant, problem, recorded_zero(problem, base.model)), say_so)
    return [model for model in found if model is not None]


def _says_its_plant(kind: type[Effect]) -> bool:
    """Whether an effect may say beside which plant it holds."""
    return any("with_plant" in each.__dict__ for each in kind.__mro__ if each is not SearchHooks)


def _with_its_plant(problem: Problem, known: Model, identifier: str) -> Model | None:
    """A model with an effect beside the plant that it says; None where it says none."""
    kind = known_effects()[identifier]
    free = {constant.name for constant in problem.kind.free_constants()}
    estimated = {name: value for name, value in known.constants.items() if name in free}
    try:
        guess = kind.with_plant(problem.situations(known).of(kind), estimated)
        if guess is None:
            return None
        effect, plant, constants = guess
        return model_beside(problem, known.plus(effect), plant, constants)
    except (ValueError, ArithmeticError):
        return None


def model_beside(
    problem: Problem, model: Model, plant: TransferFunction, constants: Mapping[str, float]
) -> Model | None:
    """A model beside another plant, fitted as far as it follows the recordings; None where no coefficients make it.

    Parameters
    ----------
    problem : Problem
    model : Model
        With its effects.
    plant : TransferFunction
    constants : mapping of str to float
        That act beside that plant.
    """
    moved = with_plant(problem, model, plant, constants)
    if moved is None:
        return None
    # The state that suits the linear part best may be none beside an effect that bends the motion much.
    starts = problem.with_initial_states(moved), recorded_start(problem, moved)
    start = max(starts, key=lambda each: rows_followed(problem, each))
    return fitted_as_far_as_it_follows(problem, start)


def with_plant(problem: Problem, model: Model, plant: TransferFunction, constants: Mapping[str, float]) -> Model | None:
    """A model with another plant, without initial states; None where no coefficients make it (:func:`model_beside`)."""
    coefficients = np.array([*plant.numerator, *plant.denominator[1:]])
    kept = ~problem.structure.free
    coefficients[kept] = model.coefficients[kept]
    model = replace(model, constants={**model.constants, **constants}, initial=())
    moved = problem.kind.with_coefficients(model, coefficients)
    return moved if np.array_equal(moved.coefficients, coefficients) else None


def _scaled(problem: Problem, model: Model, gain: float) -> Array:
    """Coefficients whose numerator is larger by a gain."""
    coefficients = model.coefficients.copy()
    coefficients[: problem.structure.degree + 1] *= gain
    return coefficients


def _moved(problem: Problem, coefficients: Array) -> list[Array]:
    """Coefficients of plants with other poles and the same static gain, the nominal ones first."""
    split = problem.structure.degree + 1
    numerator, denominator = coefficients[:split], np.concatenate([[1.0], coefficients[split:]])
    poles = np.roots(denominator)
    pairs, real = poles[poles.imag > 0.0], poles[poles.imag == 0.0].real
    found = [coefficients]
    for frequency, damping, factor in product(
        FREQUENCIES if len(pairs) else (1.0,), DAMPINGS if len(pairs) else (1.0,), REAL_POLES if len(real) else (1.0,)
    ):
        polynomial = np.ones(1)
        for pole in pairs:
            size = abs(pole) * frequency
            ratio = min(max(-pole.real / abs(pole), 0.0) * damping, MOST_DAMPED)
            polynomial = np.polymul(polynomial, [1.0, 2.0 * ratio * size, size**2])
        for pole in real:
            polynomial = np.polymul(polynomial, [1.0, -factor * pole])
        last = denominator[-1] if denominator[-1] != 0.0 else 1.0
        gain = polynomial[-1] / last if polynomial[-1] != 0.0 else 1.0
        moved = np.concatenate([gain * numerator, polynomial[1:]])
        moved[~problem.structure.free] = coefficients[~problem.structure.free]
        found.append(moved)
    return found
