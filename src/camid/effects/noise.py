"""Effects that change the noise and not the expected output: recognised from the residual and the recorded values."""

from __future__ import annotations

from collections.abc import Sequence
from math import erfc, log, sqrt

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import Array, Effect
from camid.effects.outlier_share import outlier_share
from camid.effects.parameter import Parameter
from camid.effects.printed_values import digits, lattice_step
from camid.effects.recognition import Recognition
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation
from camid.effects.variance_regression import FEWEST_ROWS, scatters_from_frame_to_frame, variance_regression

# A lattice whose rounding error has less than this share of the residual's variance does not matter.
NEGLIGIBLE_ROUNDING = 0.02
# Residuals beyond this many robust standard deviations are outliers: one in 16,000 and 1.7 million of Gaussian noise.
OUTLYING = (4.0, 5.0, 7.0)
# Rows on either side of an outlier that it is compared with, and how many times farther than any other row from those
# around it one lies that is no misfit of a model.
AROUND, STANDING_OUT = 2, 2.0
# Share of the readings at either end, and of outlying rows among them whose expected values lie beyond.
EDGE, AT_AN_EDGE = 0.05, 0.7
FEWEST_REPEATED = 1
# Chance of so few repeated frames in fast motion below which it is the sensor's step that repeats them.
LEAST_CHANCE_OF_LOSS = 1e-3
# A marker that moves by less than this many standard deviations of the noise between two frames hardly moves.
STILL = 3.0
# Share of the frames that a codec repeats although the marker moves, and the likelihood of loss against such a codec
# below which it is the codec that repeats them.
REPEATED_IN_MOTION, LEAST_RATIO_OF_LOSS = 0.05, 0.1
# Residuals beyond this many robust standard deviations count as these in a regression of the variance.
MOST_DEVIATIONS = 6.0
# Rows of a stretch whose spread is looked at, such stretches at most, and the ratio of the largest spread to the least
# from which the noise is louder for a while: by chance the median of a hundred rows is off by an eighth.
FEWEST_IN_BLOCK, MOST_BLOCKS, LOUDER = 100, 20, 2.0
# Standard deviations from which a recording refutes what another one seems to show.
REFUTING = 3.0
# Probability below which another effect on the noise counts as there, before outliers or jitter are looked for.
CERTAIN_PROBABILITY = 1e-4


def noise_beside_motion(values: Array) -> float:
    """Standard deviation of what changes from frame to frame, by third differences: a smooth motion hardly has any."""
    differences = np.abs(np.diff(values, 3))
    return 1.4826 * float(np.median(differences)) / sqrt(20.0) if len(differences) else 0.0


def tail(deviation: float) -> float:
    """Probability that a standard Gaussian exceeds a deviation."""
    return 0.5 * erfc(deviation / sqrt(2.0))


def rare_count(count: int, trials: int, probability: float) -> float:
    """Bound (Chernoff) on the probability of at least ``count`` events in this many trials."""
    expected = trials * probability
    return 1.0 if count <= expected else float(np.exp(count - expected - count * log(count / expected)))


class Quantisation(Effect):
    """Values on a coarse lattice."""

    identifier = "quantisation"
    place = "sensor"
    title = "Quantisation of the measurement"
    drawn_against = "lattice"
    equation = r"w = q\,\mathrm{round}(w/q)"
    reference = "Widrow & Kollar (2008), Quantization Noise"
    parameters = (Parameter("step", "y", "step q of the lattice", 1e-300),)
    shows_in_values = True
    makes_variance_uneven = True
    noise_like = True

    def observe(self, output: Array, time: Array) -> Array:
        """Round to the lattice."""
        return np.asarray(self.values["step"] * np.round(output / self.values["step"]))

    @classmethod
    def recognise(cls, situation: Situation) -> Recognition | None:
        """All values lie on a lattice that is coarse beside the residual."""
        step = lattice_step(situation.recorded)
        if step is None or step**2 / 12.0 < NEGLIGIBLE_ROUNDING * float(
            np.mean(situation.residual[situation.used] ** 2)
        ):
            return None
        # Values without a lattice would lie on it by chance only.
        return Recognition(cls(step=step), {"step": 1e-3 * step}, 1e-12, np.zeros(len(situation.time), bool))


