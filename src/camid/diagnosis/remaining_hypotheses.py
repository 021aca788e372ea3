"""What a diagnosis leaves possible: each name with its own fitted simulation, for the design of the next experiment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.finding import Finding
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.verdict import different_inputs
from camid.diagnosis.weights import LEAST_WEIGHT, UNLISTED
from camid.effects.base import Effect
from camid.effects.declared import declared
from camid.effects.special_cases import same_in_place
from camid.fitting.fit import Fitted, evaluate
from camid.fitting.problem import Problem
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Name of the only hypothesis where a diagnosis names no effect.
IMPROVED = "improved"


@dataclass(frozen=True)
class RemainingHypothesis:
    """A simulation that a diagnosis does not exclude.

    Attributes
    ----------
    identifier : str or None
        Its name for the effect in question; None for the simulation without it, which the others are measured by.
    weight : float
        As the diagnosis states it.
    instead_of : str
        Identifier of the finding that it is a name for.
    simulation : Simulation
        With its own coefficients; every effect is declared as one, so that all its parameters may be fitted again.
    parameters : list of str
        What was fitted: coefficients by their number, an effect's parameters after its identifier, constants.
    information : list of list of float
        Fisher information of these from the rows fitted, without what initial states took of it; in their own units.
    criterion : float
        By how much its criterion exceeds that of the finding, its prior included.
    misfit : float
        By how much its sum of squares exceeds that of the finding, in variances of the noise.
    """

    identifier: str | None
    weight: float
    instead_of: str
    simulation: Simulation
    parameters: list[str]
    information: list[list[float]]
    criterion: float = 0.0
    misfit: float = 0.0

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        return {
            "id": self.identifier,
            "weight": self.weight,
            "instead_of": self.instead_of,
            "simulation": self.simulation.to_mapping(),
            "parameters": self.parameters,
            "information": self.information,
            "criterion": self.criterion,
            "misfit": self.misfit,
        }


@dataclass(frozen=True)
class Conditions:
    """How the recordings of a diagnosis were made.

    Attributes
    ----------
    period, duration : float
        Seconds; the duration is that of the longest recording.
    rows : int
        That were fitted.
    experiments : int
        How many of the recordings have inputs of their own.
    largest_step : float
        Between two input samples.
    signal, output : tuple of float
        Least and largest input and recorded output.
    noise : float
        Standard deviation of the innovations of the output's noise, in its units.
    whitening : list of float
        Filter that makes the noise white.
    """

    period: float
    duration: float
    rows: int
    experiments: int
    largest_step: float
    signal: tuple[float, float]
    output: tuple[float, float]
    noise: float
    whitening: list[float]

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        return {
            "period": self.period,
            "duration": self.duration,
            "rows": self.rows,
            "experiments": self.experiments,
            "input": {"low": self.signal[0], "high": self.signal[1], "largest_step": self.largest_step},
            "output": {"low": self.output[0], "high": self.output[1]},
            "noise": {"standard_deviation": self.noise, "whitening": self.whitening},
        }


def conditions_of(problem: Problem, final: Fitted) -> Conditions:
    """The conditions of recordings, with the noise that a model leaves."""
    signals = [e.signal for e in problem.experiments]
    steps = [float(np.max(np.abs(np.diff(s, prepend=0.0)), initial=0.0)) for s in signals]
    innovations = problem.whitened(final.residual, final.noise.whitening)
    return Conditions(
        float(problem.acquisition.period),
        problem.duration + float(problem.acquisition.period),
        len(final.residual),
        different_inputs(problem),
        max(steps),
        (float(min(s.min() for s in signals)), float(max(s.max() for s in signals))),
        (float(np.min(problem.recorded)), float(np.max(problem.recorded))),
        float(np.sqrt(innovations @ innovations / max(len(innovations) - len(final.packing.names), 1))),
        [float(a) for a in final.noise.whitening],
    )


def remaining(
    believed: Simulation, problem: Problem, decision: Decision, found: Sequence[Finding], noise: Conditions
) -> list[RemainingHypothesis]:
    """Simulations of all names that the findings leave possible; the improved one alone where there is one name.

    Parameters
    ----------
    believed : Simulation
    problem : Problem
    decision : Decision
        Its rivals stand in the order of the effects of the fitted model.
    found : sequence of Finding
    noise : Conditions
    """
    result: list[RemainingHypothesis] = []
    for rivals, without in zip(decision.rivals, decision.without, strict=False):
        models = {h.identifier: h for h in (*_same(problem, decision.fitted, rivals[0].identifier), *reversed(rivals))}
        finding = next((f for f in found if f.identifier in models and f.comparison is not None), None)
        if finding is None or not any(name != UNLISTED for name, _ in finding.alternatives):
            continue
        lead = replace(models[finding.identifier], fitted=decision.fitted)
        models[finding.identifier] = lead
        weights = [(finding.identifier, finding.weight), *finding.alternatives]
        named = [(models[name], weight) for name, weight in weights if name in models and weight >= LEAST_WEIGHT]
        if len(named) > 1:
            class_ = _Class(believed, problem, noise, lead)
            result += [class_.hypothesis(h, weight) for h, weight in named]
            result.append(class_.hypothesis(Hypothesis("", without), 0.0))
    if not result:
        name = found[0].identifier if found else IMPROVED
        lead = Hypothesis(name, decision.fitted)
        result = [_Class(believed, problem, noise, lead).hypothesis(lead, found[0].weight if found else 1.0)]
    return result


def _same(problem: Problem, fitted: Fitted, identifier: str) -> list[Hypothesis]:
    """Laws that are exactly one of a model's effects in these recordings, as another experiment may show."""
    effects = fitted.model.effects
    place = next((i for i, effect in enumerate(effects) if effect.identifier == identifier), None)
    if place is None:
        return []
    laws = same_in_place(effects[place], problem.situations(fitted.model).of)
    return [Hypothesis(law.identifier, evaluate(problem, fitted.model.replaced(place, law))) for law in laws]


