"""``camid.select_order``: how many poles and zeros a recording supports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from camid.commands.identify import MOST_POLES
from camid.errors import InputError
from camid.fitting.from_simulation import kind_of
from camid.identification.from_recordings import RecordingSource, SimulationSource, experiments_of, warnings_of
from camid.linear_algebra_threads import one_blas_thread
from camid.simulation.file import load_simulation

if TYPE_CHECKING:
    from camid.identification.order_selection import OrderSelection


@one_blas_thread()
def select_order(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    *,
    largest: int = 4,
    progress: Callable[[str], None] | None = None,
) -> OrderSelection:
    """Estimate plants of every order and choose the lowest that explains one or several recordings of a rig.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
    simulation : path, mapping or Simulation
        What is believed of input, sensor and initial state; its plant counts for nothing.
    largest : int
        Largest number of poles.
    progress : callable, optional
        Called with a sentence about the current step.

    Returns
    -------
    OrderSelection
        ``table`` of all candidates, and ``poles`` and ``zeros`` of the chosen one.

    Raises
    ------
    InputError
        If recording and simulation do not fit together, there is no input, or the data are too few.
    """
    from camid.identification.order_selection import select_order as run

    believed = load_simulation(simulation)
    if believed.input_column is None:
        raise InputError(
            "a free decay does not determine the zeros", where=believed.source, hint="record an input, too"
        )
    if believed.reading.frame_time is not None:
        raise InputError(
            "order takes frames and input for samples of one clock, and the frames have times of their own",
            where=believed.source,
            hint="identify plants of several orders with --order, and hold them against each other with camid compare",
        )
    if believed.effects:
        raise InputError(
            "order compares linear chains, and this simulation has effects",
            where=believed.effects[0].where,
            hint="remove the effects",
        )
    refused = kind_of(believed, []).why_no_other_orders
    if refused is not None:
        problem, hint = refused
        raise InputError(f"order compares {problem}", where=believed.source, hint=hint)
    if largest < 1:
        raise InputError(f"the largest order is {largest}", hint="it takes at least one pole")
    if largest > MOST_POLES:
        raise InputError(f"the largest order is {largest}", hint=f"coefficients of more than {MOST_POLES} mean nothing")
    recordings, experiments, _ = experiments_of(recording, believed, progress)
    try:
        selection = run(experiments, largest, progress=progress)
        return replace(selection, recording_warnings=warnings_of(recordings))
    except (ValueError, ArithmeticError) as error:
        raise InputError(str(error), where=recordings[0].source, hint="record longer, or check the units") from None
