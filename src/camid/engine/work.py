"""How much has been simulated: a measure of effort that is the same on every machine, whatever else runs there.

It is about the time that the simulations take on one processor, by what they are made of. The numbers were set once, so
that the times of 34 diagnoses on one machine came out, and only have to stay what they are: an answer depends on them.
"""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING

from camid.side_by_side import Account

if TYPE_CHECKING:  # the command line asks for the limits of an effort, and is not to load the engine for it
    from camid.engine.forces import Mechanics

# Microseconds for a simulation, for each of its rows, and for each step of the integrator; in addition where a force
# depends on a velocity that it changes at once, and where one has kinks or remembers.
RUN, ROW, STEP, IMPLICIT, KINKED = 270.0, 0.17, 0.07, 0.6, 0.2
# The same for each step with tangents, and each of its columns.
TANGENT, COLUMN = 0.75, 0.1


class Work(Account):
    """What all threads and processes together have simulated for one purpose, in seconds of a processor.

    Attributes
    ----------
    runs : int
        How many simulations.
    """

    def __init__(self) -> None:
        self.runs = 0
        self._microseconds = 0
        self._lock = Lock()

    def __reduce__(self) -> tuple[type[Work], tuple[()]]:
        return Work, ()  # what another process counts for itself

    @property
    def seconds(self) -> float:
        """So far."""
        return self._microseconds * 1e-6

    def add_run(self, rows: int) -> None:
        """Count a simulation of so many rows, but for the integrator's steps."""
        self._add(RUN + ROW * rows, runs=1)

    def add_steps(self, mechanics: Mechanics, steps: int) -> None:
        """Count so many steps of the integrator."""
        functions = mechanics.forces.functions
        forced = bool(functions[:2].any())
        kinked = forced and bool(functions[2:4].any())
        self._add((STEP + IMPLICIT * (forced and mechanics.forces.implicit) + KINKED * kinked) * steps)

    def add_tangents(self, steps: int, columns: int) -> None:
        """Count so many steps with tangents."""
        self._add((TANGENT + COLUMN * columns) * steps)

    def _add(self, microseconds: float, runs: int = 0) -> None:
        # Parts of a microsecond would add up to other sums in another order.
        with self._lock:
            self._microseconds += round(microseconds)
            self.runs += runs

    def state(self) -> tuple[int, int]:
        """Microseconds and simulations."""
        return self._microseconds, self.runs

    def set(self, state: tuple[int, int]) -> None:
        """Go on from so many."""
        self._microseconds, self.runs = state

    def since(self, state: tuple[int, int]) -> tuple[int, int]:
        """How many since a state."""
        return self._microseconds - state[0], self.runs - state[1]

    def add(self, changes: tuple[int, int]) -> None:
        """Count so many."""
        self._add(*changes)
