"""The linear plant of a simulation as frequency responses, poles and steps show it, with its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.analysis.spread import has_covariance, states_accuracy, varied
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.declared import effects_of
from camid.engine.mechanics import Chain
from camid.errors import InputError
from camid.number_text import plain
from camid.physical.equations import plant_function
from camid.simulation.declared_units import DeclaredUnits, SignalUnit
from camid.simulation.model import DeclaredEffect, Simulation

Array = NDArray[np.float64]

# Share of a standard deviation for a difference that replaces a derivative.
SMALL = 1e-3
# Rate of a state, relative to its size and the fastest pole, below which the plant rests.
AT_REST = 1e-6

NO_BAND = "without a band, as it states no accuracy (camid identify writes it where the data determine it)"
ONLY_DEVIATIONS = "without a band, as it states standard deviations and no covariance"
UNCORRELATED = "effects enter the band without their correlation with the plant, which no file states"


@dataclass(frozen=True)
class LinearModel:
    """B(s)/A(s) with a monic denominator, and how uncertain it is.

    Attributes
    ----------
    name : str
        What a legend calls it.
    simulation : Simulation
    plant : TransferFunction
        Linear effects before, beside and after the plant included; of a nonlinear plant that of small motions.
    factor : ndarray, shape (m + 1 + n, r), or None
        F with the covariance F Fᵀ of [b_0 … b_m, a_1 … a_n]; None where the model states none.
    linearised : tuple of str
        What is nonlinear and not in it, a sentence each.
    others : tuple of str
        What else is not in it.
    """

    name: str
    simulation: Simulation
    plant: TransferFunction
    factor: Array | None
    linearised: tuple[str, ...] = ()
    others: tuple[str, ...] = ()

    @classmethod
    def of(cls, simulation: Simulation, name: str) -> LinearModel:
        """The linear part of a simulation.

        Raises
        ------
        InputError
            If an effect is declared wrongly.
        """
        effects = effects_of(simulation)
        linear = tuple(e for e in effects if is_linear(e))
        plant = _whole(simulation.plant, linear).monic
        size = len(plant.numerator)
        columns = []
        for ends in varied(replace(simulation, effects=_declared(simulation, linear)), SMALL):
            there, back = (_coefficients(_whole(end.plant, effects_of(end)).monic, size) for end in ends)
            columns.append((there - back) / (2.0 * SMALL))
        moving = [c for c in columns if np.any(c)]
        factor = np.column_stack(moving) if moving else None
        if factor is not None and not np.all(np.isfinite(factor)):
            factor = None
        linearised = tuple(_linearised(simulation, name, effects))
        return cls(name, simulation, plant, factor, linearised, tuple(_others(simulation, name)))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What else is to be known of a linear picture: what is not in it, and how sure it is."""
        if self.factor is None:
            known = states_accuracy(self.simulation) and not has_covariance(self.simulation)
            return *self.others, f"{self.name}: {ONLY_DEVIATIONS if known else NO_BAND}"
        if self.simulation.effects and any(map(is_linear, effects_of(self.simulation))):
            return *self.others, f"{self.name}: {UNCORRELATED}"
        return self.others

    @property
    def deviations(self) -> Array | None:
        """Standard deviations of [b_0 … b_m, a_1 … a_n]."""
        return None if self.factor is None else np.sqrt(np.sum(self.factor**2, axis=1))

    def moved(self, direction: Array, share: float) -> TransferFunction:
        """The plant with its coefficients moved by a share of a direction, shape (m + 1 + n,)."""
        split = len(self.plant.numerator)
        numbers = np.array([*self.plant.numerator, *self.plant.denominator[1:]]) + share * direction
        return TransferFunction(tuple(numbers[:split]), (1.0, *numbers[split:]))


def linear_models(models: Mapping[str, Simulation]) -> list[LinearModel]:
    """The linear part of each; InputError names the one that has none."""
    found = []
    for name, simulation in models.items():
        try:
            found.append(LinearModel.of(simulation, name))
        except InputError:
            raise
        except (ValueError, ArithmeticError) as error:
            raise InputError(f"no linear plant: {error}", where=simulation.source, hint="check its constants") from None
    return found


