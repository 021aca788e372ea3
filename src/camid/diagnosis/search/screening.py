"""Screen the catalogue: how much of the residual each effect would explain, to first order, with one simulation each.

A candidate changes the simulated output by s. What the plant's coefficients (and the effects already found) can imitate
of it is projected out, and the remainder r is compared with the residual e: adding the effect at the size that fits
best lowers the sum of squares by (r·e)²/(r·r). It is a score test (Rao 1948) with a finite step for the derivative. An
effect whose size is its shape is there as it is, and lowers it by 2 r·e − r·r.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.own_effect_trial import tried_guesses
from camid.effects.own_effects import own_effects_in_use, refuse_raised_by
from camid.effects.situation import Situation
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.fitting.unseen import unseen
from camid.side_by_side import side_by_side

Array = NDArray[np.float64]

# A change of the output of which less than this share is left beside the plant's coefficients is a change of them.
IMITATED = 1e-4
# The same where phases add up.
IMITATED_OVER_TIME = 5e-3
# Change of the output, as a share of its standard deviation, that is rounding.
ROUNDING = 1e-7
# Difference of two models' outputs, as a share of its standard deviation, within which effects do much the same beside
# both; and by how much two guesses of an effect may differ, as a share.
NEAR = 0.25
ALIKE = 0.1
# Candidates that are simulated again where what they do is known roughly, and numbers that are kept for that.
SIMULATED_AGAIN = 20
MOST_KEPT = 20_000_000
# Factor between the size of a guess and the one that fits best beyond which it is simulated again in that size, how
# often, and the gain from which it is: what has a threshold does something else at another size.
OTHER_SIZE = 3.0
MOST_SIZES = 3
LEAST_GAIN = 10.0
# Rows of a motion, until it runs away, from which an effect is guessed.
FEWEST_ROWS = 10
# The factor of a guess that is far too large.
MUCH_SMALLER = 0.1
# What an effect remembers at the start where one asks what that does, of at most one.
BEGUN = 0.5
# Gain from which a law with more detail is fitted though what the plainer one leaves is white: a chance of 1e-4.
LEAST_GAIN_OF_DETAIL = 15.0

# An effect and the number of its guess.
_Key = tuple[str, int]
# From an effect, what it changes, and what its memory at the start does.
_Judge = Callable[[Effect, Array, Array | None], "ScreenedEffect"]


@dataclass(frozen=True)
class ScreenedEffect:
    """An effect of one shape, and what the residual says about it.

    Attributes
    ----------
    effect : Effect
    gain : float
        By how much the sum of squares falls, in noise variances, in the metric that favours it more: chi-square
        with one degree of freedom if the effect is not there.
    factor : float
        Multiple of the effect's size that fits best, to first order.
    visible : float
        Size of what the coefficients cannot imitate, in standard deviations of the noise: the root of the gain to be
        expected if the effect were there at this size.
    """

    effect: Effect
    gain: float
    factor: float
    visible: float

    @property
    def start(self) -> Effect:
        """The effect as a fit begins with it: in the size that fits best to first order, where it has one."""
        return self.effect.scaled(self.factor) if self.factor and not self.effect.size_is_shape else self.effect


def trials(effect: type[Effect], problem: Problem) -> float:
    """How many different effects a search for this one amounts to."""
    rows = len(problem.output)
    return {"shapes": 1.0, "frames": float(rows), "frequencies": 0.5 * rows}[effect.trials]


def try_own_effects(problem: Problem, base: Fitted) -> None:
    """Try what a user's own effects do on the recordings: a screening drops guesses that fail.

    Raises
    ------
    InputError
        If their code raises an error, or returns what is no finite number or has another shape.
    """
    views = problem.situations(base.model)
    for kind in own_effects_in_use():
        if unseen(problem, kind) is not None:
            continue
        for guess in tried_guesses(kind, views.of(kind))[:1]:
            try:
                problem.rough().simulate_fitted(base.model.plus(guess))
            except (ValueError, ArithmeticError) as error:
                refuse_raised_by(kind, error)


def candidates(problem: Problem, base: Fitted) -> Iterator[Effect]:
    """All first guesses of the catalogue that are not in the model already."""
    views = problem.situations(base.model)
    present = {e.identifier for e in base.model.effects}
    for identifier, effect in sorted(known_effects().items()):
        if effect.noise_like or identifier in present:
            continue
        view = views.of(effect).while_finite()
        shown = len(view.time) >= FEWEST_ROWS and effect.invisible(view) is None
        if shown and problem.kind.unseen_beside(effect, base.model) is None:
            guesses = list(_possible(effect, view))
            yield from guesses
            # A dead zone before the limit of a rate and one behind it are two laws.
            if bends_input(effect) and any(bends_input(type(e)) for e in base.model.effects):
                yield from (guess.leading() for guess in guesses)


def bends_input(effect: type[Effect]) -> bool:
    """Whether an effect changes the input itself, so that the order of such effects matters."""
    return effect.transform is not Effect.transform and not effect.is_constant


def _possible(effect: type[Effect], view: Situation) -> Iterator[Effect]:
    """First guesses of an effect that its bounds allow."""
    guesses = effect.candidates(view)
    while True:
        try:
            yield next(guesses)
        except StopIteration:
            return
        except ValueError:  # the generator ends with it
            return


def signature(problem: Problem, base: Fitted, effect: Effect) -> Array | None:
    """Change of the simulated output on the fitted rows, shape (M,); None where the effect has no meaning here."""
    try:
        return _change(problem, base, base.model.plus(effect))
    except (ValueError, ArithmeticError):
        return None


def _change(problem: Problem, base: Fitted, model: Model) -> Array | None:
    """Change of the simulated output, shape (M,), by another model; None where that has no meaning."""
    try:
        simulated = problem.rough().simulate_fitted(model)
    except (ValueError, ArithmeticError):
        return None
    change = simulated - (problem.output - base.residual)
    return change if np.all(np.isfinite(change)) else None


def beginnings(problem: Problem, base: Fitted, effect: Effect, change: Array) -> Array | None:
    """What the memory of an effect at the start of each recording that begins in motion does, shape (M, c).

    ``change``, shape (M,), is that of the effect with none; None where it forgets everything before a recording.
    """
    plain = base.model.plus(effect)
    model = problem.with_states_of_effects(plain)
    if effect.largest_memory is None or model is plain:
        return None
    begun = [None if s is None else np.concatenate([s[:-1], [BEGUN]]) for s in model.initial]
    moved = _change(problem, base, replace(model, initial=tuple(begun)))
    if moved is None:
        return None
    runs = [run for run, state in enumerate(begun) if state is not None]
    rows = np.repeat(problem.runs, [np.count_nonzero(e.used) for e in problem.experiments])
    return (moved - change)[:, None] * (rows[:, None] == runs)


def may_be_more_than_chance(problem: Problem, fitted: Fitted, model: Model) -> bool:
    """Whether what a model's last effect does otherwise than a fitted model shows in what that one leaves.

    One simulation says so: a law may lack much where what it leaves depends on nothing that the past tells.
    """
    change = _change(problem, fitted, model)
    if change is None:
        return False
    begun = beginnings(problem, fitted, model.effects[-1], change)
    return _judged(problem, metrics(problem, fitted), model.effects[-1], change, begun).gain > LEAST_GAIN_OF_DETAIL


def projector(table: Array) -> Array:
    """Orthonormal basis of the columns, shape (M, r)."""
    lengths = np.linalg.norm(table, axis=0)
    table = table[:, lengths > 0.0] / lengths[lengths > 0.0]
    left, triangle = np.linalg.qr(table)
    return left[:, np.abs(np.diag(triangle)) > 1e-9]


@dataclass(frozen=True)
class Metric:
    """Residual and the basis of what is fitted, white or after the whitening filter of the noise.

    Where the noise is uneven, rows are divided by its relative standard deviation ``spread``, shape (M,), before.
    """

    whitening: Array
    basis: Array
    residual: Array
    variance: float
    spread: Array | None = None

    @classmethod
    def of(
        cls, problem: Problem, base: Fitted, whitening: Array, spread: Array | None = None, beside: Array | None = None
    ) -> Metric:
        """Metric of a fitted model; columns ``beside`` it, shape (M, c), are no sign of anything either."""
        rows = 1.0 if spread is None else spread
        # What a learned law could do is no sign of anything else, either.
        table = base.moving_sensitivities
        table = table if base.nuisance is None else np.hstack([table, base.nuisance])
        table = table if beside is None else np.hstack([table, beside])
        basis = projector(problem.whitened(table if spread is None else table / spread[:, None], whitening))
        residual = problem.whitened(base.residual / rows, whitening)
        residual = residual - basis @ (basis.T @ residual)
        freedom = max(len(residual) - basis.shape[1], 1)
        return cls(whitening, basis, residual, float(residual @ residual) / freedom, spread)

    def left(self, problem: Problem, change: Array) -> tuple[Array, float]:
        """What the coefficients cannot imitate of a change of the output, and the size of the whole."""
        whitened = problem.whitened(change, self.whitening)
        return whitened - self.basis @ (self.basis.T @ whitened), float(np.linalg.norm(whitened))


def metrics(problem: Problem, base: Fitted) -> list[Metric]:
    """White metric, and that of the noise if it is coloured."""
    found = [Metric.of(problem, base, np.ones(1))]
    if len(base.noise.whitening) > 1:
        found.append(Metric.of(problem, base, base.noise.whitening))
    return found


class Signatures:
    """What a screening found that each candidate does to the output, for screenings around similar models.

    Beside an effect that was found a candidate does to first order what it did without: only those that may matter
    there have to be simulated again.
    """

    def __init__(self) -> None:
        self._simulated: Array | None = None
        self._changes: dict[_Key, tuple[Effect, Array]] = {}

    def near(self, problem: Problem, base: Fitted, listed: Mapping[_Key, Effect]) -> dict[_Key, Array]:
        """Changes of the output, shapes (M,), by those candidates of which they are known around such a model."""
        if self._simulated is None or problem.kind.phases_add_up:
            return {}
        difference = problem.output - base.residual - self._simulated
        if float(np.std(difference)) > NEAR * problem.output_spread:
            return {}
        known = {key: self._changes[key] for key in listed if key in self._changes}
        return {key: change for key, (effect, change) in known.items() if alike(effect, listed[key])}

    def has_room(self, problem: Problem, count: int) -> bool:
        """Whether so many changes of the output may be remembered."""
        return count * len(problem.output) <= MOST_KEPT

    def keep(self, problem: Problem, base: Fitted, found: Mapping[_Key, tuple[Effect, Array]]) -> None:
        """Remember the changes of the output around a model."""
        self._simulated, self._changes = problem.output - base.residual, dict(found)


def alike(one: Effect, other: Effect) -> bool:
    """Whether two guesses of the same effect are about the same."""
    if type(one) is not type(other) or one.leads != other.leads:
        return False
    words = [{k: v for k, v in e.values.items() if isinstance(v, str)} for e in (one, other)]
    return words[0] == words[1] and bool(np.allclose(one.vector, other.vector, rtol=ALIKE, atol=0.0))


def screen(problem: Problem, base: Fitted, signatures: Signatures | None = None) -> list[ScreenedEffect]:
    """Every first guess with its gain, the highest first.

    Parameters
    ----------
    problem : Problem
    base : Fitted
    signatures : Signatures, optional
        Of earlier screenings of the same rows; what is simulated is added.
    """
    views = metrics(problem, base)
    listed = dict(_listed(candidates(problem, base)))
    known = signatures.near(problem, base, listed) if signatures else {}
    judge = partial(_judged, problem, views)
    # A change of the output is as long as the recordings: it is kept only where it will be wanted again.
    kept = signatures is not None and not known and signatures.has_room(problem, len(listed))

    roughly = {key: judge(listed[key], change, None) for key, change in known.items()}
    likely = sorted(roughly, key=lambda key: -roughly[key].gain)[:SIMULATED_AGAIN]
    # What a constant does beside a plant that is linear an offset does, too, and beside other effects something else.
    fresh = [key for key in listed if key not in known or key in likely or listed[key].is_constant]
    results = side_by_side(partial(_simulated, problem, base, judge, kept), [listed[key] for key in fresh])
    found = [(key, result) for key, result in zip(fresh, results, strict=True) if result]
    judged = [screened for _, (screened, _) in found]
    judged += [rough for key, rough in roughly.items() if key not in fresh]
    judged = side_by_side(partial(_resized, problem, base, judge), judged)
    if signatures is not None and kept:
        signatures.keep(problem, base, {k: (listed[k], change) for k, (_, change) in found if change is not None})
    return sorted(judged, key=lambda c: -c.gain)


def _simulated(
    problem: Problem, base: Fitted, judge: _Judge, kept: bool, effect: Effect
) -> tuple[ScreenedEffect, Array | None] | None:
    """A candidate as it is judged, and the change of the output where that is kept; None where it has no meaning."""
    change = signature(problem, base, effect)
    if change is None:
        return None
    begun = beginnings(problem, base, effect, change)
    return judge(effect, change, begun), change if kept and begun is None else None


def _resized(problem: Problem, base: Fitted, judge: _Judge, screened: ScreenedEffect) -> ScreenedEffect:
    """The candidate in the size that fits, where its guess was far from that and says less."""
    best = screened
    for _ in range(MOST_SIZES):
        factor = _other_size(best, len(base.residual))
        if factor is None:
            break
        try:
            effect = best.effect.scaled(factor)
        except ValueError:  # out of bounds
            break
        change = signature(problem, base, effect)
        again = None if change is None else judge(effect, change, beginnings(problem, base, effect, change))
        if again is None or again.gain <= best.gain:
            break
        best = again
    return best


def _other_size(screened: ScreenedEffect, count: int) -> float | None:
    """The factor by which another size of a guess may say more; None where it says what it can."""
    if screened.effect.size_is_shape:
        return None
    if screened.gain >= LEAST_GAIN and screened.factor > 0.0:
        return None if 1.0 / OTHER_SIZE < screened.factor < OTHER_SIZE else screened.factor
    # What changes the output by more than all that is missing may do so to either side.
    too_large = screened.effect.one_sided and screened.factor <= 0.0 and screened.visible**2 > count
    return MUCH_SMALLER if too_large else None


def _listed(effects: Iterator[Effect]) -> Iterator[tuple[_Key, Effect]]:
    """Candidates by name and number."""
    counts: dict[str, int] = {}
    for effect in effects:
        number = counts[effect.identifier] = counts.get(effect.identifier, 0) + 1
        yield (effect.identifier, number), effect


def _judged(
    problem: Problem, views: Sequence[Metric], effect: Effect, change: Array, begun: Array | None = None
) -> ScreenedEffect:
    """What the residual says about an effect that changes the output so, shape (M,), and by its memory so, (M, c)."""
    best = ScreenedEffect(effect, 0.0, 0.0, 0.0)
    if float(np.max(np.abs(change), initial=0.0)) <= ROUNDING * problem.output_spread:
        return best
    imitated = IMITATED_OVER_TIME if problem.kind.phases_add_up else IMITATED
    for view in views:
        rest, whole = view.left(problem, change)
        residual, gain = view.residual, 0.0
        if begun is not None:
            beside = projector(np.column_stack([view.left(problem, column)[0] for column in begun.T]))
            rest, known = rest - beside @ (beside.T @ rest), beside.T @ residual
            residual, gain = residual - beside @ known, float(known @ known)
        size = float(np.linalg.norm(rest))
        if size <= imitated * whole or view.variance <= 0.0:
            continue
        product = float(rest @ residual)
        factor = 1.0 if effect.size_is_shape else product / size**2
        gain += max(factor * (2.0 * product - factor * size**2), 0.0)
        remaining = max(float(view.residual @ view.residual) - gain, 1e-300) / max(len(rest) - 1, 1)
        if effect.one_sided and factor <= 0.0:
            gain = 0.0
        noise = max(view.variance - gain / len(rest), 1e-300)
        if gain / remaining >= best.gain:
            best = ScreenedEffect(effect, gain / remaining, factor, size / float(np.sqrt(noise)))
    return best
