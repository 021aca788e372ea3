"""Which effects a recording speaks for: forward selection with swaps and backward removal, and what it cannot tell.

Hypotheses are held against each other by Bayes's criterion of the whole likelihood, the colour of the noise included,
so that coloured noise alone is one of them. An effect is taken in where the likelihood ratio would be exceeded by
chance, anywhere in the catalogue, in less than one recording of several hundred.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.hypothesis import Hypothesis, refuted
from camid.diagnosis.screening import Candidate, screen, trials
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.model import Model
from camid.fitting.problem import WORKERS, Problem

Array = NDArray[np.float64]
Progress = Callable[[str], None] | None

# Probability of naming an effect where nothing is missing, for the whole catalogue together.
FALSE_ALARM = 0.002
# The same for an effect beside others, whose law may not be exact.
FALSE_ALARM_BESIDE_OTHERS = 1e-4
MOST_EFFECTS = 3
MOST_SWAPS = 4
WORTH_A_SWAP = 2.0
# Candidates that are fitted, and evaluations for a first and for a thorough fit.
MOST_CANDIDATES = 12
# The same where phases add up, and the screening is a poor guide.
MORE_CANDIDATES = 20
MOST_FROM_NOMINAL = 7
MOST_BESIDE = 7
MOST_RIVALS = 5
FIRST_STEPS = 8
ALL_STEPS = 30
# Candidates whose screened gain is below this share of the best, or chance with this probability, are not fitted.
LEAST_SHARE = 0.01
MOST_CHANCE = 0.1
# Hypotheses whose criterion exceeds the best by more than this, or by this share of the best one's gain where phases
# add up, are not fitted thoroughly.
LARGEST_CRITERION_GAP = 50.0
LARGEST_GAP_SHARE = 0.6
MOST_THOROUGH = 6
# Error beside effects found already, as a share of the output's spread, from which fits start from the nominal
# coefficients, too.
NOMINAL_START_ERROR = 0.1
# Fall of the criterion that betrays another minimum of the coefficients, and how often the search restarts from one.
ANOTHER_MINIMUM = 10.0
MOST_RESTARTS = 3
# Sizes, as multiples of the fitted one, that are tried with the coefficients of the best hypothesis.
BORROWED_SIZES = (0.3, 1.0, 3.0, 10.0, 30.0)


@dataclass(frozen=True)
class Decision:
    """The effects taken in, each with the hypotheses that stood against it.

    Attributes
    ----------
    base, fitted : Fitted
        Without and with the effects.
    rivals : list of list of Hypothesis
        For each effect found: every hypothesis in its place, the best first, the effect itself among them.
    without : list of Fitted
        For each effect found: the model without it, fitted.
    """

    base: Fitted
    fitted: Fitted
    rivals: list[list[Hypothesis]] = field(default_factory=list)
    without: list[Fitted] = field(default_factory=list)


def p_value(problem: Problem, before: Fitted, after: Fitted, identifier: str) -> float:
    """Bound on the probability that an effect improves the likelihood as much where it is not."""
    from scipy.stats import chi2

    freedom = max(len(known_effects()[identifier].numeric()), 1)
    ratio = before.noise.deviance - after.noise.deviance
    return min(float(chi2.sf(ratio, freedom)) * searched(problem, identifier), 1.0)


def searched(problem: Problem, identifier: str) -> float:
    """How many hypotheses a search through the catalogue amounts to, from the view of one effect."""
    count = sum(not e.noise_like for e in known_effects().values())
    return trials(known_effects()[identifier], problem) * count


def hypotheses(
    problem: Problem,
    base: Fitted,
    screened: Sequence[Candidate],
    nominal: Model | None = None,
    most: int = MOST_CANDIDATES,
) -> list[Hypothesis]:
    """The likeliest candidates, fitted together with the coefficients and everything in the base, the best first.

    With ``nominal`` effects without parameters start from it, too: they may have bent the refitted model beyond repair.
    """
    # Beside a first effect the motion is followed, and the screening is a guide again.
    phases_add_up = problem.kind.phases_add_up and most == MOST_CANDIDATES
    starts = _shortlist(problem, screened, most, phases_add_up=phases_add_up)
    from_nominal = [] if nominal is None else _from_nominal(problem, nominal, screened)

    def fitted(candidate: Candidate, steps: int) -> Hypothesis | None:
        effect = candidate.effect.scaled(candidate.factor) if candidate.factor else candidate.effect
        return _fitted(problem, effect.identifier, base.model.plus(effect), steps, base)

    with ThreadPoolExecutor(WORKERS) as pool:
        steps = ALL_STEPS if phases_add_up else FIRST_STEPS
        first = [h for h in pool.map(lambda c: fitted(c, steps), starts) if h is not None]
        if nominal is not None:
            tried = pool.map(lambda e: _fitted(problem, e.identifier, nominal.plus(e), FIRST_STEPS), from_nominal)
            first += [h for h in tried if h is not None]
        first += _simpler(problem, base, first)
        best: dict[str, Hypothesis] = {}
        for hypothesis in first:
            known = best.get(hypothesis.identifier)
            if known is None or hypothesis.criterion < known.criterion:
                best[hypothesis.identifier] = hypothesis
        ranked = sorted(best.values(), key=lambda h: h.criterion)
        largest_gap = (
            max(LARGEST_CRITERION_GAP, LARGEST_GAP_SHARE * (base.criterion - ranked[0].criterion))
            if phases_add_up and ranked
            else LARGEST_CRITERION_GAP
        )
        near = [h for h in ranked[:MOST_THOROUGH] if h.criterion <= ranked[0].criterion + largest_gap]
        again = pool.map(lambda h: _fitted(problem, h.identifier, _start(problem, h, near[0]), ALL_STEPS), near)
        thorough = [
            new if new is not None and new.criterion < old.criterion else old
            for old, new in zip(near, again, strict=True)
        ]
    return sorted([*thorough, *ranked[len(near) :]], key=lambda h: h.criterion)


def _from_nominal(problem: Problem, nominal: Model, screened: Sequence[Candidate]) -> list[Effect]:
    """Effects that a fit should start with from the nominal coefficients, which they may have bent beyond repair.

    Those without parameters, and those that the residual of the nominal model speaks for.
    """
    effects = [c.effect for c in screened if not c.effect.parameters]
    present = {e.identifier for e in effects}
    for candidate in screen(problem, evaluate(problem, nominal)):
        if candidate.effect.identifier not in present and len(effects) < MOST_FROM_NOMINAL:
            present.add(candidate.effect.identifier)
            effects.append(candidate.effect.scaled(candidate.factor) if candidate.factor else candidate.effect)
    return effects


def _simpler(problem: Problem, base: Fitted, fitted: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Special cases of what was fitted, from where that fit ended."""
    present = {e.identifier for e in base.model.effects}
    found = []
    for hypothesis in fitted:
        model = hypothesis.fitted.model
        effect = model.effects[-1].simplified()
        if effect is not None and effect.identifier not in present:
            start = replace(model, effects=(*model.effects[:-1], effect))
            found.append(_fitted(problem, effect.identifier, start, FIRST_STEPS))
    return [h for h in found if h is not None]


