"""The motions that were simulated last, so that what asks for one again need not simulate it again.

A diagnosis looks at one model from many sides: where its residual sits, what it visits, how its noise is distributed,
what is left on the rows that judge. Each time the same motion is wanted, with steps that have to be found by halving
them until nothing changes: dear where a force is stiff.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from threading import Lock

from camid.chain.motion import Motion
from camid.engine.work import Work

# Points of the grids of all motions that are kept, about 40 bytes each.
MOST_POINTS = 1_500_000


class RememberedMotions:
    """Motions by what they are simulated from; the oldest go where there are too many points."""

    def __init__(self) -> None:
        self._known: OrderedDict[Hashable, tuple[Sequence[object], Motion, tuple[int, int]]] = OrderedDict()
        self._points = 0
        self._lock = Lock()

    def __reduce__(self) -> tuple[type[RememberedMotions], tuple[()]]:
        return RememberedMotions, ()  # another process remembers its own

    def of(self, objects: Sequence[object], values: Hashable, simulate: Callable[[Work], Motion], work: Work) -> Motion:
        """The motion that belongs to some objects and values.

        Parameters
        ----------
        objects : sequence of object
            Which are the same if they are one object, and are kept so that no other takes their place in memory.
        values : hashable
            Which are the same if they are equal.
        simulate : callable
            Makes the motion where it is not known, and counts what that takes.
        work : Work
            Counts it each time: what a diagnosis tries does not depend on which process remembers what.
        """
        key = (*map(id, objects), values)
        with self._lock:
            known = self._known.get(key)
            if known is not None:
                self._known.move_to_end(key)
        if known is None:
            its_work = Work()
            known = (objects, simulate(its_work), its_work.state())
            self._keep(key, known)
        work.add(known[2])
        return known[1]

    def _keep(self, key: Hashable, known: tuple[Sequence[object], Motion, tuple[int, int]]) -> None:
        points = len(known[1].position)
        with self._lock:
            if key not in self._known and points <= MOST_POINTS:
                self._known[key] = known
                self._points += points
                while self._points > MOST_POINTS:
                    _, (_, oldest, _) = self._known.popitem(last=False)
                    self._points -= len(oldest.position)
