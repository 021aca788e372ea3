"""Other declarations of hold, sensor, exposure and latency, fitted where the residual depends on the input."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.identification.declarations import SAME_DEVIANCE, Alternative
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.residual_analysis import analyse_residual, in_units_of_the_data
from camid.identification.safeguarded import safeguarded_srivc
from camid.identification.structure import Structure

Array = NDArray[np.float64]

# Other declarations are tried with exposures and latencies of this many periods, then refined between the neighbours
# of the best: to a share of the period, and to a finer one where the residual is below a share of the output.
EXPOSURES = (0.1, 0.4, 0.7, 1.0)
LATENCIES = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
REFINEMENTS = ((1e-3, np.inf), (1e-6, 1e-2))
FAILED_COST = 1e300
# Rows from the start of a recording on which they are refined.
REFINEMENT_ROWS = 20_000
REFIT_ITERATIONS = 20


def alternative_declarations(
    structure: Structure,
    plant: TransferFunction,
    experiments: list[Experiment],
    progress: Callable[[str], None] | None = None,
) -> list[Alternative]:
    """Fit other declarations of hold, sensor, exposure and latency.

    One is changed at a time; the hold in addition, if no single change explains the recording.

    Parameters
    ----------
    structure : Structure
    plant : TransferFunction
        The estimate under the declaration, from which the others start; SI units.
    experiments : list of Experiment
        As declared.
    progress : callable, optional
        Called with a sentence about the current step.

    Returns
    -------
    list of Alternative
        Those that pass the test of independence first, in ascending deviance; then the others in ascending residual.
    """
    declared = experiments[0].acquisition
    # Frames of which an alternative does not know what was before the recording are left out for all.
    frames = int(np.ceil(declared.latency / declared.period + LATENCIES[-1])) + 2
    experiments = [_without_first(e, frames) for e in experiments]
    structure, plant, experiments, gain = in_units_of_the_data(structure, plant, experiments)
    other = replace(declared, hold="foh" if declared.hold == "zoh" else "zoh")
    single = [_Family(("hold",), declared, lambda _: other), *_families(declared, ())]
    found: list[Alternative] = []
    for families in (single, _families(other, ("hold",))):
        trials = []
        for family in families:
            if progress:
                progress(f"the residual depends on the input: trying another {' and '.join(family.changed)}")
            trial = family.local(structure, plant, experiments)
            trials += [] if trial is None else [trial]
        # A fit from scratch costs more than the rest together, so it is spent on what may explain the recording.
        for trial in [t for t in trials if t.passes] or trials:
            alternative = trial.estimated(structure)
            if alternative is not None:
                numerator = tuple(gain * b for b in alternative.plant.numerator)
                physical = TransferFunction(numerator, alternative.plant.denominator)
                found.append(replace(alternative, plant=physical))
        if any(a.passes for a in found):
            break
    return sorted(found, key=lambda a: (not a.passes, a.analysis.deviance if a.passes else a.nrmse))


@dataclass(frozen=True)
class _Trial:
    """Another declaration with a plant near the one that was found under the first."""

    changed: tuple[str, ...]
    acquisition: Acquisition
    experiments: list[Experiment]
    plant: TransferFunction
    passes: bool

    def estimated(self, structure: Structure) -> Alternative | None:
        """The declaration with its own estimate; None if nothing converges."""
        try:
            result = estimate(structure, self.experiments, nominal=self.plant)
            analysis = analyse_residual(structure, result.plant, self.experiments)
        except (ValueError, ArithmeticError):  # this declaration leads nowhere
            return None
        if not result.converged or analysis is None:
            return None
        left = np.concatenate([r[e.used] for r, e in zip(result.residuals, self.experiments, strict=True)])
        recorded = np.concatenate([e.output[e.used] for e in self.experiments])
        nrmse = float(np.sqrt(np.mean(left**2)) / np.std(recorded))
        return Alternative(self.acquisition, self.changed, result.plant, nrmse, analysis)


def _without_first(experiment: Experiment, frames: int) -> Experiment:
    if not experiment.estimate_initial_state or not np.any(experiment.signal):
        return experiment
    return replace(experiment, used=experiment.used & (np.arange(len(experiment.used)) >= frames))


@dataclass(frozen=True)
class _Family:
    """Declarations that differ from a base in one respect, by a value in periods where there is one to choose.

    Where the data leave it open, the first of the preferred values is taken.
    """

    changed: tuple[str, ...]
    base: Acquisition
    make: Callable[[float], Acquisition]
    grid: tuple[float, ...] = ()
    preferred: tuple[float, ...] = (0.0,)

    def local(self, structure: Structure, plant: TransferFunction, experiments: list[Experiment]) -> _Trial | None:
        """The member that fits best in the neighbourhood of a plant; None if it is the base."""
        value, found = self.preferred[0], plant
        if self.grid:
            value, found = self._refined(structure, plant, [_first_rows(e) for e in experiments])
            if value == self.preferred[0] and "sensor" not in self.changed:
                return None
        declared = [_declared(e, self.make(value)) for e in experiments]
        try:
            found = refitted(structure, found, declared)[1]
            analysis = analyse_residual(structure, found, declared)
        except (ValueError, ArithmeticError):  # this declaration leads nowhere
            return None
        return _Trial(
            self.changed, self.make(value), declared, found, analysis is not None and not analysis.contradicts
        )

    def _refined(
        self, structure: Structure, plant: TransferFunction, experiments: list[Experiment]
    ) -> tuple[float, TransferFunction]:
        """The best value, and the plant that fits it."""
        from scipy.optimize import minimize_scalar

        rows = sum(int(np.count_nonzero(e.used)) for e in experiments)
        tried: dict[float, tuple[float, TransferFunction]] = {}

        def cost(value: float) -> float:
            nearest = min(tried, key=lambda v: abs(v - value), default=None)
            start = plant if nearest is None else tried[nearest][1]
            try:
                tried[value] = refitted(structure, start, [_declared(e, self.make(value)) for e in experiments])
            except (ValueError, ArithmeticError):  # no plant fits there
                tried[value] = (FAILED_COST, start)
            return tried[value][0]

        place = int(np.argmin([cost(v) for v in self.grid]))
        bounds = self.grid[max(place - 1, 0)], self.grid[min(place + 1, len(self.grid) - 1)]
        power = sum(float(np.sum(e.position[e.used] ** 2)) for e in experiments)
        for tolerance, largest in REFINEMENTS:
            if tried[min(tried, key=lambda v: tried[v][0])][0] <= largest**2 * power:
                minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": tolerance})
            best = min(tried, key=lambda v: tried[v][0])
            bounds = max(best - 2.0 * tolerance, self.grid[0]), min(best + 2.0 * tolerance, self.grid[-1])
        limit = tried[best][0] * float(np.exp(SAME_DEVIANCE / rows))
        value = next((v for v in self.preferred if cost(v) <= limit), best)
        return value, tried[value][1]


def _families(base: Acquisition, combined_with: tuple[str, ...]) -> list[_Family]:
    """Other sensors, exposures and latencies."""
    period = base.period

    def exposed(share: float) -> Acquisition:
        return replace(base, sensor="camera", exposure=share * period)

    def delayed(share: float) -> Acquisition:
        return replace(base, latency=share * period)

    now = base.latency / period
    later = tuple(sorted({*LATENCIES, *(now + np.array(LATENCIES))}))
    latencies = _Family((*combined_with, "latency"), base, delayed, later, (now, 0.0))
    if base.sensor == "instant":
        return [_Family((*combined_with, "sensor"), base, exposed, EXPOSURES, (1.0,)), latencies]
    instant = replace(base, sensor="instant", exposure=None)
    share = (base.exposure or period) / period
    return [
        _Family((*combined_with, "sensor"), base, lambda _: instant),
        _Family((*combined_with, "exposure"), base, exposed, EXPOSURES, (share, 1.0)),
        latencies,
    ]


def _declared(experiment: Experiment, acquisition: Acquisition) -> Experiment:
    """The experiment as another acquisition describes it; recordings of one rig may differ in their period."""
    period = experiment.acquisition.period
    exposure = min(acquisition.exposure or period, period)
    return replace(experiment, acquisition=replace(acquisition, period=period, exposure=exposure))


def _first_rows(experiment: Experiment) -> Experiment:
    rows = slice(REFINEMENT_ROWS)
    return replace(
        experiment, signal=experiment.signal[rows], output=experiment.output[rows], used=experiment.used[rows]
    )


def refitted(
    structure: Structure, plant: TransferFunction, experiments: list[Experiment]
) -> tuple[float, TransferFunction]:
    """Sum of squares, and the plant, after a few Gauss–Newton steps that never raise the output error.

    Parameters
    ----------
    structure : Structure
    plant : TransferFunction
        Where the steps start; SI units, as the result.
    experiments : list of Experiment
    """
    monic = plant.monic
    predictor = Predictor.around(structure, experiments, np.array(monic.denominator))
    start = predictor.with_fitted_initial_states(np.array([*monic.numerator, *monic.denominator[1:]]))
    found = safeguarded_srivc(predictor, start, maximum_iterations=REFIT_ITERATIONS)
    coefficients = np.where(structure.free, predictor.to_physical(found.parameters), structure.coefficients())
    return found.cost, structure.plant(coefficients)
