"""Tanks and other storages of the plant: an outflow that follows the square root of the level, and an overflow.

A plant of one pole is one storage; one of two real poles and no zero is a storage whose outflow fills a second one.
With the static gain 1/k, the rates a (upper) and b (lower), and an excess flow e that leaves the upper storage and of
which the share s reaches the lower one, in units of the output,

    ẋ/a = (u − e)/k − x,    ẏ/b = x + s e/k − y.

Only y is measured, but S = y + ẏ/b = x + s e/k is known from its motion, so that what leaves the upper storage is a
force at the plant's input that depends on y, ẏ and u. With a steep edge, e = κ k q(x − h), where q(z) sets in with z²
and is soon z, the level x follows from S, and

    f = u − k S − (1 + s κ q'(x − h)) (u − e − k x)    where S > h.

Where both empty with the square root of their level, too, x and y on the right become g(x) = x + c √x/k and g(y). Then
H = g(y) + ẏ/b = g(x) + s e/k is known, and the force of outflow and edge together is

    f = u − k y − k (1/a + 1/b) ẏ + (k/a) g'(y) ẏ − (g'(x) + s κ q'(x − h)) (u − e − k g(x)).
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf, sqrt
from typing import Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect, LimitedState
from camid.effects.compiled_part import compiled
from camid.effects.flows_of_storages import NEWTON_STEPS, beyond_edge, level_of, outflow, spilt, time_constants
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, AgainstMotion, mobility, motion_sign, static_stiffness
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# A single storage that is full fills this many times slower than without its edge.
TIGHTNESS = 1e3
# A step that crosses the edge leads beyond it; that flows off with this many times the rate of the storage.
RETURN = 8.0
# Share of its height by which a single storage may lack of being full and count as it: a step is split where the level
# reaches the edge, give or take what a cubic leaves, and a part that began below it would lead beyond.
REACHED = 1e-4
# The flow over the edge of the upper of two storages grows by this many times its outflow for a unit of the level.
STEEPNESS = 30.0
# Width of its edge, as a share of its height, over which that flow sets in: were it sharp, the force of what passes on
# to the lower storage would jump, and a fit would see jumps where it varies the height.
EDGE_WIDTH = 0.03
# Of the rate of a storage at its edge, the share that counts for the length of a step: explicit steps stay stable.
STEP_SHARE = 0.125
# Rate of a single storage at its edge, in its own ones, by which steps lose no more than an edge of REACHED.
RATE_OF_SINGLE = 16.0
# Speed of the outflow near the empty storage, in rates of the storage, above which it is in proportion to the level:
# a trickle is not turbulent. A single storage may lose nothing in proportion: then so many in a sampling period.
FASTEST_TRICKLE, TRICKLE_IN_A_PERIOD = 30.0, 2.0
# An edge this much beyond the motion, in the largest displacement, does nothing.
BEYOND = 1.001
# Share of the largest displacement of a model without an edge below which what was recorded ends at one.
FAR_BELOW = 0.7
# Constant of a plant that is the reading at its zero, and the least share of the root, and of what is in proportion, in
# the slope of an outflow.
ZERO, LEAST_ROOT = "offset", 0.05
# Share of the readings that noise may put below an empty storage.
NOISY_ROWS = 0.02
# A level, in any unit, whose square is still a number.
NO_LEVEL = 1e-150
NO_STORAGE = (
    "only a storage flows out or over: a plant of one pole, or of two real ones, without zeros; this plant is not one"
)


class _Storage(Effect):
    """An effect of a storage."""

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Other plants have no storage."""
        return None if time_constants(situation.plant) else NO_STORAGE


