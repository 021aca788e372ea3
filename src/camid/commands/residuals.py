"""``camid.residuals``: what a model leaves of recordings, against itself and against the input."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from camid.analysis.models import ModelSource, named_models
from camid.analysis.residual_correlations import ResidualCorrelations, residual_correlations
from camid.identification.from_recordings import RecordingSource


def residuals(
    recording: RecordingSource | Sequence[RecordingSource],
    model: ModelSource,
    *,
    progress: Callable[[str], None] | None = None,
) -> ResidualCorrelations:
    """Autocorrelation of the residual, and its correlation with the input, with 99 % bounds.

    Of a model that ``camid.identify`` wrote, with the recordings that it was fitted to, these are the numbers of
    ``--residuals``. Plants that the engine runs (effects, pendulums, equations, closed loops) are tested likewise.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
    model : path, mapping, Simulation or result of ``camid.identify`` or ``camid.diagnose``
        What a model with stated accuracy took of the noise is accounted for; one without is taken as it is.
    progress : callable, optional
        Called with a sentence about the current step.

    Returns
    -------
    ResidualCorrelations
        ``numbers`` is a table, ``figure()`` draws, ``save(path)`` writes.

    Raises
    ------
    InputError
        If recording and model do not fit together.
    """
    ((name, simulation),) = named_models([model]).items()
    return residual_correlations(recording, simulation, name, progress)