class DroppedFrames(Effect):
    """Frames that never came: the last one is delivered again."""

    identifier = "dropped-frames"
    place = "sensor"
    title = "Dropped frames"
    drawn_against = "repetition"
    equation = r"w_k = w_{k-1}\ \ \mathrm{for\ a\ share}\ p\ \mathrm{of\ the\ frames}"
    reference = "Laroche & Delavigne, section 2 (every frame is delivered)"
    parameters = (Parameter("fraction", "", "share p of repeated frames", 0.0, 1.0),)
    separated_by = (SeparatingExperiment.NO_INPUT,)
    shows_in_values = True
    spoils_rows = True
    noise_like = True

    @classmethod
    def recognise(cls, situation: Situation) -> Recognition | None:
        """Values are repeated exactly although noise would never repeat them."""
        values = situation.recorded
        step = lattice_step(values)
        # A residual that is structure says nothing of the noise, and would make the step of an encoder look fine.
        spread = min(float(np.std(situation.residual[situation.used])), noise_beside_motion(values))
        if step is not None and step > 0.02 * spread:
            return None
        # At the edges of a clipped range values repeat without a lost frame.
        inside = (values > np.min(values)) & (values < np.max(values))
        repeated = np.append(False, values[1:] == values[:-1]) & inside
        count = int(np.sum(repeated))
        if count < FEWEST_REPEATED or _repeats_where_slow(values, repeated) or _repeats_where_still(values, repeated):
            return None
        share = count / len(values)
        fineness = digits(values) if step is None else np.full(len(values), step)
        chance = float(np.mean(fineness / np.maximum(spread, fineness)))
        return Recognition(
            cls(fraction=share),
            {"fraction": sqrt(share * (1.0 - share) / len(values))},
            rare_count(count, len(values), chance),
            repeated,
        )


def _repeats_where_slow(values: Array, repeated: NDArray[np.bool_]) -> bool:
    """Whether values repeat because the motion takes several frames for a step of the sensor.

    A lost frame does not care how fast the motion is, so that half of them fall among the faster half of the rows.
    """
    speed = np.abs(values[3:] - values[:-3])
    inner = repeated[2:-1]
    fast, count = int(np.sum(inner & (speed > np.median(speed)))), int(np.sum(inner))
    return count > 0 and tail((0.5 * count - fast) / (0.5 * sqrt(count))) < LEAST_CHANCE_OF_LOSS


def _repeats_where_still(values: Array, repeated: NDArray[np.bool_]) -> bool:
    """Whether values repeat because the pictures do: a codec sends nothing new of a marker that hardly moves.

    What a frame would have shown is interpolated between two before and two after it. A lost frame does not care
    whether the marker moves, so that as many of them are still as of all rows; the frames that a codec repeats are
    nearly all still. Where all rows are, nothing tells them apart, and no codec is blamed.
    """
    if len(values) < FEWEST_ROWS:
        return False
    way = np.abs(4.0 * values[3:-1] - 2.0 * values[1:-3] - values[:-4] - values[4:]) / 6.0
    moves = way > STILL * noise_beside_motion(values) * sqrt(22.0) / 6.0  # 22 = 4² + 2² + 1² + 1²
    # As if one more frame moved and one more did not.
    share = (np.count_nonzero(moves) + 1.0) / (len(moves) + 2.0)
    inner = repeated[2:-2]
    moving, still = int(np.sum(inner & moves)), int(np.sum(inner & ~moves))
    ratio = moving * log(share / REPEATED_IN_MOTION) + still * log((1.0 - share) / (1.0 - REPEATED_IN_MOTION))
    return bool(share > REPEATED_IN_MOTION and ratio < log(LEAST_RATIO_OF_LOSS))


def repeated_rows(situation: Situation) -> NDArray[np.bool_]:
    """Rows that repeat the last frame, where that is recognised."""
    found = DroppedFrames.recognise(situation)
    return (
        found.spoiled
        if found is not None and found.p_value < CERTAIN_PROBABILITY
        else np.zeros(len(situation.time), bool)
    )


def _relative_spread(residual: Array, motion: Sequence[Array]) -> Array:
    """Relative standard deviation of each row: one, or that of a noise that grows with the motion where it does.

    Of several measures of the motion the one that the noise follows best.
    """
    # Single outliers would bend the regression, so that the largest residuals count as less.
    limit = MOST_DEVIATIONS * 1.4826 * float(np.median(np.abs(residual)))
    square = np.clip(residual, -limit, limit) ** 2
    regressions = [variance_regression(square, signal**2) for signal in motion]
    (_, slope, _, score), signal = max(zip(regressions, motion, strict=True), key=lambda each: each[0][0])
    if 2.0 * tail(score) >= CERTAIN_PROBABILITY or slope <= 0.0:
        return np.ones(len(residual))
    size = signal**2
    base = max(float(np.mean(square) - slope * np.mean(size)), 0.05 * float(np.mean(square)))
    return np.asarray(np.sqrt((base + slope * size) / (base + slope * float(np.median(size)))))