class SquareRootOutflow(_Storage, AgainstMotion):
    """An outflow with the square root of the level (Torricelli), beside the part that is in proportion to it.

    Of the storage whose level is measured, or, where ``below`` names it, of that and of the one above it.
    """

    identifier = "square-root-outflow"
    place = "plant"
    title = "Outflow with the square root of the level"
    equation = r"f = c\,\mathrm{sgn}(y)\,\sqrt{|y|}"
    reference = "Johansson (2000), IEEE Trans. Control Syst. Technol. 8, 456-465 (tanks; Torricelli's law)"
    parameters = (
        Parameter("coefficient", "u/y^0.5", "outflow c at the level one", 0.0),
        Parameter(
            "below",
            "",
            "storage below another with it: none, the faster or the slower",
            choices=("none", "fast", "slow"),
            default="none",
        ),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    strength = "coefficient"
    _period: float | None = None

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        # The level of the upper of two storages follows from the speed of the lower one's.
        self.uses_velocity = self.values["below"] != "none"

    def beside(self, others: Sequence[Effect], period: float) -> SquareRootOutflow:
        """In a chain with a sampling period."""
        found = type(self)(**self.values)
        found._period = period
        return found

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        flow, slope = outflow(position, values[1], values[2])
        if values[0] == 0.0:
            return values[3] * (flow - position)
        stiffness, lower, upper = values[3], values[4], values[5]
        known = flow + lower * velocity
        side = 1.0 if known >= 0.0 else -1.0
        above, steep = outflow(side * level_of(side * known, values[1], values[2]), values[1], values[2])
        linear = position + (lower + upper) * velocity
        return signal - stiffness * (linear - upper * slope * velocity) - steep * (signal - stiffness * above)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Whether another storage lies above, excess, trickle, stiffness, time constants below and above.

        Of a single storage the outflow of a level of one takes the place of the excess, and the sign of the gain that
        of the stiffness.
        """
        stiffness, constants = static_stiffness(plant), time_constants(plant)
        if self.values["below"] == "none" or len(constants) < 2:
            return [0.0, self.values["coefficient"], self._trickle(plant), motion_sign(plant), 0.0, 0.0]
        excess, trickle = self.shape(plant)
        lower, upper = constants if self.values["below"] == "fast" else constants[::-1]
        return [1.0, excess, trickle, stiffness, lower, upper]

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """A tank that nothing leaves in proportion to its level may have an outflow, too."""
        monic = situation.plant.monic
        fills = monic.order == 1 and len(monic.numerator) == 1 and monic.denominator[-1] == 0.0
        return None if fills else super().invisible(situation)

    def _trickle(self, plant: TransferFunction) -> float:
        """Level of a trickle of a single storage."""
        own = FASTEST_TRICKLE * plant.fastest_pole
        fastest = own if self._period is None else own + TRICKLE_IN_A_PERIOD / self._period
        if fastest == 0.0:
            return NO_LEVEL
        return (abs(plant.monic.numerator[0]) * self.values["coefficient"] / fastest) ** 2 + NO_LEVEL

    def shape(self, plant: TransferFunction) -> tuple[float, float]:
        """Outflow with the root of a level of one over that in proportion, and the level of a trickle."""
        stiffness = abs(static_stiffness(plant))
        excess = self.values["coefficient"] / stiffness if stiffness > 0.0 else 0.0
        return excess, (excess / FASTEST_TRICKLE) ** 2 + NO_LEVEL

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return position

    def frequency(self, plant: TransferFunction) -> float:
        """Of a trickle."""
        constants = time_constants(plant)
        return STEP_SHARE * FASTEST_TRICKLE / constants[0] if constants else 0.0

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        count = len(time_constants(situation.plant))
        for below in ("fast", "slow") if count == 2 else ("none",):
            for share in (GUESS, 0.3):
                coefficient = share * situation.largest("signal") / sqrt(situation.largest("position"))
                yield cls(coefficient=coefficient, below=below)

    @classmethod
    def with_plant(
        cls, situation: Situation, constants: Mapping[str, float]
    ) -> tuple[Effect, TransferFunction, dict[str, float]] | None:
        """Of a single storage, the law that has the estimated plant for its tangent at the mean level.

        A storage is empty where its sensor reads zero. Where that was estimated, the zero of the tangent says which
        share of the outflow's slope is the root's, and else that is a half.
        """
        rates = [1.0 / constant for constant in time_constants(situation.plant)]
        reading = situation.recorded[situation.used] + constants.get(ZERO, 0.0)
        level = float(np.mean(reading))
        if len(rates) != 1 or np.quantile(reading, NOISY_ROWS) < 0.0 or level <= 0.0:
            return None
        gain, rate = situation.plant.monic.numerator[0], rates[0]
        if ZERO in constants:
            share = min(max(-constants[ZERO] / level, LEAST_ROOT), 1.0 - LEAST_ROOT)
        else:
            share = 0.5
            rate = gain * float(np.mean(situation.signal[situation.used])) / ((1.0 + share) * level)
        if rate <= 0.0:
            return None
        plant = TransferFunction((gain,), (1.0, (1.0 - share) * rate))
        effect = cls(coefficient=2.0 * sqrt(level) * share * rate / abs(gain), below="none")
        return effect, plant, dict.fromkeys(constants.keys() & {ZERO}, 0.0)


class Overflow(_Storage):
    """A storage that is full: its level exceeds its edge no more, and the excess is lost, or a share of it is."""

    identifier = "overflow"
    place = "plant"
    title = "Overflow (limited level)"
    equation = r"x \leq h:\quad \dot x/a = (u - e)/k - x,\quad e > 0\ \mathrm{only\ at}\ x = h"
    reference = "Schoukens & Noël (2017), IFAC-PapersOnLine 50, 446-451 (cascaded tanks)"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("height", "y", "level h of the edge: the output at rest with the storage just full"),
        Parameter("share", "", "share of the excess that reaches the storage below", 0.0, 1.0),
        Parameter(
            "below",
            "",
            "storage below the full one: none, the faster or the slower",
            choices=("none", "fast", "slow"),
            default="none",
        ),
        Parameter(
            "state",
            "",
            "state of the plant's equations that runs over, in whose unit the height is; none of a linear plant",
            is_name=True,
            default="",
        ),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS, SeparatingExperiment.SCALE_IN_THE_IMAGE)

    # At the edge of a single storage the force follows from the speed that it leaves.
    uses_velocity = True
    _outflow: SquareRootOutflow | None = None

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        # What leaves the upper of two storages sets in over the width of its edge.
        self.jumps = self.values.get("below") == "none"
        if self.values.get("state"):
            # The engine limits the state itself: nothing of a force that would stand for it is left.
            for part in ("force", "switch"):
                setattr(self, part, None)
            self.uses_velocity = self.jumps = False

    def limited_state(self) -> LimitedState | None:
        """The state that runs over."""
        name = str(self.values.get("state", ""))
        return LimitedState(name, self.values["height"], self.values["share"]) if name else None

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = values[0]
        excess = side * (position + values[1] * velocity - values[2])
        if values[6] != 0.0:
            if excess < -REACHED * abs(values[2]):
                return 0.0
            return values[6] * side * max(side * velocity + values[7] * excess, 0.0)
        if excess < 0.0 and values[8] == 0.0:
            return 0.0
        driven, height, stiffness, passed, width = side * signal, side * values[2], values[3], values[4], values[5]
        if values[8] == 0.0:
            beyond = beyond_edge(excess, passed, width)
            over, opening = spilt(beyond, width)
            # What the upper storage keeps from the lower one, less what comes over its edge.
            free = driven - stiffness * (beyond + height)
            left = free - STEEPNESS * stiffness * over
            return side * (free + stiffness * (beyond - excess) - (1.0 + passed * opening) * left)
        full, slope = outflow(height, values[8], values[9])
        flow = side * (outflow(position, values[8], values[9])[0] + values[1] * velocity)
        if flow <= full:
            return 0.0
        beyond = beyond_edge((flow - full) / slope, passed / slope, width)
        for _ in range(NEWTON_STEPS):
            given, slope = outflow(height + beyond, values[8], values[9])
            over, opening = spilt(beyond, width)
            beyond += (flow - given - passed * over) / (slope + passed * opening)
        given, slope = outflow(height + beyond, values[8], values[9])
        over, opening = spilt(beyond, width)
        without = outflow(level_of(flow, values[8], values[9]), values[8], values[9])[1]
        left = driven - STEEPNESS * stiffness * over - stiffness * given
        return side * (without * (driven - stiffness * flow) - (slope + passed * opening) * left)

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return position + values[1] * velocity - values[2]

    def beside(self, others: Sequence[Effect], period: float) -> Overflow:
        """Beside an outflow of both storages with the square root of their level, which says how high the upper is."""
        same = [e for e in others if isinstance(e, SquareRootOutflow) and e.values["below"] == self.values["below"]]
        if not same or self.values["below"] == "none":
            return self
        found = Overflow(**self.values)
        found._outflow = same[0]
        return found

    def _below(self, plant: TransferFunction) -> float:
        """Time constant in s of the storage below."""
        constants = time_constants(plant) or [0.0]
        choice = self.values["below"]
        return 0.0 if choice == "none" or plant.order < 2 else constants[0 if choice == "fast" else -1]

    def force_values(self, plant: TransferFunction) -> list[float]:
        """What the compiled parts need.

        Side, time constant below, where the edge starts, stiffness, flow that passes on for a unit of the level beyond
        the edge, width of the edge; of a single storage force for a unit of the speed beyond the edge, and rate of the
        return to it; of two that empty with the square root of their level excess and trickle.
        """
        height, stiffness, below = self.values["height"], static_stiffness(plant), self._below(plant)
        side = 1.0 if height >= 0.0 else -1.0
        if plant.order == 1:
            return [side, 0.0, height, 0.0, 0.0, 0.0, TIGHTNESS / plant.monic.numerator[0], self._return(plant)]
        passed = STEEPNESS * self.values["share"] if below > 0.0 else 0.0
        start = (1.0 - 0.5 * EDGE_WIDTH) * height
        values = [side, below, start, stiffness, passed, EDGE_WIDTH * abs(height) + NO_LEVEL, 0.0, 0.0]
        return values if self._outflow is None or below == 0.0 else [*values, *self._outflow.shape(plant)]

    def _return(self, plant: TransferFunction) -> float:
        """Rate in 1/s with which what a step has led beyond the edge flows off."""
        return RETURN * plant.fastest_pole

    def frequency(self, plant: TransferFunction) -> float:
        """Of a full storage above another one."""
        constants = time_constants(plant)
        if self.values["state"]:
            return STEP_SHARE * STEEPNESS / constants[0] if constants else 0.0
        if plant.order == 1:
            return STEP_SHARE * RATE_OF_SINGLE * abs(float(plant.monic.denominator[1]))
        if not constants:
            return sqrt(mobility(plant) * STEEPNESS * abs(static_stiffness(plant)))
        return STEP_SHARE * STEEPNESS / (constants[0] if self.values["below"] != "fast" else constants[-1])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several heights on both sides, of the storage itself or of the upper one of two.

        A model without an edge may go far beyond all that was recorded.
        """
        if situation.rest is not None:
            yield from cls._of_states(situation)
            return
        count = len(time_constants(situation.plant))
        belows = ("fast", "slow") if count == 2 else ("none",) * count
        recorded = situation.recorded[situation.used]
        for extreme in (np.max, np.min):
            edge, seen = float(extreme(situation.position)), float(extreme(recorded, initial=0.0))
            ends: list[tuple[float, tuple[float, ...]]] = [(edge, (0.9, 0.7, 0.4))]
            if abs(seen) < FAR_BELOW * abs(edge):
                ends.append((seen, (0.95, 0.8)))
            for end, share in [(end, share) for end, shares in ends for share in shares if end != 0.0]:
                for below in belows:
                    yield cls(height=share * end, share=0.0, below=below).measured_from(BEYOND * end, 0.0)

    @classmethod
    def _of_states(cls, situation: Situation) -> Iterator[Effect]:
        """Several heights of each state of the plant's equations, where it rests at a part of the largest output.

        A model without an edge goes far beyond what was recorded.
        """
        assert situation.rest is not None
        highest = float(np.max(situation.position))
        full = situation.rest(highest) or {}
        recorded = float(np.max(situation.recorded[situation.used], initial=-inf))
        for share in (0.9, 0.7, 0.4):
            levels = situation.rest(share * min(highest, recorded)) or {}
            for name, level in levels.items():
                if level > 0.0 and full.get(name, 0.0) > 0.0:
                    yield cls(height=level, share=0.0, state=name).measured_from(BEYOND * full[name], 0.0)
