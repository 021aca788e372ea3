"""One design: search within the limits, check by a real fit, and say what to expect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.report.summary import title_of
from camid.diagnosis.watch import Watch
from camid.errors import InputError
from camid.experiment_design.check import Check
from camid.experiment_design.general_laws import general_laws
from camid.experiment_design.hypothesis import Hypothesis, Played
from camid.experiment_design.left_out import left_out
from camid.experiment_design.limits import Limits
from camid.experiment_design.other_values import own_sums
from camid.experiment_design.prediction import SMALLEST_INFORMATION, TIMES, NoiseModel, Response, travelled
from camid.experiment_design.refit import Past
from camid.experiment_design.result import Design, Determined, Expectation
from camid.experiment_design.search import Candidate, Search
from camid.experiment_design.separation import DECIDED, Judge, Pair, excludes, most_left, pairs_of
from camid.experiment_design.sums import laws_that_are_sums, warnings_of
from camid.experiment_design.together import Earlier
from camid.fitting.packing import Packing
from camid.fitting.plants.kind import PlantKind

Array = NDArray[np.float64]

# Rows of simulations that a design may cost: some ten seconds of a plant of second order with friction.
SIMULATED_ROWS = 5e6
# The same for a second search, which knows the values of rivals that fits have found, as a share.
AGAIN = 0.5
# Rows of earlier recordings that rivals are fitted to: fits to longer ones would take longer than all the rest, and the
# longer they are the farther the information holds around the best fit.
MOST_EARLIER_ROWS = 6000
# Experiments that are checked by a fit in each of the two.
CHECKED = 4
# Evidence below which names stay together whatever is played (Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773–795).
NO_EVIDENCE = 2.0
# Information on a parameter, measured by its size, below which it counts as that.
LEAST_INFORMATION = 1e-6
# Times as long as was allowed for which the growth of the evidence is carried on.
LONGEST = 20.0


@dataclass(frozen=True)
class Task:
    """What is to be designed.

    Attributes
    ----------
    hypotheses : list of Hypothesis
    limits : Limits
    noise : NoiseModel
    rows_before : int
        Rows of earlier recordings that were fitted.
    experiments : int
        Earlier experiments with different inputs.
    earlier : Earlier or None
        The earlier recordings; None where they are known by the hypotheses' information alone.
    """

    hypotheses: list[Hypothesis]
    limits: Limits
    noise: NoiseModel
    rows_before: int
    experiments: int = 1
    earlier: Earlier | None = None

    @cached_property
    def judge(self) -> Judge:
        """What turns evidence into weights after the next experiment."""
        every = self.hypotheses
        return Judge(every, self.rows_before, self.experiments + 1, general_laws(every), laws_that_are_sums(every))

    @property
    def names(self) -> list[int]:
        """Places of the names that exclude another one."""
        every = self.hypotheses
        return [
            i
            for i, h in enumerate(every)
            if not h.rival_only and any(excludes(h, o) for j, o in enumerate(every) if j != i)
        ]


def design_for(task: Task, watch: Watch, *, simulated_rows: float = SIMULATED_ROWS, checked: int = CHECKED) -> Design:
    """The best experiment for a task.

    Raises
    ------
    InputError
        If no experiment keeps the limits.
    """
    started = perf_counter()
    for period, exposure in task.limits.settings:
        for hypothesis in task.hypotheses:  # refuses a camera that cannot be
            hypothesis.at(Played(np.zeros(10), period, exposure))
    refuse_rest_outside(task)
    task, past = _with_rivals(task)
    judge, noise, names = task.judge, task.noise, task.names

    def score(found: Sequence[Response]) -> float:
        return judge.score(pairs_of(found, noise), len(found[0].output)) if names else information(found[0])

    watch.say("looking at experiments")
    search = Search(task.hypotheses, task.limits, noise, score, simulated_rows, watch)
    check = Check(task, past, checked, watch)
    best = search.best(check.others)
    if not best and watch.no_time_for("experiments"):
        raise InputError("the time is up, and no experiment was looked at yet", hint="allow more with --time-limit")
    if not best:
        raise InputError(
            "no experiment keeps the travel under every hypothesis",
            where=task.limits.where,
            hint="allow more with --travel, or a smaller input with --amplitude",
        )
    pairs: list[Pair] = []
    chosen = best[0]
    if names:
        watch.say("fitting the rivals to the best ones")
        check.add(best)
        if check.news and not watch.no_time_for("a second search"):
            watch.say("looking at experiments that also tell what the fits have found")
            best = search.again(best, check.others, AGAIN * simulated_rows)
            check.add(best)
        chosen, pairs = check.best
    others = {c.kind: c.score for c in best}
    said = _said(task, chosen, pairs, others)
    seconds = perf_counter() - started
    warnings = [*_same_laws(said.expectations), *warnings_of(task.hypotheses)]
    return replace(said, looked_at=search.looked_at, seconds=seconds, warnings=warnings)


def _with_rivals(task: Task) -> tuple[Task, Past | None]:
    """The task with rivals that are not listed, and what is known of the earlier recordings, if they are there."""
    earlier, every = task.earlier, task.hypotheses
    if earlier is None or not task.names or earlier.rows > MOST_EARLIER_ROWS or not earlier.agrees(every):
        return task, None
    sums = own_sums(every, earlier)
    rivals = left_out(every, earlier, sums)
    more = own_sums(rivals, earlier)
    return replace(task, hypotheses=[*every, *rivals]), Past(earlier, [*sums, *more])


def _same_laws(expectations: Sequence[Expectation]) -> list[str]:
    """Sentences for names that no experiment within the limits tells apart, whichever of them is right."""
    lost = {(e.identifier, e.rival) for e in expectations if e.seconds is None and abs(e.evidence) < NO_EVIDENCE}
    pairs = sorted({tuple(sorted(pair)) for pair in lost if pair[::-1] in lost})
    return [
        f"{title_of(one)} and {title_of(other)} are the same law within these limits: "
        f"no experiment that was looked at tells them apart"
        for one, other in pairs
    ]


def information(found: Response) -> float:
    """Logarithm of the determinant of the information on all parameters, each measured by its value: D-optimality.

    A fit measures parameters by what they do to the output that it is given. Experiments are held against each other by
    sizes that are the same for all of them: one that moves nothing would otherwise be taken for the best. What an
    experiment takes to tell its own initial state is no loss, and no gain.
    """
    packing = found.packing
    values = packing.pack(packing.template)
    sizes = np.where(values == 0.0, 1.0 / packing.units, np.abs(values))
    measured = found.information * np.outer(sizes, sizes)
    initial = np.array([name.startswith("initial") for name in packing.names], bool)
    return _log_determinant(measured) - _log_determinant(measured[np.ix_(initial, initial)])


def _log_determinant(products: Array) -> float:
    """Half of the logarithm of a determinant; what carries no information counts little instead of endlessly."""
    lengths = np.sqrt(np.maximum(np.diag(products), LEAST_INFORMATION))
    values = np.linalg.eigvalsh(products / np.outer(lengths, lengths))
    return float(np.sum(np.log(lengths)) + 0.5 * np.sum(np.log(np.maximum(values, SMALLEST_INFORMATION))))


def _said(task: Task, chosen: Candidate, pairs: list[Pair], others: dict[str, float]) -> Design:
    """What is to be expected of an experiment."""
    played = chosen.played
    listed = [h for h in task.hypotheses if not h.rival_only]
    ranges = [travelled(h, played) for h in listed]
    rows = np.unique(np.linspace(0, len(played.signal), TIMES + 1).astype(np.int64)[1:])
    times = np.asarray(rows * played.period, dtype=np.float64)
    expectations, growth = [], {}
    linear = pairs_of(chosen.found, task.noise) if pairs else []
    for i in sorted({p.true for p in pairs}):
        expectation, grown = _expectation(task, chosen, i, (pairs, linear), rows)
        expectations.append(expectation)
        growth[expectation.identifier] = grown
    likeliest = max(range(len(task.hypotheses)), key=lambda i: task.hypotheses[i].weight)
    return Design(
        listed,
        task.limits,
        chosen.kind,
        chosen.described,
        played,
        expectations,
        determined_by(chosen.found[likeliest]),
        {r.hypothesis.identifier: r.output for r in chosen.found if r.hypothesis.is_name},
        (min(r[0] for r in ranges), max(r[1] for r in ranges)),
        others,
        growth,
        times,
    )


def _expectation(
    task: Task, chosen: Candidate, true: int, pairs: tuple[list[Pair], list[Pair]], rows: NDArray[np.int64]
) -> tuple[Expectation, Array]:
    """What is expected if one name is right, and how its evidence grows."""
    judge, played, noise = task.judge, chosen.played, task.noise
    whole = len(played.signal)
    own = [p for p in pairs[0] if p.true == true]
    first_order = {p.rival: p for p in pairs[1] if p.true == true}
    nearest = min(own, key=lambda p: judge.evidence(p, whole))
    found = chosen.found
    grown: dict[int, Array] = {}
    output = noise.whitened(found[true].output)
    without = next(
        (k for k, h in enumerate(task.hypotheses) if not h.identifier and h.question == task.hypotheses[true].question),
        None,
    )
    base = np.zeros(len(rows)) if without is None else _growth(found[without], output, noise, rows)
    for pair in own:
        # It ends with what the rival leaves once it is fitted: what that takes, it takes from the beginning on.
        growth = _growth(found[pair.rival], output, noise, rows)
        grown[pair.rival] = growth * (pair.left / growth[-1]) if growth[-1] > 0.0 else growth

    def weight_after(k: int) -> float:
        now = [replace(p, left=float(grown[p.rival][k]), mismatch=float(base[k])) for p in own]
        return judge.weight(true, now, int(rows[k]))

    seconds = next((float(rows[k] * played.period) for k in range(len(rows)) if weight_after(k) >= DECIDED), None)
    if seconds is None:
        seconds = _beyond(judge, true, own, whole, played)
    evidence = judge.evidence(nearest, whole)
    expectation = Expectation(
        task.hypotheses[true].identifier,
        task.hypotheses[nearest.rival].identifier,
        evidence,
        evidence / (whole * played.period),
        judge.evidence(first_order[nearest.rival], whole),
        judge.weight(true, own, whole),
        seconds,
    )
    curves = [
        [judge.evidence(replace(p, left=float(grown[p.rival][k])), int(rows[k])) for p in own] for k in range(len(rows))
    ]
    return expectation, np.array([min(curve) for curve in curves])


def _growth(found: Response, output: Array, noise: NoiseModel, rows: NDArray[np.int64]) -> Array:
    return found.growth(output - noise.whitened(found.output), rows)


def _beyond(judge: Judge, true: int, own: list[Pair], rows: int, played: Played) -> float | None:
    """Seconds until one name has 95 % if the experiment goes on in the same way; None if it never has."""
    limits = [most_left(judge.hypotheses[true], judge.hypotheses[p.rival]) for p in own]
    for factor in np.geomspace(1.1, LONGEST, 60):
        longer = [
            replace(p, left=min(factor * p.left, most), mismatch=factor * p.mismatch)
            for p, most in zip(own, limits, strict=True)
        ]
        if judge.weight(true, longer, round(factor * rows)) >= DECIDED:
            return float(factor * rows * played.period)
    return None


def determined_by(found: Response) -> list[Determined]:
    """The parameters of a hypothesis with what is known of them before and after."""
    packing, hypothesis = found.packing, found.hypothesis
    values = packing.pack(packing.template) * packing.units
    before, after = found.deviations(with_experiment=False), found.deviations(with_experiment=True)
    names, units = readable_names(hypothesis, packing.names), units_of(hypothesis, packing)
    return [
        Determined(name, float(v), float(b), float(a), unit)
        for name, v, b, a, unit in zip(names, values, before, after, units, strict=True)
        if not name.startswith("initial")
    ]


def readable_names(hypothesis: Hypothesis, packed: Sequence[str]) -> list[str]:
    """Names of parameters as the reports have them: ``b0``, ``coulomb-friction force``, ``mass``."""
    from camid.diagnosis.remaining_hypotheses import stable_names

    problem, model = hypothesis.problem, hypothesis.model
    # What is packed of a pendulum are coefficients, though it is told of by its own constants.
    coefficients = [name for name, _, _ in PlantKind.estimates(problem.kind, problem.structure, model, None)]
    found = []
    for name in stable_names(packed, model.effects):
        head, _, tail = name.partition(" ")
        if head == "coefficient" and int(tail) < len(coefficients):
            found.append(coefficients[int(tail)])
        else:
            found.append(tail if head == "constant" else name)
    return found


def units_of(hypothesis: Hypothesis, packing: Packing) -> list[str]:
    """Units of packed parameters in u, y and s; of a plant's named constants those that it declares."""
    effects = {f"{e.identifier} {p.name}": p.unit for e in hypothesis.model.effects for p in e.parameters}
    constants = {c.name.removeprefix("constant "): c.unit for c in packing.constants}
    found = []
    for packed, name in zip(packing.names, readable_names(hypothesis, packing.names), strict=True):
        if packed.startswith(("coefficient", "constant ")):
            found.append(hypothesis.simulation.unit_of_coefficient(name))
        else:
            found.append(effects.get(name) or constants.get(name, ""))
    return found


def refuse_rest_outside(task: Task) -> None:
    """Refuse a travel that does not hold the rest."""
    travel = task.limits.travel
    if travel is None:
        return
    still, columns = Played(np.zeros(10), task.limits.periods[0]), task.limits.columns
    for hypothesis in task.hypotheses:
        low, high = travelled(hypothesis, still)
        if low <= travel[0] or high >= travel[1]:
            raise InputError(
                f"the rig rests at {columns.output_text(low)}, which lies outside of the travel from "
                f"{columns.output_range(*travel)}",
                where=task.limits.where,
                hint="allow more with --travel, in readings of the sensor",
            )
