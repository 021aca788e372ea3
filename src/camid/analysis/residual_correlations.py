"""Correlations of what a model leaves of a recording, with itself and with the input, for every kind of plant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from camid.analysis.spread import states_accuracy
from camid.analysis.view import ShortTable, View, common_mapping
from camid.effects.declared import effects_of
from camid.errors import InputError
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.from_simulation import kind_of, model_of, problem_of, structure_of
from camid.fitting.problem import Problem
from camid.fitting.simulated_output import STEPS, refuse_unknown_clock
from camid.identification.experiment import Experiment
from camid.identification.from_recordings import RecordingSource, experiments_of, warnings_of
from camid.identification.residual_analysis import (
    ResidualAnalysis,
    analyse_given,
    analyse_residual,
    in_units_of_the_data,
)
from camid.identification.structure import Structure
from camid.linear_algebra_threads import one_blas_thread
from camid.number_text import percentage, probability
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Share by which periods may differ: that of two clocks, which moves the largest lag by less than a sample.
SAME_PERIOD = 0.01


@dataclass(frozen=True, repr=False)
class ResidualCorrelations(View):
    """What ``camid.residuals`` returns.

    Attributes
    ----------
    analysis : ResidualAnalysis
        The tests of the residual.
    period : float
        Seconds.
    nrmse : float or None
        Root mean square of the residual over the standard deviation of what was recorded.
    model, source : str
        Model and recording.
    signals : tuple of str
        What the residual is of, and what it must not depend on; an empty name where nothing drives the rig.
    remarks : tuple of str
    """

    analysis: ResidualAnalysis
    period: float
    nrmse: float | None
    model: str
    source: str
    signals: tuple[str, str]
    remarks: tuple[str, ...] = ()

    columns: ClassVar[tuple[str, ...]] = ("lag", "seconds", "autocorrelation", "bound_autocorrelation")

    @property
    def numbers(self) -> pd.DataFrame:
        """What ``camid identify --residuals`` writes; see :meth:`ResidualAnalysis.correlations`."""
        return self.analysis.correlations(self.period)

    def _outside(self, name: str) -> str:
        """How many correlations leave their 99 % bounds, of how many."""
        table = self.numbers
        if name == "autocorrelation":
            table = table[table["lag"] > 0]
        known = table[[name, f"bound_{name}"]].dropna()
        if known.empty:
            return "–"
        return f"{int((known[name].abs() > known[f'bound_{name}']).sum())} of {len(known)}"

    def short_table(self) -> ShortTable:
        """The tests, and how many correlations leave their bounds."""
        found = self.analysis
        rows = [("white noise", probability(found.whiteness_p), self._outside("autocorrelation"))]
        if self.signals[1]:
            independent = f"independent of {self.signals[1]}"
            rows.append((independent, probability(found.independence_p), self._outside("crosscorrelation")))
        headings = ("hypothesis", "p", "outside of 99 % bounds")
        return ShortTable(f"Residual of {self.signals[0]}, {self.model}", headings, rows)

    def said(self) -> tuple[str, ...]:
        """What was found, and what was done to the rows."""
        share = "–" if self.nrmse is None else percentage(self.nrmse)
        size = f"residual: {share} of the standard deviation of {self.signals[0]}"
        return (size, self.analysis.summary(), *self.remarks)

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        table = self.numbers
        columns = {str(c): [None if not np.isfinite(v) else v for v in table[c].tolist()] for c in table.columns}
        return common_mapping(
            self,
            recording=self.source,
            model=self.model,
            nrmse=self.nrmse,
            **self.analysis.to_mapping(),
            correlations=columns,
        )

    def _draw(self) -> Figure:
        from camid.drawing.residuals import draw

        return draw(self)


@one_blas_thread()
def residual_correlations(
    recording: RecordingSource | list[RecordingSource],
    simulation: Simulation,
    name: str,
    progress: Callable[[str], None] | None = None,
) -> ResidualCorrelations:
    """Test what a model leaves of recordings.

    A model that says how accurate it is was fitted, and what a fit takes of the noise is accounted for. The residual of
    one that does not is taken as it is.

    Raises
    ------
    InputError
        If recording and model do not fit together, periods differ, or the residual is not finite.
    """
    refuse_unknown_clock(simulation)
    fitted = states_accuracy(simulation)
    reopened = _reopened(simulation) if fitted else simulation
    recordings, experiments, _ = experiments_of(recording, reopened, progress)
    _refuse_other_periods(recordings)
    if progress:
        progress("testing the residual")
    try:
        found = _analysed(reopened, recordings, experiments, fitted=fitted)
    except InputError:
        raise
    except (ValueError, ArithmeticError) as error:
        raise InputError(str(error), where=simulation.source, hint="check the values of plant and effects") from None
    if found is None:
        raise InputError(
            "the residual is not finite", where=simulation.source, hint="does camid simulate run this model?"
        )
    analysis, residual, recorded = found
    closed = simulation.controller is not None
    source, output = simulation.input_column, simulation.output_column
    remarks = list(warnings_of(recordings))
    if not fitted:
        remarks.append(
            f"{name} states no accuracy: it is taken as a belief, of which nothing was fitted to this recording"
        )
    if closed:
        remarks.append("in a closed loop the residual is that of the control, and it must not depend on the reference")
    if simulation.observer is not None:
        remarks.append(
            "an observer answers the noise, so that what is left of a right model has a colour, and depends on an "
            "input that a controller made of the same noise; camid diagnose allows for both"
        )
    size = float(np.max(np.abs(recorded))) or 1.0  # squares must not overflow
    spread = float(np.std(recorded / size))
    return ResidualCorrelations(
        analysis,
        recordings[0].period,
        float(np.sqrt(np.mean((residual / size) ** 2))) / spread if spread > 0.0 else None,
        name,
        ", ".join(r.source for r in recordings),
        (
            str(source) if closed else ", ".join(simulation.output_columns) or output,
            "" if source is None else simulation.controller.reference if simulation.controller is not None else source,
        ),
        tuple(remarks),
    )


def _refuse_other_periods(recordings: Sequence[Recording]) -> None:
    """A lag in samples is one time in all recordings, or their correlations must not be added."""
    first = recordings[0]
    for other in recordings[1:]:
        if abs(other.period / first.period - 1.0) > SAME_PERIOD:
            raise InputError(
                f"its period is {1e3 * other.period:g} ms, that of {first.source} {1e3 * first.period:g} ms, and a lag "
                "is a number of samples",
                where=other.source,
                hint="test recordings of other periods by themselves",
            )


def _reopened(simulation: Simulation) -> Simulation:
    """The model with those constants unknown again that were estimated with it: the fit took what they explain."""
    counted = simulation.is_read_from_zero
    return replace(
        simulation,
        offset=simulation.offset if counted or simulation.offset_deviation is None else "estimate",
        bias=simulation.bias if counted or simulation.bias_deviation is None else "estimate",
        offset_deviation=None,
        bias_deviation=None,
    )


def _analysed(
    simulation: Simulation, recordings: list[Recording], experiments: list[Experiment], *, fitted: bool
) -> tuple[ResidualAnalysis, Array, Array] | None:
    """Tests, residual and recorded values on the rows that were fitted."""
    kind = kind_of(simulation, recordings)
    structure = structure_of(simulation)
    if not simulation.effects and kind.simulated_exactly(simulation, recordings[0]) is not None:
        wanted = structure if fitted else Structure.fixed(simulation.plant)
        analysis = analyse_residual(wanted, simulation.plant.monic, experiments)
        if analysis is None:
            return None
        rows = _exact_residual(wanted, simulation, experiments)
        return analysis, rows, np.concatenate([e.output[e.used] for e in experiments])
    known = problem_of(simulation, Structure.fixed(simulation.plant), recordings, experiments).all_fixed()
    problem = problem_of(simulation, structure, recordings, experiments) if fitted else known
    result = _at_model(problem, known, simulation, fitted=fitted)
    if not np.all(np.isfinite(result.residual)):
        return None
    driven = problem.experiments
    if simulation.controller is not None:
        reference = simulation.controller.reference
        driven = [replace(e, signal=r.columns[reference]) for e, r in zip(driven, recordings, strict=True)]
    analysis = analyse_given(driven, result.residual, result.sensitivities)
    return analysis, result.residual, problem.output


def _exact_residual(structure: Structure, simulation: Simulation, experiments: list[Experiment]) -> Array:
    """Residual of a linear plant, its unknown constants fitted."""
    from camid.identification.predictor import Predictor

    structure, plant, scaled, _ = in_units_of_the_data(structure, simulation.plant.monic, experiments)
    size = float(np.max(np.abs(experiments[0].output))) / (float(np.max(np.abs(scaled[0].output))) or 1.0)
    predictor = Predictor.around(structure, scaled, np.array(plant.denominator))
    coefficients = np.array([*plant.numerator, *plant.denominator[1:]])
    return size * predictor.linearise(predictor.with_fitted_initial_states(coefficients))[0]


def _at_model(problem: Problem, known: Problem, simulation: Simulation, *, fitted: bool) -> Fitted:
    """The model with the initial states and unknown constants that fit, and what it leaves.

    ``known`` is the problem with nothing else to be fitted, ``problem`` that in which what a fit took is accounted for.
    """
    effects = tuple(e for e in effects_of(simulation) if not e.noise_like)
    start = known.with_initial_states(model_of(known, effects))
    if any(state is not None for state in start.initial) or known.kind.free_constants():
        start = fit(known, start, steps=STEPS, fixed=len(effects)).model
    pinned = problem.pinned(start, finest=True)
    return evaluate(pinned, start, 0 if fitted else len(effects))
