"""What is fitted: recordings of one rig, the structure of its nominal plant, and what its models predict for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.motion import Motion
from camid.effects.situation import Situation
from camid.engine.mechanics import Chain
from camid.engine.run import ROUGH, few_steps_of, move, run, steps_of
from camid.engine.work import Work
from camid.fitting.noise_of_residual import Noise, colour_of, noise_of, whitened
from camid.fitting.plant_with_effects import Model
from camid.fitting.remembered_motions import RememberedMotions
from camid.fitting.views import Views
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure

if TYPE_CHECKING:
    from camid.fitting.plants.kind import PlantKind

Array = NDArray[np.float64]

# Share of the rows of a run of which a part is fitted for the sake of its initial state alone.
LEAST_FITTED = 0.25
# Rows after the last fitted one that a simulation needs, for what an actuator or the sensor takes from the next sample.
ROWS_AFTER_FITTED = 2
# Error of a simulation, as a share of the root mean square of what the model leaves, that changes no comparison.
NEGLIGIBLE = 0.02
# Steps in a period of simulations that decide.
MOST_STEPS = 100


@dataclass(frozen=True)
class Problem:
    """Recordings and structure.

    Attributes
    ----------
    structure : Structure
    experiments : list of Experiment
        ``used`` marks the rows that are fitted; the outputs are what is compared.
    times : list of ndarray, each of shape (N,)
        Recorded times in seconds.
    kind : PlantKind
    unit : float
        Time in seconds that makes the plant's coefficients of the order of one.
    steps : tuple of int, optional
        Steps of the integrator in a period of each recording; see :meth:`pinned`.
    remainder : float, optional
        Root mean square of what an earlier diagnosis left unexplained.
    relative_noise : tuple of ndarray, optional
        Standard deviation of the noise in each row of each recording, shapes (N,), over its root mean square, where it
        is uneven: what is compared is divided by it.
    own_zeros : bool
        Whether each recording is counted from a zero of its own, which follows from the fitted rows: of what is
        compared the mean over them is taken away, and a simulated reading has the mean of the recorded ones.
    work : Work
        Counts all simulations for this problem and those that were made from it.
    motions : RememberedMotions
        Of the same problems.
    """

    structure: Structure
    experiments: list[Experiment]
    times: list[Array]
    kind: PlantKind
    unit: float = 1.0
    steps: tuple[int, ...] | None = None
    remainder: float | None = None
    relative_noise: tuple[Array, ...] | None = None
    own_zeros: bool = False
    work: Work = field(default_factory=Work, compare=False)
    motions: RememberedMotions = field(default_factory=RememberedMotions, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        """What it consists of, without what can be worked out again."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @property
    def runs(self) -> list[int]:
        """For each experiment the first one of the same run: columns of one recording are several."""
        return [i if e.same_run_as is None else e.same_run_as for i, e in enumerate(self.experiments)]

    @property
    def fitted_runs(self) -> list[int]:
        """The runs that are fitted, and do not judge but for what their initial state is taken from."""
        return [r for r in sorted(set(self.runs)) if np.mean(self.experiments[r].used) > LEAST_FITTED]

    @cached_property
    def recorded(self) -> Array:
        """Recorded outputs on the fitted rows, shape (M,)."""
        return self.fitted([e.output for e in self.experiments])

    @cached_property
    def output(self) -> Array:
        """The same as they are compared: over the relative noise where that is uneven."""
        return self.as_compared(self.recorded)

    @cached_property
    def output_spread(self) -> float:
        """Standard deviation of the recorded outputs on the fitted rows; see :meth:`spread`."""
        return self.spread([e.used for e in self.experiments])

    @property
    def integrated(self) -> int:
        """Steps of the integrator in a simulation of all recordings; rows where they are not given."""
        steps = self.steps or (1,) * len(self.times)
        return sum(len(t) * max(s, 1) for t, s in zip(self.times, steps, strict=True))

    @property
    def acquisition(self) -> Acquisition:
        """Declared acquisition of the first recording."""
        return self.experiments[0].acquisition

    @property
    def duration(self) -> float:
        """Seconds of the longest recording."""
        return max(float(t[-1] - t[0]) for t in self.times)

    def spread(self, rows: Sequence[NDArray[np.bool_]]) -> float:
        """Standard deviation of the recorded outputs on some rows of each recording, of every column about its mean."""
        columns: dict[int | None, list[Array]] = {}
        for experiment, chosen in zip(self.experiments, rows, strict=True):
            columns.setdefault(experiment.seen, []).append(experiment.output[chosen])
        parts = [np.concatenate(part) for part in columns.values()]
        square = sum(float(np.sum((part - np.mean(part)) ** 2)) for part in parts if len(part))
        return float(np.sqrt(square / max(sum(map(len, parts)), 1))) or 1.0

    def fitted(self, rows: Sequence[Array]) -> Array:
        """The fitted rows of all recordings, concatenated."""
        return np.concatenate([r[e.used] for r, e in zip(rows, self.experiments, strict=True)])

    def over_noise(self, rows: Array) -> Array:
        """Values on the fitted rows, shape (M,) or (M, c), over the relative noise where that is uneven."""
        noise = self._noise_of_fitted
        return rows if noise is None else np.asarray(rows / (noise if rows.ndim == 1 else noise[:, None]))

    def as_compared(self, rows: Array) -> Array:
        """The same, less what the zero of each recording makes up for where each has its own."""
        rows = self.over_noise(rows)
        if not self.own_zeros:
            return rows
        noise = self._noise_of_fitted
        found, first = rows.copy(), 0
        for experiment in self.experiments:
            part = slice(first, first := first + int(np.count_nonzero(experiment.used)))
            weight = np.ones(part.stop - part.start) if noise is None else 1.0 / noise[part]
            if len(weight):
                mean = (weight @ rows[part]) / (weight @ weight)
                found[part] -= np.multiply.outer(weight, mean)
        return found

    def in_units(self, rows: Array) -> Array:
        """What :meth:`over_noise` was given, shape (M,)."""
        noise = self._noise_of_fitted
        return rows if noise is None else rows * noise

    @cached_property
    def _noise_of_fitted(self) -> Array | None:
        return None if self.relative_noise is None else self.fitted(self.relative_noise)

    def with_used(self, used: Sequence[NDArray[np.bool_]]) -> Problem:
        """The same with other rows fitted."""
        experiments = [replace(e, used=u) for e, u in zip(self.experiments, used, strict=True)]
        return replace(self, experiments=experiments)

    def start_of(self, rows: int) -> Problem:
        """The same recordings, cut off after this many rows."""
        experiments = [
            replace(e, signal=e.signal[:rows], output=e.output[:rows], used=e.used[:rows]) for e in self.experiments
        ]
        times = [t[:rows] for t in self.times]
        noise = None if self.relative_noise is None else tuple(n[:rows] for n in self.relative_noise)
        kind = self.kind.start_of(rows)
        return replace(self, experiments=experiments, times=times, kind=kind, relative_noise=noise)

    def alone(self, index: int) -> Problem:
        """Recording ``index`` of several that have nothing in common but the rig, with an account of its own."""
        noise = None if self.relative_noise is None else (self.relative_noise[index],)
        one = replace(self, experiments=[self.experiments[index]], times=[self.times[index]], relative_noise=noise)
        return replace(one, steps=None, work=Work(), motions=RememberedMotions())

    def delivered_later(self, time: float) -> Problem:
        """The same with a latency that is longer by a time in seconds."""
        acquisitions = [replace(e.acquisition, latency=e.acquisition.latency + time) for e in self.experiments]
        pairs = zip(self.experiments, acquisitions, strict=True)
        return replace(self, experiments=[replace(e, acquisition=a) for e, a in pairs])

    def with_known_constants(self) -> Problem:
        """The same with offset and bias as they are declared, and zero where nothing is said."""
        experiments = [replace(e, estimate_offset=False, estimate_bias=False) for e in self.experiments]
        return replace(self, experiments=experiments, kind=self.kind.with_unknown(experiments))

    def all_fixed(self) -> Problem:
        """The same with none of the plant's constants free."""
        return replace(self, kind=self.kind.all_fixed())

    def with_initial_states(self, model: Model) -> Model:
        """The model with the initial states that a fit starts from."""
        if not any(e.estimate_initial_state or e.estimate_offset or e.estimate_bias for e in self.experiments):
            return replace(model, initial=tuple(None for _ in self.experiments))
        return self.kind.with_initial_states(self, model)

    def with_states_of_effects(self, model: Model) -> Model:
        """The model with initial states of its effects, where it has them of a plant that is linear.

        What flexes beside or after such a plant, or remembers its motion, has a state at the start as it has.
        """
        return model.with_states_of_effects(self.structure.order) if self.kind.nonlinear(model) is None else model

    def pinned(self, model: Model, *, finest: bool, negligible: float = 0.0) -> Problem:
        """The same with the steps of the integrator that suit a model.

        Differences of simulations are derivatives only if all take the same steps. The finest steps need not be finer
        than a ``negligible`` change of the motion asks for, as a share of its standard deviation.
        """
        free = replace(self._until_last_fitted, steps=None)
        chains = [free.chain(model, i) for i in range(len(free.experiments))]
        signals = [e.signal for e in free.experiments]
        if not finest:
            return replace(self, steps=tuple(map(few_steps_of, chains, signals)))
        needed = [
            steps_of(c, s, t, finest=True, negligible=negligible)
            for c, s, t in zip(chains, signals, free.times, strict=True)
        ]
        return replace(self, steps=tuple(min(steps, MOST_STEPS) for steps in needed))

    def negligible(self, residual: Array) -> float:
        """Change of the motion that changes no comparison beside a residual, as a share of its standard deviation."""
        return NEGLIGIBLE * float(np.sqrt(np.mean(residual**2))) / self.output_spread

    def rough(self) -> Problem:
        """The same with as few steps of the integrator as each model suggests: to rank models, not to differentiate."""
        return replace(self, steps=tuple(ROUGH for _ in self.experiments))

    # -- models ----------------------------------------------------------------------------------------------------

    def chain(self, model: Model, index: int) -> Chain:
        """Chain of a model as recording ``index`` saw it."""
        experiment = self.experiments[index]
        run = self.runs[index]
        effects = (*self.kind.forces(model), *model.in_order())
        return Chain(
            self.structure.plant(model.coefficients),
            experiment.acquisition,
            effects,
            model.initial[run] if model.initial else None,
            self.kind.state_before_record(experiment),
            None if self.steps is None else self.steps[index],
            self.kind.loop(index),
            self.kind.pull(experiment, model, effects),
            equations=self.kind.nonlinear(model, experiment.seen),
            weight=experiment.weight,
            input_log=experiment.input_log,
            work=self.work,
            initial_memory=self._memory(model, run),
        )

    def _memory(self, model: Model, run: int) -> Array | None:
        """What the effects of a chain remember at the start of a recording."""
        if self.kind.nonlinear(model) is not None:
            return None
        begun = model.memory_in_order(run, self.structure.order)
        return None if begun is None else np.concatenate([np.zeros(len(self.kind.forces(model))), begun])

    def simulate_one(self, model: Model, index: int) -> Array:
        """What is compared with the output of one recording, all rows, shape (N,)."""
        chain, experiment = self.chain(model, index), self.experiments[index]
        moved = partial(self._moved, chain, model, index, experiment.seen)
        simulated = run(chain, experiment.signal, self.times[index], moved=moved)
        return simulated + self.zero(simulated, index) if self.own_zeros else simulated

    def zero(self, simulated: Array, index: int) -> float:
        """By how much a recording reads more than what is simulated of it, shape (N,), in the mean of fitted rows.

        Of all rows where it judges only.
        """
        used = self.experiments[index].used
        used = used if used.any() else np.ones(len(used), bool)
        weight = None if self.relative_noise is None else self.relative_noise[index][used] ** -2
        return float(np.average((self.experiments[index].output - simulated)[used], weights=weight))

    def _moved(self, chain: Chain, model: Model, index: int, seen: int | None) -> Motion:
        """Motion of a model's chain, remembered where the integrator finds its steps itself; see :meth:`chain`."""
        experiment, time = self.experiments[index], self.times[index]
        if self.steps is not None:
            return move(chain, experiment.signal, time)

        def simulate(work: Work) -> Motion:
            return move(replace(chain, work=work), experiment.signal, time)

        objects = (model, self.structure, self.kind, experiment.signal, experiment.input_log, time)
        values = (index, seen, experiment.acquisition, chain.state_before_record)
        return self.motions.of(objects, values, simulate, self.work)

    def simulate(self, model: Model) -> list[Array]:
        """What is compared with the outputs of all recordings, all rows: shapes (N,)."""
        return [self.simulate_one(model, i) for i in range(len(self.experiments))]

    @cached_property
    def _until_last_fitted(self) -> Problem:
        """The same, cut off after the last row that is fitted: a fit need not simulate the rows that judge it."""
        rows = max((int(np.flatnonzero(e.used)[-1]) + 1 for e in self.experiments if e.used.any()), default=0)
        longest = max(len(t) for t in self.times)
        return self if rows + ROWS_AFTER_FITTED >= longest else self.start_of(rows + ROWS_AFTER_FITTED)

    def _needs_whole_input(self, model: Model) -> bool:
        """Whether the input between two samples depends on all of them, so that no part of a recording stands alone."""
        for experiment in self.experiments:
            acquisition = experiment.acquisition
            for effect in model.effects:
                acquisition = effect.declare(acquisition)
            if acquisition.hold == "band-limited":
                return True
        return False

    def _looks_past(self, model: Model) -> bool:
        """Whether rows that are fitted show motion after the last of them."""
        effects = (*self.kind.forces(model), *model.effects)
        ahead = [effect.ahead(time) for effect in effects for time in self.times]
        return max(ahead, default=0.0) > ROWS_AFTER_FITTED * self.acquisition.period

    def fitted_chains(self, model: Model) -> list[tuple[Chain, Array, Array, NDArray[np.bool_]]]:
        """For each recording with rows that are fitted its chain, input, times and which rows those are.

        The recordings end with the last of these rows.
        """
        whole = self._needs_whole_input(model) or self._looks_past(model)
        short = self if whole else self._until_last_fitted
        recordings = zip(short.experiments, short.times, strict=True)
        return [(short.chain(model, i), e.signal, t, e.used) for i, (e, t) in enumerate(recordings) if e.used.any()]

    def simulate_fitted(self, model: Model) -> Array:
        """What is compared with the outputs, the fitted rows of all recordings, concatenated; shape (M,)."""
        parts = [run(chain, signal, time)[used] for chain, signal, time, used in self.fitted_chains(model)]
        return self.as_compared(np.concatenate(parts)) if parts else np.zeros(0)

    def errors(self, model: Model, rows: Sequence[NDArray[np.bool_]]) -> Array:
        """Recorded minus simulated output on some rows of each recording, concatenated, as it is compared."""
        judging, simulated = self.with_used(rows), self.simulate(model)
        return judging.over_noise(judging.recorded - judging.fitted(simulated))

    def motion(self, model: Model) -> list[tuple[Array, Array]]:
        """Position and velocity at the recorded times, before the sensor: two arrays of shape (N,) per recording."""
        found: list[tuple[Array, Array]] = []
        for i, (e, t) in enumerate(zip(self.experiments, self.times, strict=True)):
            if e.same_run_as is not None:
                found.append(found[e.same_run_as])
                continue
            chain = replace(self.chain(model, i), equations=self.kind.nonlinear(model))
            motion = self._moved(chain, model, i, None)
            nodes = np.round((t - motion.start) / motion.step).astype(int)
            found.append((motion.position[nodes], motion.velocity[nodes]))
        return found

    def situation(self, model: Model, index: int | None = None) -> Situation:
        """What first guesses need, of one recording as it was read; see :meth:`situations`."""
        return self.situations(model, index).reading

    def situations(self, model: Model, index: int | None = None) -> Views:
        """The same as each effect sees it: where none is named, of the recording of which the model leaves most."""
        return self.kind.situations(self, model, self._leaves_most(model) if index is None else index)

    def _leaves_most(self, model: Model) -> int:
        """The recording whose sum of squares is the largest: it shows best what is missing."""
        if len(self.fitted_runs) == 1:
            return self.fitted_runs[0]

        def left(run: int) -> float:
            experiment = self.experiments[run]
            return float(np.sum((experiment.output - self.simulate_one(model, run))[experiment.used] ** 2))

        return max(self.fitted_runs, key=left)

    def signals_beside(self, index: int) -> Array | None:
        """Input of the recordings that are fitted beside one, one behind the other; None where it is alone."""
        signals = [self.experiments[run].signal for run in self.fitted_runs if run != index]
        return np.concatenate(signals) if signals else None

    # -- noise -----------------------------------------------------------------------------------------------------

    def noise(self, residual: Array, fitted: int) -> Noise:
        """Noise that a residual on the fitted rows, shape (M,), consists of, after ``fitted`` numbers were fitted."""
        return noise_of(self.experiments, residual, fitted)

    def whiteness(self, residual: Array, sensitivities: Array) -> float:
        """Probability of a residual at least as coloured if the noise is white, with regard to what was fitted."""
        return colour_of(self.experiments, residual, sensitivities)

    def whitened(self, values: Array, whitening: Array) -> Array:
        """Rows, shape (M,) or (M, c), after a whitening filter; rows whose past is not fitted are set to zero."""
        return whitened(self.experiments, values, whitening)
