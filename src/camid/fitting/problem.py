"""What is diagnosed: recordings of one rig, the structure of its nominal plant, and models of it with effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camid.chain.controller import Loop
from camid.chain.exact import companion, time_scale
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect, Situation
from camid.effects.pendulum import PendulumPlant
from camid.engine.run import Chain, move, run, steps_of
from camid.identification.experiment import Experiment
from camid.identification.residual_statistics import Moments, Rows, levinson, sums_of_products, whiteness
from camid.identification.structure import Structure

Array = NDArray[np.float64]

LARGEST_LAG = 25
LARGEST_ORDER = 12
ROWS_A_COEFFICIENT = 20
# Noise is taken for white unless a filter improves the likelihood by this more than Bayes's criterion asks: a weak
# effect would else be mistaken for colour, which the test of whiteness would not confirm.
COLOURED = 12.0
# Steps in a period of simulations that rank hypotheses, and of those that decide.
MOST_COARSE_STEPS = 12
MOST_STEPS = 100
ROWS_A_LAG = 8


@dataclass(frozen=True)
class Model:
    """A plant with effects.

    Attributes
    ----------
    coefficients : ndarray, shape (m + 1 + n,)
        [b_0 … b_m, a_1 … a_n] of the monic plant in SI units.
    effects : tuple of Effect
    initial : tuple of (ndarray or None)
        Companion state of the plant at the begin of each recording; None at rest.
    rest : float, optional
        Angle in rad at which a pendulum hangs still; None where the plant is no pendulum.
    """

    coefficients: Array
    effects: tuple[Effect, ...] = ()
    initial: tuple[Array | None, ...] = ()
    rest: float | None = None

    def without(self, index: int) -> Model:
        """The same model without one of its effects."""
        return replace(self, effects=self.effects[:index] + self.effects[index + 1 :])

    def plus(self, effect: Effect) -> Model:
        """The same model with one effect more."""
        return replace(self, effects=(*self.effects, effect))


@dataclass(frozen=True)
class Noise:
    """What the residual says of the noise.

    Attributes
    ----------
    whitening : ndarray, shape (p + 1,)
        Filter 1 + a_1 z⁻¹ + … after which it is white.
    deviance : float
        -2 log likelihood, with a penalty for the filter's order.
    """

    whitening: Array
    deviance: float


@dataclass(frozen=True)
class Problem:
    """Recordings and structure.

    Attributes
    ----------
    structure : Structure
    experiments : list of Experiment
        ``used`` marks the rows that are fitted.
    times : list of ndarray, each of shape (N,)
        Recorded times in seconds.
    unit : float
        Time in seconds that makes the plant's coefficients of the order of one.
    steps : tuple of int, optional
        Steps of the integrator in a period of each recording; see :meth:`pinned`.
    loops : tuple of Loop, optional
        The controller of each recording with its reference. The outputs of the experiments are then what it put out:
        the position follows the reference whatever the plant is like.
    positions : tuple of ndarray, each of shape (N,)
        The recorded positions in a closed loop.
    rest_free : bool
        Whether the angle at rest of a pendulum is re-estimated.
    fixed_gain : float, optional
        Ratio of b_0 to a_n that is kept where a pendulum's natural frequency is re-estimated and its gain is not.
    remainder : float, optional
        Root mean square of what an earlier diagnosis left unexplained.
    """

    structure: Structure
    experiments: list[Experiment]
    times: list[Array]
    unit: float = field(default=1.0)
    steps: tuple[int, ...] | None = None
    loops: tuple[Loop, ...] = ()
    positions: tuple[Array, ...] = ()
    rest_free: bool = False
    fixed_gain: float | None = None
    remainder: float | None = None

    @property
    def closed(self) -> bool:
        """Whether a controller makes the input."""
        return bool(self.loops)

    def is_linear(self, model: Model) -> bool:
        """Whether the plant without effects is linear and driven by a recorded input."""
        return not self.closed and model.rest is None

    def is_winding(self, model: Model) -> bool:
        """Whether an effect changes a phase that adds up: a pendulum, or a free decay.

        The change of the output is then proportional to an effect's size for very small ones only. What the screening
        says of it, and the first steps of a fit, are no measure of what the effect would explain.
        """
        return model.rest is not None or not any(np.any(e.signal) for e in self.experiments)

    def restored(self, recorded: Array, model: Model) -> Array:
        """Recorded positions as the plant's forces count them: from the angle at rest."""
        return recorded if model.rest is None else recorded - model.rest

    @cached_property
    def output(self) -> Array:
        """Recorded outputs on the fitted rows, shape (M,)."""
        return self.fitted([e.output for e in self.experiments])

    @property
    def acquisition(self):  # type: ignore[no-untyped-def]
        """Declared acquisition of the first recording."""
        return self.experiments[0].acquisition

    @property
    def duration(self) -> float:
        """Seconds of the longest recording."""
        return max(float(t[-1] - t[0]) for t in self.times)

    def fitted(self, rows: Sequence[Array]) -> Array:
        """The fitted rows of all recordings, one behind the other."""
        return np.concatenate([r[e.used] for r, e in zip(rows, self.experiments, strict=True)])

    def with_used(self, used: Sequence[NDArray[np.bool_]]) -> Problem:
        """The same with other rows fitted."""
        experiments = [replace(e, used=u) for e, u in zip(self.experiments, used, strict=True)]
        return replace(self, experiments=experiments)

    def beginning(self, rows: int) -> Problem:
        """The same recordings, cut off behind so many rows."""
        experiments = [
            replace(e, signal=e.signal[:rows], output=e.output[:rows], used=e.used[:rows]) for e in self.experiments
        ]
        loops = tuple(replace(loop, reference=loop.reference[:rows]) for loop in self.loops)
        return replace(
            self,
            experiments=experiments,
            times=[t[:rows] for t in self.times],
            loops=loops,
            positions=tuple(p[:rows] for p in self.positions),
        )

    def unseen(self, effect: type[Effect]) -> str | None:
        """Why recordings of this kind cannot show an effect; None if they can."""
        if self.closed and (effect.place == "sensor" or effect.identifier in {"input-hold", "exposure", "delay"}):
            return "in a closed loop the control tells of the plant; the controller has a sensor of its own"
        return None

    def pinned(self, model: Model, *, finest: bool) -> Problem:
        """The same with the steps of the integrator that suit a model.

        Differences of simulations are derivatives only if all take the same steps.
        """
        free = replace(self, steps=None)
        counts = tuple(
            min(steps_of(free.chain(model, i), e.signal, t, finest=finest), MOST_STEPS if finest else MOST_COARSE_STEPS)
            for i, (e, t) in enumerate(zip(self.experiments, self.times, strict=True))
        )
        return replace(self, steps=counts)

    # -- models ----------------------------------------------------------------------------------------------------

    def chain(self, model: Model, index: int) -> Chain:
        """Chain of a model as recording ``index`` saw it."""
        experiment = self.experiments[index]
        pendulum = () if model.rest is None else (PendulumPlant(rest=model.rest),)
        return Chain(
            self.structure.plant(model.coefficients),
            experiment.acquisition,
            (*pendulum, *model.effects),
            model.initial[index] if model.initial else None,
            experiment.free_motion_before_record,
            None if self.steps is None else self.steps[index],
            self.loops[index] if self.closed else None,
        )

    def simulate(self, model: Model) -> list[Array]:
        """Sensor output of every recording, all rows: shapes (N,)."""
        return [
            run(self.chain(model, i), e.signal, t)
            for i, (e, t) in enumerate(zip(self.experiments, self.times, strict=True))
        ]

    def motion(self, model: Model) -> list[tuple[Array, Array]]:
        """Position and velocity at the recorded times, before the sensor: two arrays of shape (N,) a recording."""
        found = []
        for i, (e, t) in enumerate(zip(self.experiments, self.times, strict=True)):
            motion = move(self.chain(model, i), e.signal, t)
            nodes = np.round((t - motion.begin) / motion.step).astype(int)
            found.append((motion.position[nodes], motion.velocity[nodes]))
        return found

    def situation(self, model: Model, index: int | None = None, *, at_sensor: bool = True) -> Situation:
        """What first guesses need, of one recording: the longest where none is named.

        The positions of a pendulum count from its rest where not the sensor but the plant is looked at.
        """
        if index is None:
            index = int(np.argmax([np.count_nonzero(e.used) for e in self.experiments]))
        experiment = self.experiments[index]
        if self.closed:
            return self._closed_situation(model, index)
        simulated = run(self.chain(model, index), experiment.signal, self.times[index])
        residual = np.where(experiment.used, experiment.output - simulated, 0.0)
        acquisition = experiment.acquisition
        for effect in model.effects:
            acquisition = effect.declare(acquisition)
        recorded = experiment.output
        if not at_sensor:
            recorded, simulated = self.restored(recorded, model), self.restored(simulated, model)
        return Situation(
            self.times[index],
            experiment.signal,
            recorded,
            simulated,
            np.gradient(simulated, acquisition.period),
            residual,
            self.structure.plant(model.coefficients),
            acquisition,
            experiment.used,
        )

    def _closed_situation(self, model: Model, index: int) -> Situation:
        """Position and velocity are the simulated ones, the residual is that of the control."""
        experiment, time = self.experiments[index], self.times[index]
        motion = move(self.chain(model, index), experiment.signal, time)
        nodes = np.round((time - motion.begin) / motion.step).astype(int)
        simulated = np.zeros(len(time)) if motion.control is None else motion.control
        return Situation(
            time,
            experiment.signal,
            self.positions[index],
            motion.position[nodes],
            motion.velocity[nodes],
            np.where(experiment.used, experiment.output - simulated, 0.0),
            self.structure.plant(model.coefficients),
            experiment.acquisition,
            experiment.used,
        )

    # -- noise -----------------------------------------------------------------------------------------------------

    def noise(self, residual: Array, fitted: int) -> Noise:
        """Noise that a residual on the fitted rows, shape (M,), consists of, after ``fitted`` numbers were fitted."""
        count = len(residual)
        size = float(np.max(np.abs(residual), initial=0.0))
        if size == 0.0:
            return Noise(np.ones(1), -np.inf)
        sums, pairs = np.zeros(LARGEST_LAG + 1), np.zeros(LARGEST_LAG + 1)
        position = 0
        for experiment in self.experiments:
            rows = np.zeros(len(experiment.used))
            part = int(np.count_nonzero(experiment.used))
            rows[experiment.used] = residual[position : position + part] / size
            position += part
            mask = experiment.used.astype(float)
            for lag in range(min(LARGEST_LAG, len(rows) - 1) + 1):
                sums[lag] += rows[lag:] @ rows[: len(rows) - lag]
                pairs[lag] += mask[lag:] @ mask[: len(rows) - lag]
        # The sums over fewer pairs are not corrected for it, so that the correlations are those of a process.
        order = min(LARGEST_ORDER, count // ROWS_A_COEFFICIENT)
        filters, left = levinson(sums[: order + 1] / sums[0])
        penalties = np.log(count) * np.arange(len(filters)) + np.where(np.arange(len(filters)) > 0, COLOURED, 0.0)
        best = int(np.argmin(count * np.log(left) + penalties))
        variance = sums[0] * size**2 / max(count - fitted, 1) * left[best]
        return Noise(filters[best], float(count * np.log(variance) + penalties[best]))

    def whiteness(self, residual: Array, sensitivities: Array) -> float:
        """Probability of a residual at least as coloured if the noise is white, with regard to what was fitted."""
        longest = max(int(np.count_nonzero(e.used)) for e in self.experiments)
        lags = max(min(LARGEST_LAG, longest // ROWS_A_LAG), 1)
        size = float(np.max(np.abs(residual), initial=0.0)) or 1.0
        rows = Rows.of(self.experiments, residual / size, sensitivities, np.zeros((len(residual), 0)), lags, 0)
        sums = sums_of_products(rows.residual, lags)
        if sums[0] <= 0.0:
            return 1.0
        found = whiteness(sums, Moments.of(rows, lags))
        return 1.0 if found is None else found

    def whitened(self, values: Array, whitening: Array) -> Array:
        """Rows, shape (M,) or (M, c), after a whitening filter; rows whose past is not fitted are set to zero."""
        if len(whitening) == 1:
            return values
        result = whitening[0] * values
        known = np.ones(len(values), bool)
        position = 0
        for experiment in self.experiments:
            rows = np.flatnonzero(experiment.used)
            part = slice(position, position + len(rows))
            position += len(rows)
            for lag in range(1, len(whitening)):
                near = rows[lag:] - rows[:-lag] == lag
                earlier = np.flatnonzero(near)
                result[part][earlier + lag] += whitening[lag] * values[part][earlier]
                known[part][:lag] = False
                known[part][lag:][~near] = False
        result[~known] = 0.0
        return result


def companion_state(structure: Structure, coefficients: Array, polynomial: Array) -> Array:
    """Companion state of a plant whose free motion is C/A, as the engine takes it.

    Parameters
    ----------
    structure : Structure
    coefficients : ndarray, shape (m + 1 + n,)
        SI units.
    polynomial : ndarray, shape (n,)
        C in units of the plant's time scale, highest power first, see :func:`camid.chain.exact.sample`.
    """
    plant = structure.plant(coefficients)
    unit = time_scale(plant.monic.denominator)
    order, degree = structure.order, structure.degree
    denominator = np.asarray(plant.monic.denominator) * unit ** np.arange(order + 1)
    numerator = np.asarray(coefficients[: degree + 1]) * unit ** (order - degree + np.arange(degree + 1.0))
    matrix = companion(denominator)
    row = np.zeros(order)
    row[max(order - degree - 1, 0) :] = numerator[-order:]
    observed, wanted = np.zeros((order, order)), np.zeros(order)
    free = np.asarray(polynomial, dtype=float)
    state = np.eye(order)[0]
    for k in range(order):
        observed[k] = row
        wanted[k] = free @ state
        row = row @ matrix
        state = matrix @ state
    return np.asarray(np.linalg.lstsq(observed, wanted, rcond=None)[0], dtype=np.float64)


def plant_of(problem: Problem, model: Model) -> TransferFunction:
    """Plant of a model."""
    return problem.structure.plant(model.coefficients)
