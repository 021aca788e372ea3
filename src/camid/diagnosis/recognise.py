"""Recognise effects that change the noise: repeated frames, outliers, jitter, quantisation, and noise that is coloured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.fit import Fitted
from camid.diagnosis.problem import Problem
from camid.diagnosis.result import Finding
from camid.diagnosis.verdict import recognised
from camid.physics import known_effects
from camid.physics.effect import Effect, Recognition
from camid.physics.noise import ColouredNoise

# A noise-like effect is named where its absence would show as much in fewer recordings than this.
RECOGNISED = 1e-4
# Those whose rows say nothing of the motion, whatever the model.
SPOILING = ("dropped-frames", "outliers")


def spoiled_rows(problem: Problem, base: Fitted) -> list[NDArray[np.bool_]]:
    """Rows of each recording to leave out: repeated frames, and isolated residuals far off."""
    result = []
    for index in range(len(problem.experiments)):
        situation = problem.situation(base.model, index)
        rows = np.zeros(len(situation.time), bool)
        for identifier in SPOILING:
            found = known_effects()[identifier].recognise(situation)
            if found is not None and found.p_value < RECOGNISED:
                rows |= found.spoiled
        result.append(rows)
    return result


def noise_findings(
    whole: Problem, problem: Problem, final: Fitted, declared: Sequence[Effect]
) -> tuple[list[Finding], list[tuple[Effect, dict[str, float | None]]]]:
    """Noise-like effects that are not declared already, and the same as the improved simulation declares them.

    Parameters
    ----------
    whole, problem : Problem
        With and without the rows that say nothing of the motion.
    final : Fitted
        The improved model.
    declared : sequence of Effect
        Of the nominal simulation.
    """
    known = {e.identifier for e in declared}
    situation = whole.situation(final.model)
    found: list[Recognition] = []
    for identifier, effect in sorted(known_effects().items()):
        if effect.noise_like and identifier not in known and effect is not ColouredNoise:
            recognition = effect.recognise(situation)
            if recognition is not None and recognition.p_value < RECOGNISED:
                found.append(recognition)
    if ColouredNoise.identifier not in known:
        p_value = problem.whiteness(final.residual, final.sensitivities)
        if p_value < RECOGNISED and len(final.noise.whitening) > 1:
            found.append(_coloured(problem, final, p_value))
    findings = [recognised(r) for r in found]
    effects: list[tuple[Effect, dict[str, float | None]]] = [(r.effect, dict(r.standard_deviations)) for r in found]
    return findings, [*((e, {}) for e in declared if e.noise_like), *effects]


def _coloured(problem: Problem, final: Fitted, p_value: float) -> Recognition:
    """The autoregression of the residual, with standard deviations of its coefficients (Ljung 1999, section 9.4)."""
    coefficients = -final.noise.whitening[1:]
    rows = np.lib.stride_tricks.sliding_window_view(final.residual, len(coefficients))
    innovations = problem.whitened(final.residual, final.noise.whitening)
    variance = float(np.mean(innovations**2))
    covariance = variance * np.linalg.pinv(rows.T @ rows)
    deviations = np.sqrt(np.diag(covariance))[::-1]
    effect = ColouredNoise(spectrum=coefficients.tolist())
    spoiled = np.zeros(len(problem.times[0]), bool)
    return Recognition(effect, {"spectrum": deviations.tolist()}, p_value, spoiled)  # type: ignore[dict-item]