def _start(problem: Problem, hypothesis: Hypothesis, best: Hypothesis) -> Model:
    """Where a thorough fit starts: where the first one ended, or from coefficients and states of the best hypothesis.

    A first fit may have stopped in a local minimum in which the coefficients imitate what the effect should do.
    """
    own = hypothesis.fitted.model
    if hypothesis is best:
        return own
    borrowed = best.fitted.model
    starts = [own]
    for factor in BORROWED_SIZES:
        try:
            effect = own.effects[-1].scaled(factor)
        except ValueError:
            continue
        starts.append(replace(borrowed, effects=(*borrowed.effects[:-1], effect)))
    costs = []
    for start in starts:
        try:
            pinned = problem.pinned(start, finest=False)
            residual = problem.output - problem.fitted(pinned.simulate(start))
            costs.append(float(residual @ residual))
        except (ValueError, ArithmeticError):
            costs.append(np.inf)
    return starts[int(np.argmin(np.nan_to_num(costs, nan=np.inf)))]


def _fitted(
    problem: Problem, identifier: str, start: Model, steps: int, base: Fitted | None = None
) -> Hypothesis | None:
    try:
        result = fit(problem, start, steps=steps, base=base, refreshes=0 if base else 3, finest=base is None)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if not np.isfinite(result.noise.deviance):
        return None
    penalty = 2.0 * float(np.log(trials(known_effects()[identifier], problem)))
    return Hypothesis(identifier, result, result.criterion + penalty)


def _shortlist(
    problem: Problem, screened: Sequence[Candidate], most: int, *, phases_add_up: bool = False
) -> list[Candidate]:
    """The likeliest shapes of each of the likeliest effects, of those that may be more than chance.

    Two of each at first, and one where other effects are known already.
    """
    from scipy.stats import chi2

    if not screened:
        return []
    least = 0.0 if phases_add_up else LEAST_SHARE * screened[0].gain
    distinct = MORE_CANDIDATES if phases_add_up else most
    count = len({c.effect.identifier for c in screened})
    shapes: dict[str, list[Candidate]] = {}
    for candidate in screened:
        chance = float(chi2.sf(candidate.gain, 1)) * trials(type(candidate.effect), problem) * count
        if candidate.gain >= least and chance < MOST_CHANCE:
            known = shapes.setdefault(candidate.effect.identifier, [])
            if len(known) < (2 if most == MOST_CANDIDATES else 1):
                known.append(candidate)
    return [c for known in list(shapes.values())[:distinct] for c in known]


