"""The coefficients of a first simulation: of the few structures fitted, the simplest that explains about as much."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from camid.chain.plant import TransferFunction
from camid.commands.identify import identify
from camid.commands.results import IdentificationResult
from camid.draft.simulation import MAIN_ROWS, Draft
from camid.errors import InputError
from camid.number_text import percentage
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

READ_OFF = "A guess: a resonance read off the output"
# A fit that leaves more than this is no better to start from than what was read off; with a free decay that tells more.
LARGEST_RESIDUAL, LARGEST_OF_DECAY = 0.9, 0.3
# One that leaves more than this, about half of the power, has to be the optimum of a plant that comes to rest: a slow
# pole follows a drift, whatever the plant is.
DOUBTFUL_RESIDUAL = 0.7
# A simpler structure is taken if it leaves at most this much more, and explains at least this share of the power.
LEAVES_MORE, EXPLAINS = 1.1, 0.98
# A pole that does not decay by more than a factor of e over the recording may be that of an integrator.
SLOW_POLE = 1.0


@dataclass(frozen=True)
class _Structure:
    """A structure to fit: numbers of poles and zeros, or a transfer function with the poles that are known."""

    words: str
    order: tuple[int, int] | None = None
    plant: TransferFunction | None = None


# From the simplest on.
INTEGRATOR = _Structure("An integrator", plant=TransferFunction((1.0,), (1.0, 0.0)))
FIRST_ORDER = _Structure("A first-order plant", order=(1, 0))
LAG_AND_INTEGRATOR = _Structure("An integrator with a first-order lag", plant=TransferFunction((1.0,), (1.0, 1.0, 0.0)))
SECOND_ORDER = _Structure("A second-order plant", order=(2, 0))
SIMPLEST_FIRST = (INTEGRATOR, FIRST_ORDER, LAG_AND_INTEGRATOR, SECOND_ORDER)


def fitted(draft: Draft, path: Path, recording: Recording, progress: Callable[[str], None] | None) -> Draft:
    """The draft with coefficients that were fitted to the first rows, where they are better than those read off."""
    believed, rows, period = draft.simulation, len(recording), recording.period
    reading = believed.reading
    if len(reading.runs) > 1:
        reading = replace(reading, runs=reading.runs[:1])
    if rows > MAIN_ROWS:
        reading = replace(reading, end=float(recording.time[0]) + (MAIN_ROWS - 0.5) * period)
    declared = replace(believed, reading=reading)
    duration = min(rows, MAIN_ROWS) * period
    try:
        structure, result = _best(path, declared, duration, progress)
    except InputError as refused:
        return replace(draft, fit=f"{READ_OFF}; a fit was not possible: {refused.problem}")
    found: Simulation = result.simulation
    share = percentage(result.nrmse)
    if not _is_usable(result, duration, free_decay=believed.input_column is None):
        words = (
            "a second-order" if structure is SECOND_ORDER else structure.words[0].lower() + structure.words[1:] + "'s"
        )
        return replace(draft, fit=f"{READ_OFF}; {words} fit leaves {share} and is not used")
    used = f"the first {MAIN_ROWS}" if rows > MAIN_ROWS else f"all {rows}"
    simulation = replace(
        believed, plant=found.plant, free_numerator=found.free_numerator, free_denominator=found.free_denominator
    )
    remarks = dict(draft.remarks)
    if isinstance(found.bias, float):  # an integrator moves the further from the recording, the longer it runs without
        simulation = replace(simulation, bias="estimate")
        remarks["bias of u"] = f"about {float(f'{found.bias:.3g}')!r}: an integrator adds it up"
    said = f"{structure.words} fitted to {used} rows; it leaves {share} of the output's standard deviation"
    return replace(draft, simulation=simulation, remarks=remarks, fit=said)


def _best(
    path: Path, declared: Simulation, duration: float, progress: Callable[[str], None] | None
) -> tuple[_Structure, IdentificationResult]:
    """The simplest structure that explains about as much as the best of them; of a free decay, the second order."""
    if declared.input_column is None:
        return SECOND_ORDER, identify(path, declared, progress=progress)
    found: dict[_Structure, IdentificationResult] = {}
    refused: InputError | None = None
    for structure, alike in ((SECOND_ORDER, LAG_AND_INTEGRATOR), (FIRST_ORDER, INTEGRATOR)):
        try:
            found[structure] = identify(path, declared, structure=structure.order, progress=progress)
        except InputError as error:
            refused = error
        if structure not in found or _has_slow_pole(found[structure], duration):
            try:
                found[alike] = identify(path, _with_plant(declared, alike.plant), progress=progress)
            except InputError as error:
                refused = refused or error
    # Where nothing that may be used was found, what the usual structure leaves is told.
    usable = {s: r for s, r in found.items() if _is_usable(r, duration)}
    if not usable:
        if refused is not None and SECOND_ORDER not in found:
            raise refused
        return SECOND_ORDER, found[SECOND_ORDER]
    least = min(r.nrmse for r in usable.values())
    return next((s, usable[s]) for s in SIMPLEST_FIRST if s in usable and _as_good(usable[s].nrmse, least))


def _with_plant(declared: Simulation, plant: TransferFunction | None) -> Simulation:
    assert plant is not None
    empty = np.zeros(0, bool)  # the freedom of its coefficients is that of another plant
    return replace(declared, plant=plant, free_numerator=empty, free_denominator=empty)


def _has_slow_pole(result: IdentificationResult, duration: float) -> bool:
    return bool(np.any(np.abs(result.simulation.plant.poles()) * duration < SLOW_POLE))


def _is_usable(result: IdentificationResult, duration: float, *, free_decay: bool = False) -> bool:
    """Whether a fit is better to start from than what is read off: a search that did not end may still explain much."""
    plant = result.simulation.plant
    if plant.unstable_poles().size or not result.nrmse < (LARGEST_OF_DECAY if free_decay else LARGEST_RESIDUAL):
        return False
    if free_decay or result.nrmse >= DOUBTFUL_RESIDUAL:
        return result.converged and (free_decay or not _has_slow_pole(result, duration))
    return True


def _as_good(share: float, least: float) -> bool:
    return share <= LEAVES_MORE * least and 1.0 - share**2 >= EXPLAINS * (1.0 - least**2)
