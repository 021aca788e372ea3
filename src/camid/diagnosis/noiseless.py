"""Recordings without noise, such as those that another simulation has written.

To an exact recording the last digits of two integrators are evidence, and whatever follows them would be physics that
is left out. Readings are no more accurate than what simulates them: where a model leaves less than that, noise of this
size is added to them, and the diagnosis begins again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camid.engine.work import Work
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem
from camid.number_text import percentage

# Accuracy of a simulation, as a share of the output's standard deviation. With dry friction, stops and actuators that
# bend the command within a frame another integrator differs by at most a fifth of it; where several of these act at
# once it may differ by more, and that is left.
ACCURACY = 1e-5
# A model that fits leaves about all of such noise; one that leaves less than this share of it was given none.
WELL_BELOW = 0.5
# The generator of that noise is seeded by this alone: a diagnosis is the same whenever it is made.
SEED = 20_261_129


class NoNoise(Exception):  # noqa: N818 - what a recording is, and no error
    """A model leaves less of a recording than a simulation is accurate to."""


def ask_for_noise(problem: Problem, fitted: Fitted) -> None:
    """Ask for noise where a model leaves none.

    Raises
    ------
    NoNoise
        If what it leaves of the fitted rows is well below the accuracy of simulations.
    """
    if fitted.cost < (WELL_BELOW * ACCURACY * problem.output_spread) ** 2 * len(fitted.residual):
        raise NoNoise


def with_least_noise(problem: Problem) -> Problem:
    """The same recordings with white noise as large as simulations are accurate to, and nothing simulated yet."""
    random = np.random.default_rng(SEED)
    size = ACCURACY * problem.output_spread
    added = [size * random.standard_normal(len(e.output)) for e in problem.experiments]
    experiments = [replace(e, output=e.output + a) for e, a in zip(problem.experiments, added, strict=True)]
    return replace(problem, experiments=experiments, work=Work())


def said_of_noise() -> str:
    """What a diagnosis says of the noise that was added."""
    return (
        f"the recording holds no noise down to {percentage(ACCURACY, 1)} of its standard deviation, which is what "
        "simulations are accurate to: noise of that size is added to it, and the numbers are as uncertain as that"
    )