def select_effects(
    problem: Problem,
    base: Fitted,
    screened: Sequence[Candidate] | None = None,
    validation: Sequence[NDArray[np.bool_]] | None = None,
    progress: Progress = None,
    nominal: Model | None = None,
) -> Decision:
    """Take in effects as long as each is called for, then test each against what could stand in its place.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        The refitted nominal model.
    screened : sequence of Candidate, optional
        Of the base, where it was screened already.
    validation : sequence of ndarray of bool, optional
        Rows of each recording on which an effect must not make the errors larger.
    progress : callable, optional
    nominal : Model, optional
        As the simulation says, without effects.
    """
    current, rivals, restarts = base, [], 0
    known = len(base.model.effects)
    while len(current.model.effects) - known < MOST_EFFECTS:
        if progress:
            names = ", ".join(e.identifier for e in current.model.effects)
            progress(f"fitting what may be missing{' besides ' + names if names else ''}")
        found = screen(problem, current) if screened is None else screened
        beside = len(current.model.effects) > known
        ranked = hypotheses(
            problem,
            current,
            found,
            _nominal_start(problem, current, nominal),
            MOST_BESIDE if beside else MOST_CANDIDATES,
        )
        screened = None
        ranked = [
            h for h in ranked if h.criterion < current.criterion and not _refuted(problem, current, h, validation)
        ]
        level = FALSE_ALARM_BESIDE_OTHERS if beside else FALSE_ALARM
        if not ranked or p_value(problem, current, ranked[0].fitted, ranked[0].identifier) >= level:
            break
        without_effect = _without_its_effect(problem, ranked[0])
        if without_effect.criterion < current.criterion - ANOTHER_MINIMUM and restarts < MOST_RESTARTS:
            # The effect had led the coefficients out of a local minimum: it has to explain what the better ones leave.
            current, restarts = without_effect, restarts + 1
            base = base if beside else without_effect
            continue
        current = ranked[0].fitted
        rivals.append(ranked)
    if len(current.model.effects) - known < 2:
        return Decision(base, current, rivals, [base] * len(rivals))
    return _swapped(problem, base, current, progress)


def _nominal_start(problem: Problem, current: Fitted, nominal: Model | None) -> Model | None:
    """The nominal model with the effects found, as a start beside the refitted one where that is still far off."""
    if nominal is None or not current.model.effects:
        return nominal
    if current.cost < NOMINAL_START_ERROR**2 * float(np.var(problem.output)) * len(current.residual):
        return None
    return replace(nominal, effects=current.model.effects)


def _without_its_effect(problem: Problem, hypothesis: Hypothesis) -> Fitted:
    """What the coefficients of a hypothesis come to without its effect."""
    model = hypothesis.fitted.model
    return fit(problem, model.without(len(model.effects) - 1), steps=ALL_STEPS)


def _refuted(
    problem: Problem, current: Fitted, hypothesis: Hypothesis, validation: Sequence[NDArray[np.bool_]] | None
) -> bool:
    """Whether the rows that were not fitted speak against an effect."""
    if validation is None:
        return False
    before, after = (
        [(e.output - s)[r] for e, s, r in zip(problem.experiments, problem.simulate(model), validation, strict=True)]
        for model in (current.model, hypothesis.fitted.model)
    )
    effect = hypothesis.fitted.model.effects[-1]
    expected = (current.cost - hypothesis.fitted.cost) / len(current.residual)
    noise = hypothesis.fitted.cost / len(current.residual)
    return refuted(expected, noise, before, after, bool(effect.breaks() or effect.impulses()))


def _swapped(problem: Problem, base: Fitted, current: Fitted, progress: Progress) -> Decision:
    """Put every effect to the test beside the others, until none is swapped or removed."""
    first = len(base.model.effects)
    rivals: list[list[Hypothesis]] = []
    without: list[Fitted] = []
    for _ in range(MOST_SWAPS):
        rivals, without = [], []
        changed = False
        for index in range(first, len(current.model.effects)):
            identifier = current.model.effects[index].identifier
            if progress:
                progress(f"testing what could stand in place of {identifier}")
            others = fit(problem, current.model.without(index), steps=ALL_STEPS)
            own = Hypothesis(
                identifier,
                current,
                current.criterion + 2.0 * float(np.log(trials(known_effects()[identifier], problem))),
            )
            if (
                p_value(problem, others, current, identifier) >= FALSE_ALARM_BESIDE_OTHERS
                or own.criterion >= others.criterion
            ):
                current, changed = others, True
                break
            ranked = hypotheses(problem, others, screen(problem, others), most=MOST_RIVALS)
            ranked = sorted([own, *(h for h in ranked if h.identifier != identifier)], key=lambda h: h.criterion)
            if ranked[0].criterion < own.criterion - WORTH_A_SWAP:
                current, changed = ranked[0].fitted, True
                break
            rivals.append(ranked)
            without.append(others)
        if not changed:
            break
    for index in range(first + len(rivals), len(current.model.effects)):  # the last swap was not tested itself
        without.append(fit(problem, current.model.without(index), steps=ALL_STEPS))
        identifier = current.model.effects[index].identifier
        rivals.append([Hypothesis(identifier, current, current.criterion)])
    return Decision(base, current, rivals, without)
