"""``camid.bode``: frequency responses of models with bands, and that of a recording beside them."""

from __future__ import annotations

import os
from pathlib import Path

from camid.analysis.empirical_response import empirical_response
from camid.analysis.frequency_response import FrequencyResponses, ResponseCurve, frequencies_for
from camid.analysis.linear_model import LinearModel, linear_models, units_of
from camid.analysis.models import ModelSource, named_models
from camid.chain.acquisition import Acquisition
from camid.effects.declared import effects_of
from camid.errors import InputError, need
from camid.fitting.simulated_output import refuse_unknown_clock
from camid.identification.from_recordings import RecordingSource, acquisition_of, load_recordings, warnings_of
from camid.recording.recording import Recording
from camid.simulation.model import Simulation


def bode(
    *models: ModelSource,
    recording: RecordingSource | None = None,
    camera: bool = False,
    frequencies: tuple[float, float] | None = None,
    segment: float | None = None,
) -> FrequencyResponses:
    """Frequency responses of the (linearised) plants of models, with 95 % bands from their covariances.

    Parameters
    ----------
    *models : path, mapping, Simulation, result of ``camid.identify`` or ``camid.diagnose``, or python-control system
        Of a nonlinear plant that of small motions; ``said()`` says what is left out.
    recording : path or DataFrame, optional
        Whose empirical frequency response stands beside them; it is read as the first model says.
    camera : bool
        Whether exposure and latency of the sensor are part of what is shown.
    frequencies : tuple of float, optional
        Lowest and highest angular frequency in rad/s; python-control chooses them where they are left out.
    segment : float, optional
        Seconds over which a spectrum of the recording is taken.

    Returns
    -------
    FrequencyResponses
        ``numbers`` is a table, ``figure()`` draws, ``save(path)`` writes.

    Raises
    ------
    InputError
        If a model cannot be read, has no linear plant, or says too little of its sensor; if the recording has no input.
    """
    need("a frequency response", "control")
    simulations = named_models(models, plants_alone=True)
    if frequencies is not None and not 0.0 < frequencies[0] < frequencies[1] < float("inf"):
        raise InputError(
            f"frequencies from {frequencies[0]:g} to {frequencies[1]:g} rad/s", hint="give two positive ones, ascending"
        )
    if segment is not None and recording is None:
        raise InputError("a segment is one of a recording", hint="name the recording, too")
    linear = linear_models(simulations)
    first = next(iter(simulations.values()))
    recordings: list[Recording] = []
    if recording is not None:
        refuse_unknown_clock(first)
        if first.output_columns:
            seen, output = ", ".join(first.output_columns), units_of(first).output.column
            raise InputError(
                f"a recording shows {seen}, and not the plant's output '{output}'",
                where=first.source,
                hint="leave the recording out; camid compare shows all columns",
            )
        recordings = load_recordings(recording, first, output_needed=True)
    empirical = None
    if recordings:
        empirical = empirical_response(recordings, first, seen_by_camera=camera, segment=segment)
    omega = frequencies_for(linear, frequencies, empirical)
    curves = [ResponseCurve.of(m, omega, _camera(m, recordings) if camera else None) for m in linear]
    remarks = [sentence for model in linear for sentence in (*model.linearised, *model.remarks)]
    if len(recordings) > 1 and isinstance(recording, str | os.PathLike):
        remarks.append(f"{Path(recording).name}: the spectra of its {len(recordings)} experiments are averaged")
    return FrequencyResponses(curves, empirical, camera, units_of(first), (*remarks, *warnings_of(recordings)))


def _camera(model: LinearModel, recordings: list[Recording]) -> Acquisition:
    """Exposure and latency of a model's sensor, with what its effects declare of them."""
    simulation = model.simulation
    refuse_unknown_clock(simulation)
    acquisition = acquisition_of(recordings[0], simulation) if recordings else _without_recording(simulation)
    for effect in effects_of(simulation):
        acquisition = effect.declare(acquisition)
    return acquisition


def _without_recording(simulation: Simulation) -> Acquisition:
    """The same where no recording says what the period is."""
    if simulation.sensor == "camera" and simulation.exposure is None:
        raise InputError(
            "the exposure is the period, which no model states",
            where=f"{simulation.source}, sensor",
            hint="write exposure into the file, or name a recording",
        )
    return simulation.acquisition(simulation.exposure or 1.0)
