"""Section 3.1: the closed form (16)–(23), the exact discretisation and a model identified from camera data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from camid.chain.acquisition import Acquisition
from camid.chain.camera_models import closed_form, first_order_hold_equivalent, sampled_model
from camid.chain.exact import sample
from camid.identification.discrete_time import least_squares
from camid.paper.datasets import believed_plant


def compare_discrete_time(
    excitation: pd.DataFrame, plant: Mapping[str, float], periods: Sequence[float]
) -> pd.DataFrame:
    """The five coefficients of (16) from four sources.

    Returns
    -------
    DataFrame
        Columns ``period`` (s), ``coefficient``, ``closed_form``, ``exact`` (camera chain), ``hold_equivalent``
        (python-control's first-order hold, without delay), ``identified`` (one delay, orders two above and below).
    """
    truth, signal = believed_plant(plant), excitation["u"].to_numpy()
    tables = []
    for period in periods:
        written = closed_form(plant["static_gain"], plant["natural_frequency"], plant["damping"], period)
        exact = sampled_model(truth, Acquisition(period))
        triangle = first_order_hold_equivalent(truth, period)
        output = sample(truth, signal, Acquisition(period))
        identified = least_squares(signal, output, poles=2, zeros=2, delay=1)
        exact_denominator, triangle_denominator = exact.den[0][0], triangle.den[0][0]
        tables.append(
            pd.DataFrame(
                {
                    "period": period,
                    "coefficient": ["beta_0", "beta_1", "beta_2", "alpha_1", "alpha_2"],
                    "closed_form": [*written.beta, *written.alpha],
                    "exact": [*exact.num[0][0], -exact_denominator[1], exact_denominator[2]],
                    "hold_equivalent": [*triangle.num[0][0], -triangle_denominator[1], triangle_denominator[2]],
                    "identified": [*identified.numerator, -identified.denominator[1], identified.denominator[2]],
                }
            )
        )
    return pd.concat(tables, ignore_index=True)
