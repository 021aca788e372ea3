"""Decide which effects a recording speaks for: forward, with exchange and backward removal, and what it cannot tell.

Hypotheses are held against each other by Bayes's criterion of the whole likelihood, the colour of the noise included,
so that coloured noise alone is one of them. An effect is taken in where the likelihood ratio would be exceeded by
chance, anywhere in the catalogue, in less than one recording of several hundred.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from camid.diagnosis.fit import Fitted, fit
from camid.diagnosis.problem import Problem
from camid.diagnosis.screen import WORKERS, Candidate, screen, trials
from camid.physics import known_effects

Progress = Callable[[str], None] | None

# Probability of naming an effect where nothing is missing, for the whole catalogue together.
FALSE_ALARM = 0.002
MOST_EFFECTS = 3
# Candidates that are fitted, and evaluations for a first and for a thorough fit.
MOST_CANDIDATES = 12
FIRST_STEPS = 8
ALL_STEPS = 30
# Candidates whose screened gain is below this share of the best, or this value, are not fitted.
LEAST_SHARE = 0.01
LEAST_GAIN = 8.0
# Hypotheses that stay behind the best by more than this are not fitted thoroughly.
BEHIND = 80.0
# Weight from which an alternative is worth naming, and how many effects a class may hold.
LEAST_WEIGHT = 0.01
LARGEST_CLASS = 4


@dataclass(frozen=True)
class Hypothesis:
    """An effect beside a base model, fitted.

    Attributes
    ----------
    identifier : str
    fitted : Fitted
        Its effect is the last of the model.
    criterion : float
        Bayes's criterion, with a penalty for a search over times or frequencies.
    """

    identifier: str
    fitted: Fitted
    criterion: float


@dataclass(frozen=True)
class Decision:
    """The effects taken in, each with the hypotheses that stood against it.

    Attributes
    ----------
    base, fitted : Fitted
        Without and with the effects.
    rivals : list of list of Hypothesis
        For each effect of the model: every hypothesis in its place, the best first, the effect itself among them.
    """

    base: Fitted
    fitted: Fitted
    rivals: list[list[Hypothesis]] = field(default_factory=list)


def p_value(problem: Problem, before: Fitted, after: Fitted, identifier: str) -> float:
    """Bound on the probability that an effect improves the likelihood as much where it is not."""
    from scipy.stats import chi2

    effect = known_effects()[identifier]
    ratio = before.noise.deviance - after.noise.deviance
    freedom = max(len(effect.numeric()), 1)
    count = sum(not e.noise_like for e in known_effects().values())
    return min(float(chi2.sf(ratio, freedom)) * trials(effect, problem) * count, 1.0)


def hypotheses(problem: Problem, base: Fitted, screened: Sequence[Candidate]) -> list[Hypothesis]:
    """The likeliest candidates, fitted together with the coefficients and everything in the base, the best first."""
    starts = _shortlist(screened)

    def fitted(candidate: Candidate, steps: int) -> Hypothesis | None:
        effect = candidate.effect.scaled(candidate.factor) if candidate.factor else candidate.effect
        return _fitted(problem, base, effect.identifier, base.model.plus(effect), steps)

    with ThreadPoolExecutor(WORKERS) as pool:
        first = [h for h in pool.map(lambda c: fitted(c, FIRST_STEPS), starts) if h is not None]
        best: dict[str, Hypothesis] = {}
        for hypothesis in first:
            known = best.get(hypothesis.identifier)
            if known is None or hypothesis.criterion < known.criterion:
                best[hypothesis.identifier] = hypothesis
        ranked = sorted(best.values(), key=lambda h: h.criterion)
        near = [h for h in ranked if h.criterion <= ranked[0].criterion + BEHIND] if ranked else []
        again = pool.map(
            lambda h: _fitted(problem, base, h.identifier, h.fitted.model, ALL_STEPS), near
        )
        thorough = [
            new if new is not None and new.criterion < old.criterion else old
            for old, new in zip(near, again, strict=True)
        ]
    return sorted([*thorough, *ranked[len(near) :]], key=lambda h: h.criterion)


def _fitted(problem: Problem, base: Fitted, identifier: str, start, steps: int) -> Hypothesis | None:  # type: ignore[no-untyped-def]
    try:
        result = fit(problem, start, steps=steps)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if not np.isfinite(result.noise.deviance):
        return None
    penalty = 2.0 * float(np.log(trials(known_effects()[identifier], problem)))
    return Hypothesis(identifier, result, result.criterion + penalty)


def _shortlist(screened: Sequence[Candidate]) -> list[Candidate]:
    """The two likeliest shapes of each of the likeliest effects."""
    if not screened:
        return []
    least = max(LEAST_GAIN, LEAST_SHARE * screened[0].gain)
    shapes: dict[str, list[Candidate]] = {}
    for candidate in screened:
        if candidate.gain >= least:
            known = shapes.setdefault(candidate.effect.identifier, [])
            if len(known) < 2:
                known.append(candidate)
    return [c for known in list(shapes.values())[:MOST_CANDIDATES] for c in known]


def decide(
    problem: Problem, base: Fitted, screened: Sequence[Candidate] | None = None, progress: Progress = None
) -> Decision:
    """Take in effects as long as each is called for, then test each against what could stand in its place.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        The refitted nominal model.
    screened : sequence of Candidate, optional
        Of the base, where it was screened already.
    progress : callable, optional
    """
    current, rivals = base, []
    while len(current.model.effects) < MOST_EFFECTS:
        if progress:
            found = ", ".join(e.identifier for e in current.model.effects)
            progress(f"fitting what may be missing{' besides ' + found if found else ''}")
        ranked = hypotheses(problem, current, screen(problem, current) if screened is None else screened)
        screened = None
        ranked = [h for h in ranked if h.criterion < current.criterion]
        if not ranked or p_value(problem, current, ranked[0].fitted, ranked[0].identifier) >= FALSE_ALARM:
            break
        current = ranked[0].fitted
        rivals.append(ranked)
    if len(current.model.effects) < 2:
        return Decision(base, current, rivals)
    return _exchanged(problem, base, current, progress)


def _exchanged(problem: Problem, base: Fitted, current: Fitted, progress: Progress) -> Decision:
    """Put every effect to the test beside the others, until none is exchanged or removed."""
    for _ in range(4):
        rivals: list[list[Hypothesis]] = []
        changed = False
        for index in range(len(current.model.effects)):
            identifier = current.model.effects[index].identifier
            if progress:
                progress(f"testing what could stand in place of {identifier}")
            others = fit(problem, current.model.without(index), steps=ALL_STEPS)
            own = Hypothesis(
                identifier,
                current,
                current.criterion + 2.0 * float(np.log(trials(known_effects()[identifier], problem))),
            )
            needed = p_value(problem, others, current, identifier) < FALSE_ALARM and own.criterion < others.criterion
            if not needed:
                current, changed = others, True
                break
            ranked = hypotheses(problem, others, screen(problem, others))
            ranked = sorted([own, *(h for h in ranked if h.identifier != identifier)], key=lambda h: h.criterion)
            if ranked[0].identifier != identifier and ranked[0].criterion < own.criterion - 2.0:
                current, changed = ranked[0].fitted, True
                break
            rivals.append(ranked)
        if not changed:
            return Decision(base, current, rivals)
    return Decision(base, current, rivals)


def weights(ranked: Sequence[Hypothesis], temperature: float = 1.0) -> list[tuple[str, float]]:
    """Posterior weights of a class, the likeliest first: at most four effects that the data do not rule out."""
    if not ranked:
        return []
    lead = ranked[0].criterion
    raw = [(h.identifier, float(np.exp(-0.5 * (h.criterion - lead) / temperature))) for h in ranked]
    total = sum(w for _, w in raw)
    kept = [(name, w / total) for name, w in raw if w / total >= LEAST_WEIGHT][:LARGEST_CLASS]
    total = sum(w for _, w in kept)
    return [(name, w / total) for name, w in kept]
