"""What a diagnosis says on its way, and how long it may take."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

# Seconds after which a diagnosis that was not told otherwise comes to its end.
TIME_LIMIT = 120.0


@dataclass
class Watch:
    """Progress and time limit of one diagnosis.

    A limit ends no computation that has begun: before each part that the answer can do without, the diagnosis asks
    whether there is time for it, and keeps what it left out.

    Attributes
    ----------
    progress : callable, optional
        Called with a sentence about the current step.
    limit : float, optional
        Seconds from now on; None for no limit.
    left_out : list of str
        What there was no time for.
    """

    progress: Callable[[str], None] | None = None
    limit: float | None = None
    left_out: list[str] = field(default_factory=list)
    started: float = field(default_factory=time.monotonic)

    def say(self, sentence: str) -> None:
        """Tell the current step."""
        if self.progress is not None:
            self.progress(sentence)

    def no_time_for(self, part: str) -> bool:
        """Whether the limit is over, so that a part is left out."""
        if self.limit is None or time.monotonic() - self.started < self.limit:
            return False
        if part not in self.left_out:
            self.left_out.append(part)
        return True

    def warning(self) -> str | None:
        """One sentence on what was left out; None if nothing was."""
        if not self.left_out:
            return None
        return (
            f"the time limit of {self.limit:g} s was reached, and this is the best answer until then; not tried: "
            f"{', '.join(self.left_out)}; see --time-limit"
        )
