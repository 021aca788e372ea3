"""Effects that no recording of a problem can show, whatever their size."""

from __future__ import annotations

from camid.effects.base import Effect
from camid.fitting.problem import Problem

WHY_INTERPOLATED = "the readings are interpolated between irregular times, which gives their noise a colour of its own"


def unseen(problem: Problem, effect: type[Effect]) -> str | None:
    """Why an effect cannot show in the recordings that are fitted; None where it can."""
    if effect.colours_noise and any(problem.experiments[run].interpolated for run in problem.fitted_runs):
        return WHY_INTERPOLATED
    return problem.kind.unseen(effect)
