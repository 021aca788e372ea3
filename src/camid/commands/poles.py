"""``camid.poles``: poles and zeros of models with 95 % ellipses."""

from __future__ import annotations

from camid.analysis.linear_model import linear_models
from camid.analysis.models import ModelSource, named_models
from camid.analysis.poles_and_zeros import PolesAndZeros, roots_of
from camid.errors import InputError, need


def poles(*models: ModelSource) -> PolesAndZeros:
    """Poles and zeros of the (linearised) plants of models, with their uncertainty.

    Parameters
    ----------
    *models : path, mapping, Simulation, result of ``camid.identify`` or ``camid.diagnose``, or python-control system

    Returns
    -------
    PolesAndZeros
        ``numbers`` is a table, ``figure()`` draws, ``save(path)`` writes.

    Raises
    ------
    InputError
        If a model cannot be read, or has no linear plant.
    """
    need("a map of poles", "control")
    linear = linear_models(named_models(models, plants_alone=True))
    roots = [root for model in linear for root in roots_of(model)]
    if not roots:
        raise InputError("there are neither poles nor zeros", where=linear[0].name, hint="give the plant some dynamics")
    remarks = [sentence for model in linear for sentence in (*model.linearised, *model.remarks)]
    return PolesAndZeros(roots, [m.name for m in linear], tuple(remarks))
