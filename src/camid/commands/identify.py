"""``camid.identify``: recordings as a simulation declares them, from loading to the tests of the residual."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.identification.loading import RecordingSource, SimulationSource, experiments_of, warnings_of
from camid.identification.result import Identification
from camid.recording.recording import Recording
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    from camid.chain.plant import TransferFunction
    from camid.identification.estimate import Estimate
    from camid.identification.experiment import Experiment
    from camid.identification.structure import Structure


def identify(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    *,
    structure: tuple[int, int] | None = None,
    method: str = "srivc",
    progress: Callable[[str], None] | None = None,
) -> Identification:
    """Re-estimate the plant of a simulation from one or several recordings of the same rig.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
        Each has an initial state of its own, if it is estimated.
    simulation : path, mapping or Simulation
        Its transfer function gives the orders and one starting value; a mapping may hold a continuous-time
        python-control system with one input and one output as ``plant``. A known delay is the sensor's latency;
        coefficients with ``free: false`` keep their value.
    structure : (int, int), optional
        Numbers of poles and zeros; the transfer function of the simulation then counts for nothing. Needs an input.
    method : {"srivc", "output-error", "plain-srivc"}
        See :func:`camid.identification.estimate.estimate`.
    progress : callable, optional
        Called with a sentence about the step at hand.

    Raises
    ------
    InputError
        If recording and simulation do not fit together or the data are too few.
    """
    return _identified(recording, load_simulation(simulation), structure, method, progress)


def _identified(
    recording: RecordingSource | Sequence[RecordingSource],
    believed: Simulation,
    structure: tuple[int, int] | None,
    method: str,
    progress: Callable[[str], None] | None,
) -> Identification:
    """Identification of what a simulation declares."""
    from camid.identification.estimate import METHODS, estimate

    if believed.effects:
        raise InputError(
            "identify re-estimates linear chains, and this simulation has effects",
            where=believed.effects[0].where,
            hint="camid diagnose re-estimates plant and effects together (improved.yaml)",
        )
    beyond = "a pendulum" if believed.pendulum else "a closed loop" if believed.controller else None
    if beyond is not None and structure is not None:
        raise InputError(f"an order is chosen, and {beyond} has its own", where=believed.source, hint="leave it out")
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known", hint=f"it must be one of {', '.join(METHODS)}")
    wanted, nominal = _wanted(believed, structure)
    recordings, experiments, held_out = experiments_of(recording, believed, progress)
    unknowns = int(wanted.free.sum()) + wanted.order * sum(e.estimate_initial_state for e in experiments)
    available = int(sum(e.used.sum() for e in experiments))
    if available <= unknowns:
        raise InputError(
            f"{available} samples are fewer than needed for {unknowns} parameters",
            where=recordings[0].source,
            hint="record longer, or choose a lower order",
        )
    if not wanted.free.any():
        raise InputError("no coefficient is free", where=believed.source, hint="free one under plant.free")
    try:
        if believed.pendulum is not None or believed.controller is not None:
            from camid.fitting.identified_plant import identify_by_simulation

            found = identify_by_simulation(believed, recordings, experiments, held_out)
            return replace(found, recording_warnings=warnings_of(recordings))
        result = estimate(wanted, experiments, nominal=nominal, method=method, progress=progress)
        identification = _identification(believed, result, recordings, experiments, held_out)
        return _analysed(identification, wanted, experiments, progress)
    except (ValueError, ArithmeticError) as error:
        raise InputError(
            f"no estimate: {error}", where=recordings[0].source, hint="try another order, or check the units"
        ) from None


def _wanted(believed: Simulation, structure: tuple[int, int] | None) -> tuple[Structure, TransferFunction | None]:
    """What is looked for, and the plant to start from where one is believed."""
    from camid.identification.structure import Structure

    if believed.input_column is None:
        if not believed.estimates_initial_state:
            raise InputError(
                "without input and at rest nothing moves",
                where=believed.source,
                hint="set initial_state: estimate for a free decay",
            )
        if structure is not None:
            raise InputError(
                "a free decay says nothing of the numerator, and an order alone gives it no value",
                where=believed.source,
                hint="leave the order out and write a transfer_function",
            )
    if structure is not None:
        poles, zeros = structure
        if poles < 1 or not 0 <= zeros <= poles:
            raise InputError(
                f"order {poles} {zeros} is improper",
                hint="it takes at least one pole and at most as many zeros as poles",
            )
        return Structure.of_order(poles, zeros), None
    monic = believed.plant.monic
    if monic.order == 0:
        raise InputError("the plant has no dynamics", where=believed.source, hint="give it at least one pole")
    # A free decay says nothing of the numerator: it keeps its believed value.
    free_numerator = believed.free_numerator & (believed.input_column is not None)
    return (
        Structure(np.array(monic.numerator), np.array(monic.denominator), free_numerator, believed.free_denominator),
        believed.plant,
    )


def _identification(
    believed: Simulation,
    result: Estimate,
    recordings: list[Recording],
    experiments: list[Experiment],
    held_out: list[NDArray[np.bool_]],
) -> Identification:
    from camid.chain.plant import TransferFunction

    lead = believed.plant.denominator[0] if len(believed.plant.denominator) == result.plant.order + 1 else 1.0
    split = len(result.plant.numerator)
    deviations, covariance = abs(lead) * result.standard_deviations, np.square(lead) * result.covariance
    free_numerator, free_denominator = result.free[:split], np.concatenate([[False], result.free[split:]])
    if believed.input_column is None:  # the numerator was not fitted, but a recording with an input may fit it
        free_numerator = believed.free_numerator
    plant = TransferFunction(
        tuple(lead * b for b in result.plant.numerator), tuple(lead * a for a in result.plant.denominator)
    )
    model = replace(
        believed,
        plant=plant,
        exposure=experiments[0].acquisition.exposure if believed.sensor == "camera" else None,
        free_numerator=free_numerator,
        free_denominator=free_denominator,
        # Where the data leave a coefficient undetermined there is no accuracy to write down.
        standard_deviations={
            "numerator": [float(v) for v in deviations[:split]],
            "denominator": [0.0, *(float(v) for v in deviations[split:])],
        }
        if np.all(np.isfinite(deviations))
        else None,
        covariance=covariance.tolist() if np.all(np.isfinite(covariance)) else None,
    )

    def nrmse(rows: list[NDArray[np.bool_]]) -> float:
        residual = np.concatenate([r[k] for r, k in zip(result.residuals, rows, strict=True)])
        recorded = np.concatenate([e.output[k] for e, k in zip(experiments, rows, strict=True)])
        spread = float(np.std(recorded))
        return float(np.sqrt(np.mean(residual**2))) / spread if spread > 0.0 else float("inf")

    fitted = [e.used for e in experiments]
    return Identification(
        simulation=model,
        estimate=result,
        converged=result.converged,
        period=recordings[0].period,
        rows_fitted=int(sum(k.sum() for k in fitted)),
        nrmse=nrmse(fitted),
        nrmse_validation=nrmse(held_out) if any(k.any() for k in held_out) else None,
        acquisition=experiments[0].acquisition,
        recording_warnings=warnings_of(recordings),
    )


def _analysed(
    identification: Identification,
    wanted: Structure,
    experiments: list[Experiment],
    progress: Callable[[str], None] | None,
) -> Identification:
    """The identification with the tests of its residual and, where they contradict the declaration, with others."""
    from camid.identification.declarations import alternative_declarations
    from camid.identification.residual_analysis import analyse_residual

    plant = identification.estimate.plant
    try:
        analysis = analyse_residual(wanted, plant, experiments)
    except (ValueError, ArithmeticError):  # a method without safeguard ran away
        return identification
    alternatives = []
    if identification.converged and analysis is not None and analysis.contradicts:
        alternatives = alternative_declarations(wanted, plant, experiments, progress)
    return replace(identification, residual_analysis=analysis, alternatives=alternatives)
