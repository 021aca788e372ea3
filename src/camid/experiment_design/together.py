"""Earlier recordings and what the next one would show as one least-squares problem of a hypothesis.

The Fisher information of earlier recordings is a parabola around the values that fit them best. Where a stop begins, or
how often something repeats, a recording may leave open far beyond what a parabola allows: then the recordings
themselves have to be fitted together with the experiment.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.experiment_design.hypothesis import Hypothesis, Played
from camid.experiment_design.prediction import FITTED_SHARE, NoiseModel
from camid.fitting.output_error import sensitivities
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import NEGLIGIBLE, Problem
from camid.fitting.updated_derivative import LatestOutputs, UpdatedDerivative

Array = NDArray[np.float64]

TOLERANCE = 1e-4
# Times that its derivatives are computed anew, where updates of them no longer say what changes.
REFRESHES = 4
# Residual of a simulation that runs away, in ranges of what was recorded.
RUNAWAY = 1e3
# By how much a sum of squares may differ from what the diagnosis states, in variances of the noise and as a share.
AGREES, AGREES_SHARE = 1.0, 0.02


@dataclass(frozen=True)
class Recorded:
    """A recording that was diagnosed, in the units of the simulation.

    Attributes
    ----------
    time, signal, output : ndarray, shape (N,)
        Seconds, input, and recorded output.
    fitted : ndarray of bool, shape (N,)
        Rows that the diagnosis fitted.
    """

    time: Array
    signal: Array
    output: Array
    fitted: NDArray[np.bool_]


@dataclass(frozen=True)
class Earlier:
    """All recordings that were diagnosed.

    Attributes
    ----------
    recorded : tuple of Recorded
    noise : NoiseModel
    period : float
        Seconds.
    at_rest : bool
        Whether the rig rested before each of them; otherwise their initial states are estimated.
    """

    recorded: tuple[Recorded, ...]
    noise: NoiseModel
    period: float
    at_rest: bool = True

    @property
    def rows(self) -> int:
        """Rows of all."""
        return sum(len(r.time) for r in self.recorded)

    def problem(self, hypothesis: Hypothesis) -> tuple[Problem, Model]:
        """What was recorded, for a hypothesis, and the model that it starts from."""
        template = hypothesis.problem.experiments[0]
        experiments = [
            replace(
                template,
                signal=r.signal,
                output=r.output,
                used=r.fitted,
                acquisition=hypothesis.simulation.acquisition(self.period),
                estimate_initial_state=not self.at_rest,
                input_log=None,
            )
            for r in self.recorded
        ]
        problem = replace(hypothesis.problem, experiments=experiments, times=[r.time for r in self.recorded])
        model = hypothesis.model
        model = replace(model, constants={**problem.kind.constants(), **model.constants})
        if self.at_rest:
            return problem, replace(model, initial=tuple(None for _ in experiments))
        return problem, problem.with_initial_states(model)

    def agrees(self, hypotheses: Sequence[Hypothesis]) -> bool:
        """Whether these are what the hypotheses were fitted to: their sums of squares differ as it states."""
        if not self.at_rest:
            return True
        sums = []
        for hypothesis in hypotheses:
            whole = Together(hypothesis, self, finest=True)
            left = (whole.recorded - whole.simulated(whole.start)) / self.noise.deviation
            sums.append(float(left @ left) - hypothesis.misfit)
        allowed = AGREES + AGREES_SHARE * max(abs(h.misfit) for h in hypotheses)
        return max(sums) - min(sums) <= allowed


class Together:
    """A hypothesis beside earlier recordings, and beside an experiment if one is given.

    Parameters
    ----------
    hypothesis : Hypothesis
    earlier : Earlier
    played, output, noise : Played, ndarray of shape (N,), NoiseModel, optional
        The experiment, what it would show, and its noise.
    finest : bool
        Whether the integrator's steps are fine.
    """

    def __init__(
        self,
        hypothesis: Hypothesis,
        earlier: Earlier,
        played: Played | None = None,
        output: Array | None = None,
        noise: NoiseModel | None = None,
        *,
        finest: bool = False,
    ) -> None:
        problem, model = earlier.problem(hypothesis)
        self.noises, self.shares = [earlier.noise] * len(problem.experiments), [1.0] * len(problem.experiments)
        if played is not None and output is not None and noise is not None:
            new, played_from = hypothesis.at(played)
            experiment = replace(new.experiments[0], output=output)
            times = [*problem.times, *new.times]
            problem = replace(problem, experiments=[*problem.experiments, experiment], times=times)
            model = replace(model, initial=(*model.initial, *played_from.initial))
            self.noises, self.shares = [*self.noises, noise], [*self.shares, FITTED_SHARE]
        self.hypothesis = hypothesis
        # Steps of the integrator need not be finer than the noise lets one see.
        negligible = NEGLIGIBLE * earlier.noise.deviation / problem.output_spread
        self.problem = problem.pinned(model, finest=finest, negligible=negligible)
        self.packing = Packing.of(self.problem, model)
        self.free = hypothesis.free(self.packing)
        self.start = self.packing.pack(model)
        self.recorded = self.problem.output
        ends = np.cumsum([np.count_nonzero(e.used) for e in problem.experiments])
        self._parts = [slice(int(a), int(b)) for a, b in zip([0, *ends[:-1]], ends, strict=True)]
        self._worst = RUNAWAY * (float(np.ptp(self.recorded)) or 1.0)
        self.rows = sum(len(t) for t in problem.times)

    def whitened(self, values: Array) -> Array:
        """Rows, shape (M,) or (M, p), in standard deviations of white noise; those that a diagnosis fits count."""
        parts = zip(self._parts, self.noises, self.shares, strict=True)
        return np.concatenate([np.sqrt(share) * noise.whitened(values[rows]) for rows, noise, share in parts])

    def simulated(self, vector: Array) -> Array:
        """The fitted rows, shape (M,)."""
        try:
            rows = self.problem.simulate_fitted(self.packing.unpack(vector))
        except (ValueError, ArithmeticError):
            return np.full(len(self.recorded), self._worst)
        return np.clip(np.nan_to_num(rows, nan=self._worst), -self._worst, self._worst)

    def cost(self, vector: Array) -> float:
        """Sum of squares in variances of the noise."""
        left = self.whitened(self.recorded - self.simulated(vector))
        return float(left @ left)

    def table(self, vector: Array) -> Array:
        """Sensitivities by the free parameters, whitened, shape (M, q)."""
        columns = np.flatnonzero(self.free).tolist()
        return self.whitened(sensitivities(self.problem, self.packing, vector, self.simulated(vector), columns))

    def least(self, start: Array, steps: int) -> tuple[Array, float]:
        """The vector of least squares near a start, shape (p,), and its sum of squares."""
        from scipy.optimize import least_squares

        packing, free = self.packing, self.free
        begin = np.clip(start, packing.lower, packing.upper)
        if not free.any():
            return begin, self.cost(begin)

        def whole(part: Array) -> Array:
            vector = begin.copy()
            vector[free] = part
            return vector

        simulated = LatestOutputs(lambda part: self.simulated(whole(part)))
        columns = np.flatnonzero(free).tolist()
        derivative = UpdatedDerivative(
            lambda part, rows: sensitivities(self.problem, packing, whole(part), rows, columns), REFRESHES
        )

        def residual(part: Array) -> Array:
            return self.whitened(self.recorded - simulated(part))

        def jacobian(part: Array) -> Array:
            return -self.whitened(derivative.at(part, simulated(part)))

        found = least_squares(
            residual,
            begin[free],
            jac=jacobian,
            bounds=(packing.lower[free], packing.upper[free]),
            x_scale="jac",
            ftol=TOLERANCE,
            max_nfev=steps,
        )
        return whole(found.x), float(2.0 * found.cost)
