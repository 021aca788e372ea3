"""Rivals that a diagnosis does not list: it names four effects at most, and a fifth may be hardly less likely.

An experiment that tells the listed names apart may suit another one that was left out. The catalogue is therefore
screened once more on the earlier recordings, and what fits them nearly as well is a rival, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from camid.diagnosis.search.hypothesis import prior_penalty
from camid.diagnosis.search.hypothesis_fit import fitted_hypothesis
from camid.diagnosis.search.screening import screen
from camid.effects.base import Effect
from camid.effects.special_cases import special_case
from camid.experiment_design.hypothesis import Hypothesis
from camid.experiment_design.other_values import around
from camid.experiment_design.together import Earlier, Together
from camid.fitting.fit import Fitted, evaluate

# Effects that are fitted, evaluations of each, those that become rivals, and by how much their criterion may exceed
# that of the likeliest: a weight of a thousandth.
TRIED, STEPS, KEPT, MOST_GAP = 10, 12, 4, 14.0


def left_out(hypotheses: Sequence[Hypothesis], earlier: Earlier, sums: Sequence[float]) -> list[Hypothesis]:
    """Rivals of the names, with a weight of zero, the likeliest first.

    Parameters
    ----------
    hypotheses : sequence of Hypothesis
    earlier : Earlier
    sums : sequence of float
        What the hypotheses leave of the earlier recordings, in variances of the noise.
    """
    found: list[Hypothesis] = []
    for without in hypotheses:
        named = [(h, s) for h, s in zip(hypotheses, sums, strict=True) if _is_name(h, without)]
        if without.identifier or not named:
            continue
        lead, least = min(named, key=lambda pair: pair[0].criterion)
        try:
            whole = Together(without, earlier)
            vector = whole.start if earlier.at_rest else whole.least(whole.start, STEPS)[0]
            base = evaluate(whole.problem, whole.packing.unpack(vector))
            screened = screen(whole.problem, base)
        except (ValueError, ArithmeticError, np.linalg.LinAlgError):
            continue
        present = {h.identifier for h, _ in named} | {e.identifier for e in without.model.effects}
        effects: dict[str, Effect] = {}
        for candidate in screened:
            effect = candidate.effect.scaled(candidate.factor) if candidate.factor > 0.0 else candidate.effect
            simple = special_case(effect)
            # A law that is more general than a name stays behind it whatever is played.
            if effect.identifier not in present and not (simple and simple.identifier in present):
                effects.setdefault(effect.identifier, effect)
        rivals = [_rival(e, without, base, (lead, least), earlier) for e in list(effects.values())[:TRIED]]
        near = [r for r in rivals if r is not None and r.criterion - lead.criterion < MOST_GAP]
        found += sorted(near, key=lambda r: r.criterion)[:KEPT]
    return found


def _is_name(hypothesis: Hypothesis, without: Hypothesis) -> bool:
    return bool(hypothesis.identifier) and hypothesis.question == without.question


def _rival(
    effect: Effect, without: Hypothesis, base: Fitted, likeliest: tuple[Hypothesis, float], earlier: Earlier
) -> Hypothesis | None:
    """An effect as a rival, fitted to the earlier recordings; None where that fails."""
    lead, least = likeliest
    fitted = fitted_hypothesis(base.problem, effect.identifier, base.model.plus(effect), STEPS, base)
    if fitted is None or lead.effect is None:
        return None
    model = replace(fitted.fitted.model, initial=without.model.initial)
    named = replace(without, identifier=effect.identifier, weight=0.0, model=model, known={})
    try:
        whole = Together(named, earlier)
        vector = whole.start if earlier.at_rest else whole.least(whole.start, STEPS)[0]
        rival = replace(around(whole, vector, whole.cost(vector)), variant=False, held=frozenset())
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    rows, cost = len(whole.recorded), whole.cost(vector)
    gap = rows * log(cost / least) + (rival.count - lead.count) * log(rows)
    gap += fitted.penalty - prior_penalty(base.problem, lead.effect)
    return replace(rival, criterion=lead.criterion + gap, misfit=lead.misfit + cost - least)