@dataclass(frozen=True)
class _Class:
    """What the names of one effect have in common."""

    believed: Simulation
    problem: Problem
    noise: Conditions
    lead: Hypothesis

    def hypothesis(self, hypothesis: Hypothesis, weight: float) -> RemainingHypothesis:
        """One of them as it is written."""
        fitted, kind = hypothesis.fitted, self.problem.kind
        effects = fitted.model.effects
        written = kind.written_back(self.believed, self.problem.structure, fitted)
        simulation = replace(written, effects=declared(effects, [{} for _ in effects]), remainder=None)
        parameters, information = information_of(fitted, self.noise)
        return RemainingHypothesis(
            hypothesis.identifier or None,
            weight,
            self.lead.identifier,
            simulation,
            parameters,
            information.tolist(),
            float(hypothesis.beyond(self.lead)),
            float(fitted.cost - self.lead.fitted.cost) / (self.noise.noise**2 or 1.0),
        )


def information_of(fitted: Fitted, noise: Conditions) -> tuple[list[str], Array]:
    """Names of the parameters of a fit, and their Fisher information, shape (p, p), without the initial states."""
    whitened = fitted.problem.whitened(fitted.sensitivities, np.asarray(noise.whitening)) / (noise.noise or 1.0)
    products = whitened.T @ whitened
    names = stable_names(fitted.packing.names, fitted.model.effects)
    kept = np.array([not name.startswith("initial ") for name in names], bool)
    information = products[np.ix_(kept, kept)]
    if not kept.all():
        across = products[np.ix_(kept, ~kept)]
        information = information - across @ np.linalg.pinv(products[np.ix_(~kept, ~kept)], hermitian=True) @ across.T
    return [n for n, k in zip(names, kept, strict=True) if k], 0.5 * (information + information.T)


def stable_names(names: Sequence[str], effects: Sequence[Effect]) -> list[str]:
    """Names of packed parameters, an effect's behind its identifier instead of its place in the model."""
    found = []
    for name in names:
        head, _, tail = name.partition(" ")
        found.append(f"{effects[int(head)].identifier} {tail}" if head.isdigit() else name)
    return found
