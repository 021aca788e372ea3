"""``camid.identify``: recordings as a simulation declares them, from loading to the tests of the residual."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from camid.chain.plant import TransferFunction
from camid.commands.results import IdentificationResult
from camid.effects.declared import effects_of
from camid.effects.own_effects import EffectSource, own_effects
from camid.errors import InputError
from camid.fitting.from_simulation import kind_of, problem_of, refuse_stillness, structure_of
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.identified_by_simulation import identify_by_simulation
from camid.identification.estimate import METHODS
from camid.identification.experiment import Experiment
from camid.identification.from_recordings import (
    RecordingSource,
    SimulationSource,
    experiments_or_free_decay,
    warnings_of,
)
from camid.identification.identification import Identification
from camid.identification.structure import Structure
from camid.identification.unknown_constants import why_no_offset
from camid.linear_algebra_threads import one_blas_thread
from camid.recording.recording import Recording
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

# The coefficients of a polynomial of a higher degree differ by more than the digits of a number.
MOST_POLES = 20


@one_blas_thread()
def identify(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    *,
    structure: tuple[int, int] | None = None,
    method: str = "srivc",
    progress: Callable[[str], None] | None = None,
    effects: Sequence[EffectSource] | EffectSource = (),
) -> IdentificationResult:
    """Re-estimate the plant of a simulation from one or several recordings of the same rig.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
        Each has an initial state of its own, if it is estimated.
    simulation : path, mapping or Simulation
        Its transfer function gives the orders and one starting value; a mapping may hold a continuous-time
        python-control system with one input and one output as ``plant``. A known delay is the sensor's latency;
        coefficients with ``free: false`` keep their value. Effects are re-estimated with the plant, by output error.
    structure : (int, int), optional
        Numbers of poles and zeros; the transfer function of the simulation then counts for nothing. Needs an input.
    method : {"srivc", "output-error", "plain-srivc"}
        See :func:`camid.identification.estimate.estimate`.
    progress : callable, optional
        Called with a sentence about the current step.
    effects : sequence of path or subclass of Effect, optional
        Effects of your own that the simulation may name. A file is Python, and is run.

    Returns
    -------
    IdentificationResult
        Estimates and tests of the residual; ``compare``, ``bode``, ``poles``, ``step`` and ``residuals`` draw them.

    Raises
    ------
    InputError
        If recording and simulation do not fit together or the data are too few.
    """
    with own_effects(effects):
        found = _identified(recording, load_simulation(simulation), structure, method, progress)
    return IdentificationResult.of(found, recording if isinstance(recording, list | tuple) else [recording])


def _identified(
    recording: RecordingSource | Sequence[RecordingSource],
    believed: Simulation,
    order: tuple[int, int] | None,
    method: str,
    progress: Callable[[str], None] | None,
) -> Identification:
    """Identification of what a simulation declares."""
    effects = effects_of(believed)
    if effects and order is not None:
        raise InputError(
            "an order is chosen, and this simulation has effects",
            where=believed.effects[0].where,
            hint="leave the order out, or remove the effects",
        )
    prescribing = kind_of(believed, []).prescribes_order
    if prescribing is not None and order is not None:
        raise InputError(
            f"an order is chosen, and {prescribing} has its own", where=believed.source, hint="leave it out"
        )
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known", hint=f"it must be one of {', '.join(METHODS)}")
    structure, nominal = _wanted(believed, order)
    believed, recordings, experiments, held_out = experiments_or_free_decay(recording, believed, progress)
    if believed.input_column is None:
        structure, nominal = _wanted(believed, order)
    _refuse_undetermined(structure, believed, recordings, experiments)
    problem = problem_of(believed, structure, recordings, experiments)
    try:
        task = IdentificationTask(believed, recordings, held_out, nominal, method, progress, effects)
        found = identify_by_simulation(problem, task) if effects else problem.kind.identified(problem, task)
    except InputError:
        raise
    except (ValueError, ArithmeticError) as error:
        raise InputError(
            f"no estimate: {error}", where=recordings[0].source, hint="try another order, or check the units"
        ) from None
    why = why_no_offset(experiments, believed)
    notes = (*found.notes, *(() if why is None else (why,)), *problem.kind.remarks(found.simulation))
    return replace(found, recording_warnings=warnings_of(recordings), notes=notes)


def _refuse_undetermined(
    structure: Structure, believed: Simulation, recordings: list[Recording], experiments: list[Experiment]
) -> None:
    """Refuse recordings with fewer samples than unknowns, and structures without any."""
    unknowns = int(structure.free.sum()) + structure.order * sum(e.estimate_initial_state for e in experiments)
    available = int(sum(e.used.sum() for e in experiments))
    if available <= unknowns:
        raise InputError(
            f"{available} samples are fewer than needed for {unknowns} parameters",
            where=recordings[0].source,
            hint="record longer, or choose a lower order",
        )
    if structure.order > MOST_POLES:
        hint = f"coefficients of more than {MOST_POLES} mean nothing"
        raise InputError(f"{structure.order} poles", where=believed.source, hint=hint)
    clock_open = "estimate" in (believed.latency, believed.skew)
    if not structure.free.any() and believed.physical is None and not clock_open:
        raise InputError("no coefficient is free", where=believed.source, hint="free one under plant.free")


def _wanted(believed: Simulation, order: tuple[int, int] | None) -> tuple[Structure, TransferFunction | None]:
    """What is looked for, and the plant to start from where one is believed."""
    refuse_stillness(believed)
    if believed.input_column is None and order is not None:
        raise InputError(
            "a free decay does not determine the numerator, and an order alone gives it no value",
            where=believed.source,
            hint="leave the order out and write a transfer_function",
        )
    if order is not None:
        poles, zeros = order
        if poles < 1 or not 0 <= zeros <= poles:
            raise InputError(
                f"order {poles} {zeros} is improper",
                hint="it takes at least one pole and at most as many zeros as poles",
            )
        return Structure.of_order(poles, zeros), None
    return structure_of(believed), believed.plant
