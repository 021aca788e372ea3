"""The rules of the diagnosis, and what stands in the place of each where it is left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from camid.diagnosis.search.beginnings_in_a_loop import Beginning
from camid.diagnosis.search.decision import Decision

ALL_RULES = "all rules"


@dataclass(frozen=True)
class Part:
    """What stands in the place of a function or constant, and whether the function did anything.

    Attributes
    ----------
    instead : object
    did : callable, optional
        Says so of what it returned and was called with; None of a constant, which may always do something.
    """

    instead: Any
    did: Callable[[Any, tuple[Any, ...]], bool] | None = None


def _found(found: Any, _: tuple[Any, ...]) -> bool:
    return bool(found)


def _found_one(found: Any, _: tuple[Any, ...]) -> bool:
    return found is not None


# A function of a problem and a decision, or a fitted model, that changes it or not.
KEPT = Part(lambda problem, kept, *_, **__: kept, lambda found, arguments: found is not arguments[1])
NONE = Part(lambda *_, **__: [], _found)
NOTHING = Part(lambda *_, **__: None, _found_one)
NEVER = Part(lambda *_, **__: False, _found)
NOT_ONE = Part(lambda *_, **__: set(), _found)
BEGUN_WITH_NOTHING = Part(
    lambda *_, **__: Beginning(),
    lambda found, _: found.decision is not None or bool(found.models) or found.runs_away,
)
WITHOUT_LAWS = Part(lambda problem, base, *_, **__: Decision(base, base), lambda found, _: bool(found.laws))
SAME_NAMES = Part(lambda *same: same, lambda found, arguments: found[0] is not arguments[0])


def _rule(**parts: Part) -> dict[str, Part]:
    """A rule whose parts are names in modules of camid.diagnosis, with two underscores for each dot."""
    return {f"camid.diagnosis.{name.replace('__', '.')}": part for name, part in parts.items()}


RULES: dict[str, dict[str, Part]] = {
    ALL_RULES: {},
    # what a search begins with
    "what the plant's equation shows in a loop": _rule(
        run__first_beginning=BEGUN_WITH_NOTHING, decided__first_beginning=BEGUN_WITH_NOTHING
    ),
    "an observer": _rule(run___pulled=NOTHING),
    "no observer any more where the plant follows": _rule(run___released=NOTHING),
    "starts sharpened while an observer pulls": _rule(
        search__beginnings_in_a_loop__sharpened=Part(lambda problem, pulled, starts: list(starts))
    ),
    "a search that begins with other first effects": _rule(search__effect_selection__with_other_beginnings=KEPT),
    "starts from other coefficients": _rule(search__hypothesis_search___starts_elsewhere=NONE),
    "starts from the nominal coefficients beside others": _rule(search__forward_selection___nominal_start=NOTHING),
    "linear dynamics beside the nominal coefficients": _rule(search__forward_selection___linear_from_nominal=NONE),
    "plants that an effect says itself": _rule(search__hypothesis_search__models_with_plants=NONE),
    "starts beside better coefficients": _rule(search__hypothesis_search___beside_better_coefficients=NONE),
    "a race where all are far off": _rule(search__hypothesis_search___is_lost=NEVER),
    "multiple shooting": _rule(search__hypothesis_search___may_be_caught=NEVER),
    # laws
    "special cases": _rule(
        search__hypothesis_search___simpler=NONE,
        search__hypothesis_search__special_case_in_place=NOTHING,
        search__effect_selection__special_case_in_place=NOTHING,
    ),
    "laws with less detail": _rule(
        search__hypothesis_search__plainer_law=NOTHING, search__effect_selection__plainer_law=NOTHING
    ),
    "laws with more detail": _rule(search__hypothesis_search__finer_laws=NONE),
    "more detail beside further effects": _rule(search__forward_selection__finer_in_place=KEPT),
    "more detail in the place of a weak effect": _rule(search__effect_selection___detail_instead=NOTHING),
    "more detail in the end": _rule(decided__with_settled_laws=KEPT),
    "laws that do nearly the same": _rule(
        search__hypothesis_search___relatives=NONE, search__effect_selection__relatives_in_place=NONE
    ),
    "related laws as they were screened": _rule(search__hypothesis_search___screened_of=NONE),
    "further shapes of a resonance": _rule(search__hypothesis_search___further_shapes=NONE),
    "learned laws": _rule(decided__with_learned_laws=KEPT),
    "learned laws in the place of all names": _rule(laws__laws_alone__with_laws_alone=WITHOUT_LAWS),
    # which effects stay
    "no further names beside an inexact law": _rule(search__forward_selection__laws_are_inexact=NEVER),
    "names after an interrupted search": _rule(decided___leaves_colour=NEVER),
    "a look beside a name that chance may explain": _rule(search__forward_selection__WORTH_A_LOOK=Part(1.0)),
    "the likeliest when all work is done": _rule(search__forward_selection__MOST_IN_OVERTIME=Part(0)),
    "the likelier name without a swap": _rule(search__effect_selection__with_likelier_name=SAME_NAMES),
    "names known from before": _rule(search__effect_selection__MOST_KNOWN=Part(0)),
    "names beside what falls with an effect": _rule(search__effect_selection___sweeps_along=NEVER),
    "effects that became weak go": _rule(decided__without_weak=KEPT),
    "effects that faded in the last fit go": _rule(decided__without_faded=KEPT),
    "effects of impossible values go": _rule(decided___wandered=NOT_ONE),
    "names that coloured noise explains go": _rule(decided__in_noise_metric=KEPT),
    "held-out rows refute names": _rule(decided__borne_out=KEPT),
    "fewest and simplest names where structure is left": _rule(decided__simplest=KEPT),
    # estimates
    "rows weighed by their noise": _rule(decided__relative_noise=NOTHING),
    "least squares where structure is left": _rule(decided__in_least_squares=KEPT),
    "fits to the last digit": _rule(decided___converged=KEPT),
    "evidence tempered by the colour of what is left": {"camid.fitting.fit.Fitted.inflation": Part(lambda *_: 1.0)},
}