def _spread_over_time(residual: Array) -> Array:
    """Relative robust spread of each row: one, or that of a noise that is louder for a while where it is."""
    blocks = np.array_split(np.arange(len(residual)), max(min(len(residual) // FEWEST_IN_BLOCK, MOST_BLOCKS), 1))
    spreads = np.array([np.median(np.abs(residual[rows])) for rows in blocks])
    if np.min(spreads) <= 0.0 or np.max(spreads) < LOUDER * np.min(spreads):
        return np.ones(len(residual))
    centres = [float(np.mean(rows)) for rows in blocks]
    return np.asarray(np.interp(np.arange(len(residual)), centres, spreads) / np.median(spreads))


def _at_an_edge(situation: Situation, rows: NDArray[np.bool_]) -> int:
    """How many rows are read at an end of what is ever read, and expected beyond: a clipping, no outlier."""
    low, high = np.quantile(situation.recorded[situation.used], [EDGE, 1.0 - EDGE])
    above = (situation.recorded >= high) & (situation.residual < 0.0)
    below = (situation.recorded <= low) & (situation.residual > 0.0)
    return int(np.count_nonzero(rows & (above | below)))


class Outliers(Effect):
    """Single frames in which something else than the marker was found."""

    identifier = "outliers"
    place = "sensor"
    title = "Outliers"
    drawn_against = "histogram"
    equation = r"w_k = w + o_k\ \ \mathrm{for\ a\ share}\ p\ \mathrm{of\ the\ frames}"
    reference = "Huber & Ronchetti (2009), Robust Statistics, 2nd ed."
    parameters = (Parameter("fraction", "", "share p of the frames", 0.0, 1.0),)
    separated_by = (SeparatingExperiment.NO_INPUT,)
    spoils_rows = True
    makes_variance_uneven = True
    judged_by_even_spread = True
    noise_like = True

    @classmethod
    def recognise(cls, situation: Situation) -> Recognition | None:
        """Isolated residuals far outside of the robust spread of the others."""
        # Neither a repeated frame nor the wide noise of a jittering clock at high speed, or of a sensor whose noise
        # grows with its reading, is an outlier.
        usable = situation.used & ~repeated_rows(situation)
        known = situation.residual[usable]
        if len(known) < FEWEST_ROWS:
            return None
        residual = np.where(usable, situation.residual - np.median(known), 0.0)
        motion = (situation.velocity[usable], situation.position[usable])
        residual[usable] /= _relative_spread(residual[usable], motion)
        residual[usable] /= _spread_over_time(residual[usable])
        spread = 1.4826 * float(np.median(np.abs(residual[usable])))
        if spread <= 0.0:
            return None
        total = len(known)
        rarest = 1.0
        far: NDArray[np.bool_] = np.zeros(len(residual), bool)
        for threshold in OUTLYING:  # a few far ones, or many that are not so far
            beyond = np.abs(residual) > threshold * spread
            chance = rare_count(int(np.sum(beyond)), total, 2.0 * tail(0.97 * threshold)) * len(OUTLYING)
            if np.any(beyond) and chance < rarest:
                rarest, far = chance, beyond
        count = int(np.sum(far))
        if count == 0:
            return None
        neighbours = np.zeros(len(far), bool)
        neighbours[1:] |= far[:-1]
        neighbours[:-1] |= far[1:]
        if np.sum(far & ~neighbours) < 0.7 * count or count > 0.2 * len(far):
            return None
        if _at_an_edge(situation, far) >= AT_AN_EDGE * count:
            return None
        share = outlier_share(residual[usable], far[usable], spread)
        found = cls(fraction=share.fraction)
        # What lies far off in noise with heavy tails bends a fit as much, and has no other cause than the noise.
        stands_out = _stands_out(residual, far, usable)
        return Recognition(found, {"fraction": share.deviation}, min(rarest, 1.0), far, share.evidence, stands_out)

    @classmethod
    def limit_of_recognition(cls, situation: Situation) -> str:
        """Noise with heavy tails shows as much."""
        return "it shows in the noise only, and the noise does not show it, or does as much by its heavy tails"


def _stands_out(residual: Array, far: NDArray[np.bool_], usable: NDArray[np.bool_]) -> bool:
    """Whether single rows differ from those around them by far more than any other row does, whatever the others are.

    What the laws of a model leave lasts for several frames, or comes in all sizes.
    """
    around = np.lib.stride_tricks.sliding_window_view(np.pad(residual, AROUND, mode="edge"), 2 * AROUND + 1)
    alone = np.abs(residual - np.median(around, axis=-1))
    return bool(np.min(alone[far]) > STANDING_OUT * np.max(alone[usable & ~far], initial=0.0))


def grows_less(situation: Situation, measure: Array, size: float) -> bool:
    """Whether the residual's spread grows less with a measure of each row, shape (N,), than by ``size`` for a unit."""
    usable = situation.used & ~repeated_rows(situation)
    if np.sum(usable) < FEWEST_ROWS:
        return False
    _, slope, deviation, _ = variance_regression(situation.residual[usable] ** 2, measure[usable] ** 2)
    return slope + REFUTING * deviation < size**2


class TimestampJitter(Effect):
    """Frames are exposed a little earlier or later than their time stamps say."""

    identifier = "timestamp-jitter"
    place = "sensor"
    title = "Jitter of the time stamps"
    drawn_against = "spread over the rate"
    equation = r"w_k = w(t_k + \delta_k),\quad \delta_k \sim \mathcal{N}(0, \sigma_t^2)"
    reference = "Souders et al. (1990), IEEE Trans. Instrum. Meas. 39, 80-85"
    parameters = (Parameter("std", "s", "standard deviation σ_t of the times", 0.0),)
    makes_variance_uneven = True
    noise_like = True

    @classmethod
    def recognise(cls, situation: Situation) -> Recognition | None:
        """The residual's variance grows with the square of the speed, and not rather with that of the position."""
        usable = situation.used & ~repeated_rows(situation)
        if np.sum(usable) < FEWEST_ROWS:
            return None
        square = situation.residual[usable] ** 2
        speed, position = situation.velocity[usable] ** 2, situation.position[usable] ** 2
        gain, jitter, deviation, score = variance_regression(square, speed)
        other = variance_regression(square, position)
        if jitter <= 0.0 or other[0] > gain or not scatters_from_frame_to_frame(situation, usable):
            return None
        timing = sqrt(jitter)
        spoiled = np.zeros(len(situation.time), bool)
        return Recognition(cls(std=timing), {"std": 0.5 * deviation / timing}, 2.0 * tail(score), spoiled)

    def is_refuted(self, situation: Situation) -> bool:
        """Whether the residual's variance grows less with the speed than these times would make it."""
        return grows_less(situation, situation.velocity, self.values["std"])

    def added_variance(self, situation: Situation) -> Array:
        """What passes in the time by which a frame is early or late, squared; in second order, where motion turns."""
        bend = self.bend_of_mean(situation)
        return np.asarray((self.values["std"] * situation.velocity) ** 2 + 2.0 * bend**2)

    def bend_of_mean(self, situation: Situation) -> Array:
        """What the times do to the mean of what is read: σ²/2 times its second derivative."""
        second = np.gradient(np.gradient(situation.position)) / situation.acquisition.period**2
        return np.asarray(0.5 * self.values["std"] ** 2 * second)


class ColouredNoise(Effect):
    """Noise whose samples depend on each other: vibration of the camera, drift of the light, a filter."""

    identifier = "coloured-noise"
    place = "noise"
    title = "Coloured noise"
    drawn_against = "past"
    equation = r"n_k = \sum_i \alpha_i\,n_{k-i} + \varepsilon_k"
    reference = "Ljung (1999), System Identification, 2nd ed., section 4.2"
    parameters = (
        Parameter("spectrum", "", "coefficients α_i of the autoregression with the noise's spectrum", sequence=True),
    )
    colours_noise = True
    noise_like = True

    @classmethod
    def recognise(cls, situation: Situation) -> Recognition | None:
        """The diagnosis tests every residual for whiteness, with regard to what was fitted, and asks nothing here."""
        return None

    @classmethod
    def of_autoregression(cls, coefficients: Array) -> ColouredNoise:
        """The noise with this autoregression."""
        return cls(spectrum=coefficients.tolist())
