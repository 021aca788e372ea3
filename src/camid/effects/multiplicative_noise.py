"""Noise that grows with what is read: of a range finder, a flow meter, a gain that flickers."""

from __future__ import annotations

from dataclasses import replace
from math import log, sqrt

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.noise import grows_less, repeated_rows, tail
from camid.effects.parameter import Parameter
from camid.effects.recognition import Recognition
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation
from camid.effects.variance_regression import FEWEST_ROWS, scatters_from_frame_to_frame, variance_regression

# Probability below which chance alone does not make the variance grow so with the reading.
UNEVEN = 1e-8


class MultiplicativeNoise(Effect):
    """Noise in proportion to the reading, beside noise that is the same everywhere."""

    identifier = "multiplicative-noise"
    place = "noise"
    title = "Noise in proportion to the reading"
    drawn_against = "spread over the reading"
    equation = r"w_k = w\,(1 + \varepsilon_k),\quad \varepsilon_k \sim \mathcal{N}(0, s^2)"
    reference = "Carroll & Ruppert (1988), Transformation and Weighting in Regression, chapter 2"
    parameters = (Parameter("share", "", "standard deviation s of the noise over the reading", 0.0),)
    separated_by = (SeparatingExperiment.NO_INPUT,)
    makes_variance_uneven = True
    noise_like = True

    @classmethod
    def recognise(cls, situation: Situation) -> Recognition | None:
        """The residual's variance grows with the square of the reading, and not rather with that of the speed."""
        usable = situation.used & ~repeated_rows(situation)
        # In images noise that changes with the position is common, and has no other cause than they; in a loop what a
        # controller put out is compared, and no reading.
        no_reading = situation.controlled or situation.acquisition.sensor == "camera"
        if no_reading or np.sum(usable) < FEWEST_ROWS:
            return None
        square = situation.residual[usable] ** 2
        reading, speed = situation.position[usable] ** 2, situation.velocity[usable] ** 2
        gain, slope, deviation, score = variance_regression(square, reading)
        other = variance_regression(square, speed)
        over_reading = replace(situation, velocity=situation.position)
        if slope <= 0.0 or other[0] > gain or not scatters_from_frame_to_frame(over_reading, usable):
            return None
        p_value = 2.0 * tail(score)
        if p_value >= UNEVEN:
            return None
        share = sqrt(slope)
        spoiled = np.zeros(len(situation.time), bool)
        # One number more, of which as much was known beforehand as a row says (Kass & Wasserman 1995).
        evidence = gain - 0.5 * log(len(square))
        return Recognition(cls(share=share), {"share": 0.5 * deviation / share}, p_value, spoiled, evidence)

    def is_refuted(self, situation: Situation) -> bool:
        """Whether the residual's variance grows less with the reading than this noise would make it."""
        return grows_less(situation, situation.position, self.values["share"])

    def added_variance(self, situation: Situation) -> Array:
        """In proportion to the square of the reading."""
        return np.asarray((self.values["share"] * situation.position) ** 2)
