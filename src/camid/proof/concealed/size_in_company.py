"""How far an effect rises above the noise beside the others of its recording.

What is large alone may not show in company: a machine whose actuator has a dead zone never reaches its end stop, and
half an exposure is a lag. The size is that of what leaving an effect out changes, less what the machine's coefficients
and the strengths of the other effects can make up for, in the noise that there is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.camera_readings import clean, motion, readings, record
from camid.proof.concealed.detectability import multiple
from camid.proof.concealed.drawn_recording import Built, DrawnRecording
from camid.proof.concealed.machine_integrator import DivergedError
from camid.proof.concealed.rig_setup import MOVING_LEAD, Setup

Array = NDArray[np.float64]

# The first that a machine has is kept: to change all of them would be to change the forces beside them.
COEFFICIENTS = (
    s.MASS,
    s.DAMPING,
    s.STIFFNESS,
    s.ACTUATOR_CONSTANT,
    s.SERIES_FREQUENCY,
    s.SERIES_DAMPING,
    s.SERIES_LAG,
)
# Relative changes of a coefficient and of a strength, and parts of the command before the first frame: as many as the
# machine may have states.
COEFFICIENT_STEP, STRENGTH_STEP = 1e-3, 0.02
EARLIER_PARTS = 4
# Directions that are smaller than this share of the largest are rounding.
SMALLEST_DIRECTION = 1e-8
# Share of a Gaussian's values that are smaller than its standard deviation.
WITHIN_ONE_DEVIATION = 0.6827


def sizes_in_company(drawn: DrawnRecording) -> list[float | None]:
    """Size of each effect in detectable sizes, beside the others; None for one on the noise.

    None, too, where the machine breaks without the effect.

    Parameters
    ----------
    drawn : DrawnRecording
        With all of its effects.
    """
    setup = drawn.setup_with(drawn.effects)
    output = drawn.output(setup, drawn.command)
    spread = _spread(drawn, setup, drawn.noise_std(output))
    coefficients = [*_of_coefficients(drawn, setup), *_of_the_initial_state(drawn, setup, output)]
    sizes: list[float | None] = []
    for effect in drawn.effects:
        others = [other for other in drawn.effects if other is not effect]
        if effect.effect.noise_like:
            sizes.append(None)
            continue
        try:
            change = output - drawn.output(drawn.setup_with(others), drawn.command)
        except DivergedError:
            sizes.append(None)
            continue
        imitating = [*coefficients, *_of_strengths(drawn, effect, output)]
        sizes.append(multiple(_left_over(change, imitating), spread))
    return sizes


def _left_over(change: Array, imitating: list[Array]) -> float:
    """Sum of squares of what is left of a change by what imitates it."""
    lengths = [float(np.linalg.norm(column)) for column in imitating]
    columns = [column / length for column, length in zip(imitating, lengths, strict=True) if length > 0.0]
    if columns:
        table = np.stack(columns, axis=1)
        change = change - table @ np.linalg.lstsq(table, change, rcond=SMALLEST_DIRECTION)[0]
    return float(change @ change)


def _of_coefficients(drawn: DrawnRecording, setup: Setup) -> Iterator[Array]:
    """How the output changes with each coefficient of the machine."""
    for index in [i for i in COEFFICIENTS if setup.parameters[i]][1:]:
        both = []
        for factor in (1.0 + COEFFICIENT_STEP, 1.0 - COEFFICIENT_STEP):
            changed = setup.copy()
            changed.parameters[index] *= factor
            both.append(drawn.output(changed, drawn.command))
        yield both[0] - both[1]


def _of_the_initial_state(drawn: DrawnRecording, setup: Setup, output: Array) -> Iterator[Array]:
    """How it changes with what moved the machine before the recording, where its initial state is estimated."""
    for part in np.array_split(np.arange(MOVING_LEAD), EARLIER_PARTS) if setup.moving else ():
        command = drawn.command.copy()
        command[part] *= 1.0 + COEFFICIENT_STEP
        yield drawn.output(setup, command) - output


def _of_strengths(drawn: DrawnRecording, effect: Built, output: Array) -> Iterator[Array]:
    """How it changes with the strengths of the other effects; one that breaks the machine imitates nothing."""
    for other in drawn.effects:
        if other is effect or other.effect.noise_like or other.effect.fixed:
            continue
        stronger = replace(other, strength=(1.0 + STRENGTH_STEP) * other.strength)
        changed = [stronger if each is other else each for each in drawn.effects]
        try:
            yield drawn.output(drawn.setup_with(changed), drawn.command) - output
        except DivergedError:
            continue


def _spread(drawn: DrawnRecording, setup: Setup, noise: float) -> float:
    """What two thirds of the readings, with all that is random, scatter by: a few outliers hide nothing else.

    At least the standard deviation of the additive noise.
    """
    trajectory = motion(setup, drawn.command)
    sources = (np.random.default_rng(drawn.seed + shift) for shift in (0, 1))
    random = record(setup, trajectory, noise, *sources) - clean(setup, readings(setup, trajectory))
    return max(noise, float(np.quantile(np.abs(random), WITHIN_ONE_DEVIATION)))
