"""The check of the best experiments: rivals are really fitted, and what the fits find is told to the search."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from camid.diagnosis.watch import Watch
from camid.experiment_design.hypothesis import Hypothesis
from camid.experiment_design.other_values import other_values
from camid.experiment_design.refit import Past, refitted, refitted_together
from camid.experiment_design.search import Candidate
from camid.experiment_design.separation import Pair, pairs_of

if TYPE_CHECKING:
    from camid.experiment_design.run import Task

# Rows of simulations that the checks of one search beside the first may take; a fit evaluates the rival and each of its
# derivatives about so often.
CHECKED_ROWS = 8e6
EVALUATIONS = 6.0
# Names with other values that a search takes into account at most: each costs as much as a hypothesis.
MOST_OTHERS = 8


class Check:
    """The experiments that were checked.

    Parameters
    ----------
    task : Task
    past : Past or None
        The earlier recordings, if they are known.
    count : int
        Experiments of each search that are checked.
    watch : Watch
    """

    def __init__(self, task: Task, past: Past | None, count: int, watch: Watch) -> None:
        self.task, self.count, self.watch = task, count, watch
        self.news = False
        self._found: list[tuple[float, Candidate, list[Pair]]] = []
        self._past = past
        others = [] if past is None else other_values(task.hypotheses, past.earlier, past.sums)
        self.others: list[Hypothesis] = others[:MOST_OTHERS]

    @property
    def best(self) -> tuple[Candidate, list[Pair]]:
        """The experiment that says most after real fits, and its pairs."""
        _, candidate, pairs = max(self._found, key=lambda item: item[0])
        return candidate, pairs

    def add(self, best: Sequence[Candidate]) -> None:
        """Check the best experiments of a search."""
        spent = 0.0
        known = {c.played.signal.tobytes() for _, c, _ in self._found}
        fresh = [c for c in best if c.played.signal.tobytes() not in known]
        for candidate in fresh[: self.count]:
            spent += self._rows(candidate)
            if self._found and (spent > CHECKED_ROWS or self.watch.no_time_for("fits of more experiments")):
                break
            self._check(candidate)

    def _check(self, candidate: Candidate) -> None:
        task, played = self.task, candidate.played
        pairs = pairs_of(candidate.found, task.noise)
        if self._past is None:
            pairs = refitted(task.hypotheses, played, task.noise, pairs)
        else:
            pairs, moved = refitted_together(task.hypotheses, played, task.noise, pairs, candidate.found, self._past)
            room = moved[: MOST_OTHERS + self.count - len(self.others)]
            self.others += room
            self.news |= bool(room)
        self._found.append((task.judge.score(pairs, len(played.signal)), candidate, pairs))

    def _rows(self, candidate: Candidate) -> float:
        """About how many rows the fits of all rivals to one experiment simulate."""
        rows = len(candidate.played.signal) + (0 if self._past is None else self._past.earlier.rows)
        rivals = [self.task.hypotheses[p.rival] for p in pairs_of(candidate.found, self.task.noise)]
        return EVALUATIONS * rows * sum((2.0 + h.count) * h.effort(candidate.played) for h in rivals)
