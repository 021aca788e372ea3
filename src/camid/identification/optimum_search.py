"""Search for the global optimum: from a belief or from nothing to the optimum that explains the data best.

Starts are refined one after the other until an optimum leaves no more than what cannot be predicted; then no other can
do better, except an alias that does as well. Aliases are therefore always considered.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import polynomial_roots
from camid.identification.accuracy import innovation_variance
from camid.identification.discrete_time_start import alias_denominators
from camid.identification.experiment import Experiment
from camid.identification.optimum_selection import Optimum, Rival, conclusive, plausible_cost, rivals, select
from camid.identification.predictor import Predictor
from camid.identification.records import Records
from camid.identification.safeguarded import safeguarded_srivc
from camid.identification.starts import (
    StartCandidate,
    discrete_time_candidates,
    filter_candidates,
    grid_candidates,
    output_errors_of,
    start_window,
)
from camid.identification.structure import Structure

Array = NDArray[np.float64]
Progress = Callable[[str], None]

REFINED_STARTS = 4
REFINED_GRID_STARTS = 6
REFINEMENT_ITERATIONS = 50
# Up to this order a conclusive optimum has no equal except its aliases; with more modes several starts are compared.
SINGLE_MODE = 2


class Search:
    """Optima met so far, and the starts that lead to more.

    It runs on an active window of long recordings; only the last iteration sees every row.

    Parameters
    ----------
    structure : Structure
    experiments : list of Experiment
    records : Records
        The experiments, packed.
    believed : ndarray, shape (n + 1,), optional
        Monic denominator in SI units of the plant that is believed in.
    tell : callable
        Called with a sentence about the current step.
    """

    def __init__(
        self,
        structure: Structure,
        experiments: list[Experiment],
        records: Records,
        believed: Array | None,
        tell: Progress,
    ) -> None:
        self.structure, self.believed, self.tell = structure, believed, tell
        self.windows = [start_window(e) for e in experiments]
        self.whole = all(w is e for w, e in zip(self.windows, experiments, strict=True))
        self.records = records if self.whole else Records.of(self.windows)
        self.optima: list[Optimum] = []

    @cached_property
    def unpredictable(self) -> float:
        """Mean variance of what past outputs and inputs do not predict."""
        variances = [innovation_variance(w) for w in self.windows if w.used.any()]
        return float(np.mean(variances)) if variances else 0.0

    def best(self) -> Optimum | None:
        """The chosen one among the optima met so far."""
        return select(self.optima, self.believed_poles, self.unpredictable) if self.optima else None

    @cached_property
    def believed_poles(self) -> NDArray[np.complex128] | None:
        """In rad/s."""
        return None if self.believed is None else polynomial_roots(self.believed)

    def run(self) -> tuple[Optimum, list[Rival]]:
        """The best optimum, and others that the data do not tell from it.

        Raises
        ------
        ValueError
            If no start leads to a stable model.
        """
        found = False
        if self.believed is not None:
            found = self.refine([StartCandidate(self.believed, np.nan)])
        if not found or self.structure.order > SINGLE_MODE:
            self.tell("starting values: discrete-time models")
            candidates = discrete_time_candidates(self.structure, self.windows, self.records)
            if self.structure.order > SINGLE_MODE:
                candidates += filter_candidates(self.structure, self.windows, self.records)
                candidates.sort(key=lambda c: c.cost)
            found = self.refine(candidates[:REFINED_STARTS])
        if not found and self.structure.order <= SINGLE_MODE:
            self.tell("starting values: state-variable filters")
            found = self.refine(filter_candidates(self.structure, self.windows, self.records)[:REFINED_STARTS])
        if not found:
            self.refine_grid()
        self.refine_aliases()
        best = self.best()
        if best is None:
            raise ValueError("no starting value leads to a stable model of this order")
        return best, rivals(best, self.optima)

    def is_conclusive(self) -> bool:
        """Whether no other start can do better."""
        best = self.best()
        return best is not None and conclusive(best, self.unpredictable)

    def refine(self, candidates: Sequence[StartCandidate]) -> bool:
        """Iterate from candidates, with a single mode until one ends the search; whether the search may end."""
        for candidate in candidates:
            self.optima.append(self.optimum(candidate))
            if self.structure.order <= SINGLE_MODE and self.is_conclusive():
                return True
        return self.is_conclusive()

    def refine_grid(self) -> None:
        """Iterate from the best of a grid of poles."""
        self.tell("starting values: grid of poles")
        candidates = grid_candidates(self.structure, self.windows, self.records)
        self.optima += [self.optimum(c) for c in candidates[:REFINED_GRID_STARTS]]

    def refine_aliases(self) -> None:
        """Iterate from the modes with the same sampled poles that come near enough to be rivals.

        Past the Shannon frequency, or where an alias does nearly as well, the grid is considered, too: modes of one
        frequency with little and much damping may then do alike.
        """
        best = self.best()
        if best is None or not any(np.any(w.signal) for w in self.windows):
            return
        if self.believed is not None and not best.past_shannon:
            return  # a belief below the Shannon frequency rules the faster twins out
        aliases = alias_denominators(best.poles, self.windows[0].acquisition.period)
        limit = plausible_cost(best)
        near = [c for c in output_errors_of(self.structure, self.records, aliases) if c.cost <= limit]
        self.optima += [self.optimum(c) for c in near]
        chosen = self.best()
        if chosen is not None and (chosen.past_shannon or rivals(chosen, self.optima)):
            self.refine_grid()

    def optimum(self, candidate: StartCandidate) -> Optimum:
        """Where the iteration leads from a candidate."""
        structure = self.structure
        # Coefficients that are not free keep their value.
        denominator = np.where(structure.free_denominator, candidate.denominator, structure.denominator)
        predictor = Predictor.around(structure, self.windows, denominator, self.records)
        scaled = denominator * predictor.time_unit ** np.arange(structure.order + 1)
        start = predictor.solve_numerator(scaled)[0]
        return Optimum(predictor, safeguarded_srivc(predictor, start, maximum_iterations=REFINEMENT_ITERATIONS))
