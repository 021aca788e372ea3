"""The search for an experiment: families are sampled, the best ones more; the best members are refined, and joined."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.watch import Watch
from camid.experiment_design.hypothesis import Hypothesis, Played
from camid.experiment_design.limits import Limits
from camid.experiment_design.prediction import NoiseModel, Response, responses, travelled
from camid.experiment_design.signals import FAMILIES, Band, Family

Array = NDArray[np.float64]

# Share of the travel that a design leaves free at each end, since the hypotheses are estimates.
TRAVEL_MARGIN = 0.05
# How often an input is made smaller so that the travel is kept, and how much smaller than it would have to be.
MOST_SHRINKS = 8
SHRINK = 0.97
# Frequencies of candidates reach so far below and above those of the plant; of the frame rate at most this share.
BELOW, ABOVE, FASTEST = 0.1, 4.0, 0.35
FEWEST_CYCLES = 1.5
# Families that are looked at more closely, and whose best members are refined; shares of the effort after which only
# these are sampled, for the whole first look, and for joining pairs.
REFINED = 3
EVERY_FAMILY, FIRST_LOOK, JOINING = 0.25, 0.5, 0.15
RELEASE = "release from a position"


@dataclass(frozen=True)
class Candidate:
    """An experiment that was looked at.

    Attributes
    ----------
    kind : str
        Its family.
    described : dict
        Numbers that say which member it is.
    played : Played
    found : list of Response
        What the hypotheses predict, and behind them those with other values.
    score : float
        What is maximised.
    numbers : ndarray, shape (d,)
        Between zero and one; they chose it from its family.
    """

    kind: str
    described: dict[str, Any]
    played: Played
    found: list[Response]
    score: float
    numbers: Array = field(default_factory=lambda: np.zeros(0))


class Search:
    """A search among experiments within limits.

    Parameters
    ----------
    hypotheses : sequence of Hypothesis
    limits : Limits
    noise : NoiseModel
    score : callable
        From the responses of all hypotheses to what is maximised.
    simulated_rows : float
        Rows of all simulations together that it may cost: the same on every machine.
    watch : Watch
    """

    def __init__(
        self,
        hypotheses: Sequence[Hypothesis],
        limits: Limits,
        noise: NoiseModel,
        score: Callable[[Sequence[Response]], float],
        simulated_rows: float,
        watch: Watch,
    ) -> None:
        self.hypotheses, self.limits, self.noise, self.score = list(hypotheses), limits, noise, score
        self.others: list[Hypothesis] = []
        self._efforts: dict[tuple[str, str, float], float] = {}
        self.budget, self.watch = simulated_rows, watch
        self.spent = 0.0
        self.looked_at = 0

    def best(self, others: Sequence[Hypothesis] = ()) -> list[Candidate]:
        """The best experiment of every family and of joined pairs, the best first; none where none keeps the travel.

        ``others`` are names with other values, by which rivals are judged, too.
        """
        from scipy.stats import qmc

        self.others = list(others)
        settings = self.limits.settings
        starts: list[float | None] = [None, *self.limits.positions]
        best: dict[str, Candidate] = {}
        samplers = {f.name: qmc.Sobol(f.numbers, seed=0) for f in FAMILIES}
        families = [] if self.limits.low == self.limits.high else list(FAMILIES)
        for released in self.limits.positions:
            for setting in settings:
                still = np.zeros(self.limits.rows(setting[0]))
                self._keep(best, self.played(RELEASE, {"position": released}, still, setting, released))
        turn = 0
        while families and not self._over(FIRST_LOOK):
            if len(families) > REFINED and best and self._over(EVERY_FAMILY):
                promising = _ranked(best)[:REFINED]
                families = [f for f in families if f.name in {c.kind for c in promising}]
            for family in families:
                if best and self._over(1.0):  # long experiments: one family may cost as much as all may
                    break
                numbers = samplers[family.name].random(1)[0]
                setting, position = settings[turn % len(settings)], starts[turn % len(starts)]
                self._keep(best, self.member(family, numbers, setting, position))
            turn += 1
        if not best:
            return []
        for candidate in _ranked(best)[:REFINED]:
            self._keep(best, self._refined(candidate, (1.0 - FIRST_LOOK - JOINING) / REFINED * self.budget))
        self._join(best)
        return _ranked(best)

    def again(self, earlier: Sequence[Candidate], others: Sequence[Hypothesis], more_rows: float) -> list[Candidate]:
        """What is best of earlier candidates, of those near them and of pairs, now that rivals have other values, too.

        Parameters
        ----------
        earlier : sequence of Candidate
        others : sequence of Hypothesis
            Names with other values, all that are known.
        more_rows : float
            Rows of simulations that it may cost.
        """
        self.others = list(others)
        self.budget = self.spent + more_rows
        best: dict[str, Candidate] = {}
        for one in earlier:
            if best and self._over(1.0):
                break
            setting = one.played.period, one.played.exposure
            new = self.played(one.kind, one.described, one.played.signal, setting, one.played.position)
            self._keep(best, None if new is None else replace(new, numbers=one.numbers))
        alone = [c for c in _ranked(best) if len(c.numbers)]
        share = (1.0 - JOINING) * (self.budget - self.spent) / REFINED
        for candidate in alone[:REFINED]:
            self._keep(best, self._refined(candidate, share))
        self._join(best)
        return _ranked(best)

    def member(
        self, family: Family, numbers: Array, setting: tuple[float, float | None], position: float | None
    ) -> Candidate | None:
        """A member of a family within the limits; None where no size of it keeps the travel."""
        self.spent += self.limits.rows(setting[0])
        shape, described = family.make(np.clip(numbers, 0.0, 1.0), self.band(setting[0]))
        found = self.played(family.name, described, self.limits.kept(shape, setting[0]), setting, position)
        return None if found is None else replace(found, numbers=numbers)

    def played(
        self,
        kind: str,
        described: dict[str, Any],
        signal: Array,
        setting: tuple[float, float | None],
        position: float | None,
    ) -> Candidate | None:
        """An input, made smaller until every hypothesis keeps the travel, and what it says."""
        played = self._within_travel(Played(signal, setting[0], setting[1], position))
        if played is None or (not np.any(played.signal) and position is None):
            return None
        self.looked_at += 1
        every = [*self.hypotheses, *self.others]
        self.spent += len(signal) * sum(
            self._effort(h, played) * (2.0 + len(h.known or range(8)) - len(h.held)) for h in every
        )
        try:
            found = responses(every, played, self.noise)
        except (ValueError, ArithmeticError, np.linalg.LinAlgError):
            return None
        return Candidate(kind, described, played, found, self.score(found))

    def _effort(self, hypothesis: Hypothesis, played: Played) -> float:
        """What a row of a hypothesis costs, as the first experiment of this period has shown."""
        key = (hypothesis.identifier, hypothesis.question, played.period)
        if key not in self._efforts:
            self._efforts[key] = hypothesis.effort(played)
        return self._efforts[key]

    def _over(self, share: float) -> bool:
        return self.spent >= share * self.budget or self.watch.no_time_for("more candidates")

    @staticmethod
    def _keep(best: dict[str, Candidate], new: Candidate | None) -> None:
        if new is not None and np.isfinite(new.score) and (new.kind not in best or new.score > best[new.kind].score):
            best[new.kind] = new

    def _refined(self, start: Candidate, rows: float) -> Candidate | None:
        """The best that Nelder and Mead's simplex finds around a member of a family for so many rows."""
        from scipy.optimize import minimize

        family = next((f for f in FAMILIES if f.name == start.kind), None)
        if family is None:
            return None
        setting, position = (start.played.period, start.played.exposure), start.played.position
        best, until = start, self.spent + rows

        def loss(numbers: Array) -> float:
            nonlocal best
            if self.spent > until or self.watch.no_time_for("more candidates"):
                raise StopIteration
            found = self.member(family, numbers, setting, position)
            if found is None:
                return 0.0
            best = found if found.score > best.score else best
            return -found.score

        first = np.clip(start.numbers, 0.02, 0.98)
        simplex = np.vstack([first, *(first + np.where(first < 0.5, 0.2, -0.2) * row for row in np.eye(len(first)))])
        with suppress(StopIteration):
            minimize(
                loss,
                first,
                method="Nelder-Mead",
                bounds=[(0.0, 1.0)] * len(first),
                options={"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-3},
            )
        return best

    def _join(self, best: dict[str, Candidate]) -> None:
        """Try the best members one after another, each for half of the time: one may separate what another does not."""
        # What has no numbers is a release, or joined already.
        ranked = [c for c in _ranked(best) if len(c.numbers)][: REFINED + 1]
        for one in ranked:
            for other in ranked:
                if one is other or one.played.period != other.played.period or self._over(1.0):
                    continue
                half = len(one.played.signal) // 2
                signal = np.concatenate(
                    [one.played.signal[:half], other.played.signal[: len(one.played.signal) - half]]
                )
                setting = one.played.period, one.played.exposure
                signal = self.limits.slowed(signal, setting[0])
                described = {"first_half": {"kind": one.kind, **one.described}}
                described |= {"second_half": {"kind": other.kind, **other.described}}
                kind = f"{one.kind}, then {other.kind}"
                self._keep(best, self.played(kind, described, signal, setting, one.played.position))

    def _within_travel(self, played: Played) -> Played | None:
        travel = self.limits.travel
        if travel is None:
            return played
        for _ in range(MOST_SHRINKS):
            listed = [h for h in self.hypotheses if not h.rival_only]
            self.spent += len(played.signal) * len(listed)
            ranges = [travelled(h, played) for h in listed]
            low, high = min(r[0] for r in ranges), max(r[1] for r in ranges)
            rest = self.hypotheses[0].model.constants.get("offset", 0.0)
            factor = shrink_factor((low, high), travel, rest)
            if factor is None:
                return None
            if factor >= 1.0:
                return played
            # Towards the least that the rig may be given, which is not zero for each.
            least = min(max(0.0, self.limits.low), self.limits.high)
            smaller = least + SHRINK * factor * (played.signal - least)
            played = replace(played, signal=self.limits.slowed(smaller, played.period))
        return None

    def band(self, period: float) -> Band:
        """Where candidates have their frequencies."""
        rows = self.limits.rows(period)
        plants = [h.problem.structure.plant(h.model.coefficients) for h in self.hypotheses]
        poles = np.concatenate([np.abs(plant.poles()) for plant in plants]) / (2.0 * np.pi)
        poles = poles[poles > 1e-9 / period]
        fastest, slowest = FASTEST / period, FEWEST_CYCLES / (rows * period)
        low = float(np.clip(BELOW * np.min(poles, initial=fastest), slowest, 0.25 * fastest))
        high = float(np.clip(ABOVE * np.max(poles, initial=low), 2.0 * low, fastest))
        return Band(low, high, period, rows)


def _ranked(best: dict[str, Candidate]) -> list[Candidate]:
    """Candidates, the best first."""
    return sorted(best.values(), key=lambda c: -c.score)


def shrink_factor(reached: tuple[float, float], travel: tuple[float, float], rest: float) -> float | None:
    """What an input has to be multiplied with to keep a range about the rest; None where nothing would."""
    if not np.all(np.isfinite(reached)):
        return 0.5
    margin = TRAVEL_MARGIN * (travel[1] - travel[0])
    low, high = travel[0] + margin, travel[1] - margin
    if not low < rest < high:
        return None
    factor = 1.0
    if reached[0] < low:
        factor = min(factor, (rest - low) / (rest - reached[0]))
    if reached[1] > high:
        factor = min(factor, (high - rest) / (reached[1] - rest))
    return factor
