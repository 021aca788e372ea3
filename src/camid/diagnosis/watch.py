"""What a diagnosis says on its way, and how much it may try."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import TypeVar

from camid.engine.work import Work
from camid.side_by_side import Account

Item = TypeVar("Item")

# Seconds after which a diagnosis that was not told otherwise comes to its end.
TIME_LIMIT = 120.0
# How much a diagnosis that was not told otherwise simulates at most: the bound below.
EFFORT = 1.0
# Work (:mod:`camid.engine.work`) of a diagnosis before it tries nothing new, in seconds, for each recording and for
# each row in addition: with more recordings each fit takes longer, and the search for names should not end sooner. Of
# rows beyond so many there is more evidence for the names that are looked at first, and each row counts less.
WORK, WORK_OF_ROW = 10.0, 2.5e-3
MANY_ROWS, WORK_OF_FURTHER_ROW = 8_000, 1e-3
# Recordings at most that count so: of many each says less, and the time limit stays.
MOST_RECORDINGS = 4
# Share of them after which the search for names ends, after which no further law is learned, and all of them.
NAMES, LAWS, FORMULAS = 0.75, 0.85, 1.0
# The same that formulas may take in all, and by which laws are settled: what is learned says little without one, and
# what is left of laws that are not settled is no sign of anything.
OVERTIME = 1.3
# What may be left out of the search for each of many effects, and how many of them are listed.
OF_EFFECTS, MOST_LISTED = ("other starts of ", "other shapes of ", "what could replace "), 2
# Fits between which it is looked at: two threads share them.
BATCH = 8


@dataclass
class Watch(Account):
    """Progress and limits of one diagnosis.

    A limit ends no computation that has begun: before each part that the answer can do without, the diagnosis asks
    whether that is still to be tried, and keeps what it left out. What is tried is the same on every machine, whatever
    else runs there, unless it takes longer than the time limit: it is bounded by what is simulated, which is looked at
    where no other thread simulates.

    Attributes
    ----------
    progress : callable, optional
        Called with a sentence about the current step.
    limit : float, optional
        Seconds from now on; None for no limit.
    effort : float, optional
        How much is simulated at most, in multiples of the usual; None for as much as it takes.
    left_out : list of str
        What there was no time for.
    """

    progress: Callable[[str], None] | None = None
    limit: float | None = None
    effort: float | None = None
    left_out: list[str] = field(default_factory=list)
    started: float = field(default_factory=time.monotonic)
    _work: Work | None = field(default=None, init=False)
    _bound: float = field(default=0.0, init=False)
    _spent: bool = field(default=False, init=False)
    _late: bool = field(default=False, init=False)

    def count(self, work: Work, rows: int, recordings: int = 1) -> None:
        """Bound the work that is counted, in a diagnosis of so many rows of so many recordings that are fitted."""
        self._work = work
        of_rows = WORK_OF_ROW * min(rows, MANY_ROWS) + WORK_OF_FURTHER_ROW * max(rows - MANY_ROWS, 0)
        self._bound = (self.effort or 0.0) * (WORK * min(recordings, MOST_RECORDINGS) + of_rows)

    def aside(self, work: Work, rows: int, recordings: int = 1) -> Watch:
        """One for something to be tried beside the rest, with the same limits, in the time that is left."""
        left = None if self.limit is None else max(self.limit - (time.monotonic() - self.started), 0.0)
        other = Watch(self.progress, left, self.effort)
        other.count(work, rows, recordings)
        return other

    @property
    def done(self) -> float:
        """Work that is done, in seconds of a processor."""
        return 0.0 if self._work is None else self._work.seconds

    def allowance(self, count: int) -> float:
        """Work that each of so many fits of formulas may take, in seconds: an equal part of what is left for them."""
        if self.effort is None or self._work is None:
            return inf
        return max(OVERTIME * self._bound - self.done, 0.0) / max(count, 1)

    def take_stock(self, share: float = FORMULAS, ahead: float = 0.0) -> None:
        """Note whether a share of the work is done, or will be with what is ahead; not while other threads simulate."""
        if self.effort is not None and self._work is not None:
            self._spent = self.done + ahead >= share * self._bound

    def has_done(self, share: float) -> bool:
        """Whether a share of the work is done; not while other threads simulate."""
        return self.effort is not None and self._work is not None and self.done >= share * self._bound

    def batches(self, items: Sequence[Item]) -> Iterator[Sequence[Item]]:
        """A few items at a time, before each of which stock is taken."""
        for first in range(0, len(items), BATCH):
            self.take_stock(NAMES)
            yield items[first : first + BATCH]

    def state(self) -> tuple[list[str], bool, bool]:
        """What is left out, whether for lack of time, and whether all work is done."""
        return self.left_out.copy(), self._late, self._spent

    def set(self, state: tuple[list[str], bool, bool]) -> None:
        """Make it as it was."""
        self.left_out[:], self._late, self._spent = state

    def since(self, state: tuple[list[str], bool, bool]) -> tuple[list[str], bool]:
        """What was left out since a state, and whether for lack of time."""
        return self.left_out[len(state[0]) :], self._late

    def add(self, changes: tuple[list[str], bool]) -> None:
        """Leave parts out."""
        parts, late = changes
        self.left_out += [part for part in parts if part not in self.left_out]
        self._late = self._late or late

    def say(self, sentence: str) -> None:
        """Tell the current step."""
        if self.progress is not None:
            self.progress(sentence)

    def no_time_for(self, part: str, *, needed: bool = False) -> bool:
        """Whether a limit is over, so that a part is left out; a ``needed`` one only if it is that of the time."""
        late = self.limit is not None and time.monotonic() - self.started >= self.limit
        if not (late or (self._spent and not needed)):
            return False
        self._late = self._late or late
        self.leave_out(part)
        return True

    def leave_out(self, part: str) -> None:
        """Note what is not tried."""
        if part not in self.left_out:
            self.left_out.append(part)

    def warning(self) -> str | None:
        """One sentence on what was left out; None if nothing was."""
        if not self.left_out:
            return None
        reached, option = (
            (f"the time limit of {self.limit:g} s was reached", "--time-limit")
            if self._late
            else (f"as much was simulated as an effort of {self.effort:g} allows", "--effort")
        )
        return f"{reached}, and this is the best answer until then; not tried: {_in_words(self.left_out)}; see {option}"


def _in_words(parts: Sequence[str]) -> str:
    """What was left out; of many effects of a kind how many."""
    groups: dict[str, list[str]] = {}
    for part in parts:
        kind = next((kind for kind in OF_EFFECTS if part.startswith(kind)), "" if " " not in part else part)
        groups.setdefault(kind, []).append(part.removeprefix(kind))
    words = []
    for kind, effects in groups.items():
        if kind in ("", *OF_EFFECTS):
            several = f"{len(effects)} {'less likely effects' if kind == '' else 'effects'}"
            words.append(kind + (several if len(effects) > MOST_LISTED else " and ".join(effects)))
        else:
            words.append(kind)
    return ", ".join(words)
