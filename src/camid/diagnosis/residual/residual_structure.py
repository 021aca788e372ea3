"""What is left of a residual: whether it is more than noise, and how much of the mismatch that is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.residual.mismatch_location import PlaceTest
from camid.diagnosis.residual.noise_recognition import depends_on_position, force_like
from camid.diagnosis.residual.validation_rows import without_outliers
from camid.diagnosis.swinging_coefficient import Swing
from camid.effects import known_effects
from camid.fitting.fit import Fitted, evaluate
from camid.fitting.problem import Problem

# A p-value below this means structure; with the tests of all places and the catalogue's own threshold about three
# recordings in a thousand alarm although nothing is missing.
STRUCTURE_P_VALUE = 2e-4
# Reason of a coefficient that swings in time.
SWING = "swing"
# Noise whose variance changes with the position is common in images and called structure only beyond this p-value.
UNEVEN_P_VALUE = 1e-8
# Squared errors on validation rows are suspicious from this ratio to those on fitted rows on, if beyond this many
# standard errors.
LARGER_ERROR_RATIO = 1.2
LARGER_STANDARD_ERRORS = 5.0
# The same ratio from which effects that were named do not carry over, however few independent errors say so.
FAILED_ERROR_RATIO = 3.0
LONGEST_CORRELATION = 200
# What is left over what its past does not tell of it (sums of squares) from which it is smooth: beside effects that are
# named that is rather what their laws have inexactly, where a test of a place is hardly chance either.
SMOOTH, HINT = 30.0, 1e-2
# Share of the output's variance that coloured noise may be.
LARGEST_NOISE_SHARE = 0.5


def reasons_for_structure(
    problem: Problem,
    final: Fitted,
    after: Sequence[PlaceTest],
    validation: Sequence[NDArray[np.bool_]],
    recognised: set[str],
    swing: Swing | None,
) -> list[str]:
    """Which tests say that what is left is more than noise."""
    reasons = [t.place for t in after if t.p_value < STRUCTURE_P_VALUE]
    kinds = [known_effects()[identifier] for identifier in recognised]
    coloured = any(kind.colours_noise for kind in kinds)
    if coloured and force_like(problem, final):
        reasons.append("resonance")
    if coloured and final.model.effects and _is_smooth(problem, final) and any(t.p_value < HINT for t in after):
        reasons.append("smooth")
    if swing is not None and swing.p_value < STRUCTURE_P_VALUE:
        reasons.append(SWING)
    if _larger_on_validation_rows(problem, final, validation):
        reasons.append("validation")
    if coloured and final.cost > LARGEST_NOISE_SHARE * float(np.var(problem.recorded)) * len(final.residual):
        reasons.append("misfit")  # coloured noise that is most of the output is a model that does not fit
    if not any(kind.makes_variance_uneven for kind in kinds) and depends_on_position(problem, final) < UNEVEN_P_VALUE:
        reasons.append("variance")
    return reasons


def _is_smooth(problem: Problem, final: Fitted) -> bool:
    """Whether nearly all of what a model leaves follows from its own past, as a motion does, and noise hardly."""
    innovations = problem.whitened(final.residual, final.noise.whitening)
    return final.cost > SMOOTH * float(innovations @ innovations)


def _larger_on_validation_rows(problem: Problem, final: Fitted, validation: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether errors on rows that were not fitted are larger than on those that were, beyond chance.

    Isolated values do not count, because a sensor makes them; nor does what only the running median shows, whose
    square scatters more than that of noise.
    """
    raw = problem.errors(final.model, validation)
    errors, residual = without_outliers(raw), without_outliers(final.residual)
    noise = max(float(np.mean(residual**2)), 1e-300)
    if float(np.mean(errors**2)) < LARGER_ERROR_RATIO * noise:
        return False
    uncertain = _variance_of_prediction(final, validation)
    ratio = float(np.mean(errors**2)) / (noise + uncertain)
    ratio = min(ratio, float(np.mean(raw**2)) / (max(float(np.mean(final.residual**2)), 1e-300) + uncertain))
    if ratio > FAILED_ERROR_RATIO and final.model.effects:
        return True
    spectrum = np.abs(np.fft.rfft(residual, 2 * len(residual))) ** 2
    correlations = np.fft.irfft(spectrum)[: min(len(residual) - 1, LONGEST_CORRELATION) + 1]
    correlations = correlations / correlations[0]
    effective = 1.0 + 2.0 * float(correlations[1:] @ correlations[1:])
    # The square of a Gaussian scatters by √2 of itself.
    spread = np.sqrt(2.0 * effective * (1.0 / len(errors) + 1.0 / len(residual)))
    return bool(ratio - 1.0 > LARGER_STANDARD_ERRORS * spread)


def _variance_of_prediction(final: Fitted, validation: Sequence[NDArray[np.bool_]]) -> float:
    """Mean square of the error that uncertain coefficients make on rows that were not fitted."""
    table = evaluate(final.problem.with_used(list(validation)), final.model).sensitivities
    covariance = final.covariance
    known = np.isfinite(np.diag(covariance))
    table, covariance = table[:, known], covariance[np.ix_(known, known)]
    return float(np.sum((table @ covariance) * table)) / max(len(table), 1)


def share_left(
    base: Fitted, final: Fitted, after: Sequence[PlaceTest], reasons: Sequence[str], fits: NormalisedErrors
) -> float:
    """Share of the refitted mismatch that a model leaves, where that is more than noise."""
    if not reasons or reasons == ["variance"]:
        return 0.0
    left = _left(base, final, after)
    if {"resonance", "smooth", SWING} & set(reasons):  # what drives it is all of what is left
        left = min(final.cost / max(base.cost, 1e-300), 1.0)
    if "validation" in reasons and fits.refitted > fits.noise_floor:
        excess = fits.improved**2 - fits.noise_floor**2
        left = max(left, min(max(excess / (fits.refitted**2 - fits.noise_floor**2), 0.0), 1.0))
    return left


def _left(base: Fitted, final: Fitted, after: Sequence[PlaceTest]) -> float:
    """Share of the refitted mismatch, noise subtracted, that the model found leaves."""
    structured = max(t.share for t in after) * final.cost
    noise = final.cost - structured
    return float(min(max(structured / max(base.cost - noise, 1e-300), 0.0), 1.0))