def units_of(simulation: Simulation) -> DeclaredUnits:
    """Units of input and output of the plant; several columns of a sensor see an output of the equations."""
    units = simulation.units
    equations = None if simulation.physical is None else simulation.physical.equations
    if simulation.output_columns and equations is not None:
        return replace(units, output=SignalUnit("y", equations.output))
    return units


def is_linear(effect: Effect) -> bool:
    """Whether an effect is linear dynamics before, beside or after the plant."""
    return any(part is not None for part in (effect.before_plant(), effect.beside_plant(), effect.after_plant()))


def _declared(simulation: Simulation, kept: tuple[Effect, ...]) -> tuple[DeclaredEffect, ...]:
    """Declarations of some of the effects."""
    names = {e.identifier for e in kept}
    return tuple(d for d in simulation.effects if d.identifier in names)


def _whole(plant: TransferFunction, effects: tuple[Effect, ...]) -> TransferFunction:
    return Chain(plant, Acquisition(1.0), effects).whole_plant() if effects else plant


def _coefficients(plant: TransferFunction, zeros: int) -> Array:
    """[b_0 … b_m, a_1 … a_n] with as many coefficients of the numerator as are asked for."""
    numerator = np.zeros(max(zeros, len(plant.numerator)))
    numerator[len(numerator) - len(plant.numerator) :] = plant.numerator
    return np.array([*numerator[-zeros:], *plant.denominator[1:]])


def _linearised(simulation: Simulation, name: str, effects: tuple[Effect, ...]) -> list[str]:
    """What a linear picture of this model leaves out of its physics."""
    said = []
    if simulation.pendulum is not None:
        units = simulation.units
        rest = plain(units.shown(simulation.pendulum.rest, "y"), 4, units.text("y"))
        said.append(f"{name}: a pendulum, linearised about its rest at {rest}")
    physical = simulation.physical
    if physical is not None and physical.equations is not None:
        said.append(f"{name}: nonlinear equations, {_where_linearised(simulation)}")
    left_out = [e.identifier for e in effects if not is_linear(e) and not e.corrects_declaration]
    if left_out:
        said.append(f"{name}: without {', '.join(left_out)} (not linear dynamics of the plant)")
    return said


def _others(simulation: Simulation, name: str) -> list[str]:
    """What else is to be known of the plant alone."""
    said = []
    if simulation.output_columns:
        said.append(f"{name}: from the input to the plant's output '{units_of(simulation).output.column}'")
    if simulation.controller is not None:
        said.append(f"{name}: the plant without its controller")
    if simulation.observer is not None:
        said.append(f"{name}: the plant without its observer")
    if simulation.input_column is None:
        said.append(f"{name}: a free decay says nothing of the numerator, which is as it was declared")
    return said


def _where_linearised(simulation: Simulation) -> str:
    """About which state equations are linearised, and whether the plant rests there."""
    physical = simulation.physical
    assert physical is not None
    equations = physical.equations
    assert equations is not None
    start = np.array(equations.start or [0.0] * len(equations.states), dtype=float)
    pairs = zip(equations.state_names, start, strict=True)
    about = ", ".join(f"{name} = {plain(float(value))}" for name, value in pairs)
    return f"linearised about {about}, without input" + (
        "" if rests_at_start(simulation) else ", where it does not rest"
    )


def rests_at_start(simulation: Simulation) -> bool:
    """Whether a plant stays where it starts while nothing drives it; all but equations do."""
    physical = simulation.physical
    if physical is None or physical.equations is None:
        return True
    start = np.array(physical.equations.start or [0.0] * len(physical.equations.states), dtype=float)
    rates = plant_function(physical.equations)(start, 0.0, physical.values)[: len(start)]
    speed = float(np.max(np.abs(simulation.plant.poles()), initial=0.0))
    size = max(float(np.max(np.abs(start), initial=0.0)), 1.0)
    return bool(np.max(np.abs(rates), initial=0.0) <= AT_REST * speed * size)
