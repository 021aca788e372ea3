"""Constants beside a plant that every kind may have, and that a simulation may leave open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from camid.effects.parameter import Parameter
from camid.fitting.fit import Fitted
from camid.simulation.model import Simulation

# Constants that every kind may have, measured by what they are added to.
OFFSET = Parameter("offset", "y", "reading at the plant's zero", scale="output")
BIAS = Parameter("bias", "u", "what is added to the input", scale="input")
SKEW = Parameter("skew", "", "relative rate of the camera's clock", -0.1, 0.1, scale="slip")
# Latency, in periods, that is none.
AT_ZERO = 1e-6
LATENCY = Parameter("latency", "s", "from the end of an exposure to its time stamp", 0.0, scale="period")


def with_constants(believed: Simulation, fitted: Fitted, free: Sequence[Parameter]) -> Simulation:
    """The simulation with those constants that were estimated, in place of what it said of them.

    Parameters
    ----------
    believed : Simulation
    fitted : Fitted
    free : sequence of Parameter
        What the fit estimates beside coefficients.
    """
    found: dict[str, float | None] = {}
    names = fitted.packing.names
    for constant in free:
        if constant in (OFFSET, BIAS, LATENCY, SKEW):
            variance = float(fitted.covariance[names.index(constant.name), names.index(constant.name)])
            value = float(fitted.model.constants[constant.name])
            # A search stays a hair inside its bounds.
            at_zero = constant is LATENCY and value < AT_ZERO * fitted.problem.acquisition.period
            found[constant.name] = 0.0 if at_zero else value
            found[f"{constant.name}_deviation"] = float(np.sqrt(variance)) if np.isfinite(variance) else None
    return replace(believed, **found)  # type: ignore[arg-type]
