"""Derivatives of what a sensor reads by the values of a learned law, without a simulation for each of them.

A force over position or velocity, or a curve of the actuator, takes one run with tangents
(:mod:`camid.engine.tangent`), and a curve of the sensor one run, whose reading it bends.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.motion import Motion
from camid.effects.learned import LearnedCurve, LearnedEffect, LearnedForce
from camid.engine.law_stages import Law
from camid.engine.mechanics import Chain
from camid.engine.reader import Reader
from camid.engine.run import (
    OF_THE_MOTION,
    Setting,
    after_sensor,
    exactly,
    exposures,
    move,
    observed,
    overrides,
    prepared,
    read,
)
from camid.engine.tangent import Changes, Driven, law_tangents

Array = NDArray[np.float64]

# Numbers of one kind that a run with tangents leaves at most; more columns take another run.
MOST_NUMBERS = 2_000_000
# Changes of the law beside those that differences of whole runs take: over a single step rounding hardly shows.
FINER = 1e-2
# Product of two rows, as a share of its parts, that is no more than their rounding.
ROUNDING = 1e-12
# Columns that compiled loops take at a time; columns of zeros fill up the last ones.
LANES = 16


def by_law(chain: Chain, signal: Array, time: Array, index: int, ways: Array, size: float) -> Array | None:
    """Derivatives of the sensor's samples by a law's heights, or None where only whole simulations tell them.

    Parameters
    ----------
    chain : Chain
        With steps of the integrator that are given.
    signal, time : ndarray, shape (N,)
        As for :func:`camid.engine.run.run`.
    index : int
        Which effect is the law.
    ways : ndarray, shape (k, c)
        Each column is a direction in which the heights at the knots change.
    size : float
        Step of the differences by heights.

    Returns
    -------
    ndarray, shape (N, c), or None
    """
    law = chain.effects[index]
    assert isinstance(law, LearnedEffect)
    if chain.loop is not None or chain.pull is not None or not chain.steps:
        return None
    if isinstance(law, LearnedCurve) and not law.of_input:
        return _by_reading(chain, law, signal, time, index, ways, size)
    assert isinstance(law, LearnedForce | LearnedCurve)
    return _by_motion(chain, law, signal, time, index, ways, size)


def _by_reading(
    chain: Chain, law: LearnedCurve, signal: Array, time: Array, index: int, ways: Array, size: float
) -> Array:
    """A curve of the sensor changes nothing of the motion."""
    acquisition = chain.declared()
    output = exactly(chain, signal, acquisition)
    if output is None:
        output = read(chain, move(chain, signal, time, acquisition), time, acquisition)

    def sampled(heights: Array) -> Array:
        effects = (*chain.effects[:index], law.with_heights(heights), *chain.effects[index + 1 :])
        return after_sensor(replace(chain, effects=effects), output, time, signal)

    here = sampled(law.heights)
    return np.column_stack([(sampled(law.heights + size * way) - here) / size for way in ways.T])


def _by_motion(
    chain: Chain, law: LearnedForce | LearnedCurve, signal: Array, time: Array, index: int, ways: Array, size: float
) -> Array | None:
    """A force, or a curve of the actuator."""
    acquisition, curve = chain.declared(), isinstance(law, LearnedCurve)
    # A simulation of a linear chain is cheap.
    if chain.equations is not None or (curve and exactly(chain, signal, acquisition) is not None):
        return None
    setting = prepared(chain, signal, time, acquisition)
    mechanics = setting.mechanics
    at_once = _meets(mechanics.measured, mechanics.force_vector)
    if mechanics.forces.implicit or at_once or (curve and _meets(mechanics.measured, mechanics.input_vector)):
        return None
    steps = int(chain.steps or 0)
    step = acquisition.period / steps
    start, end = (each.copy() for each in setting.input_on_grid(chain, signal, acquisition, steps))
    reader = None
    if not any(overrides(e, *OF_THE_MOTION) for e in chain.effects):
        reader = Reader.of(setting.start_time, step, len(start) + 1, *exposures(time, acquisition))
    rows = np.arange(len(start) + 1) if reader is None else reader.rows
    bends = reader is None or any(overrides(e, "observe") for e in chain.effects)
    motion = move(chain, signal, time, acquisition) if bends else None
    columns = []
    nodes = len(start) + 1 if curve else int(np.max(rows)) + 1
    together = max(MOST_NUMBERS // nodes // LANES, 1) * LANES
    for first in range(0, ways.shape[1], together):
        some = ways[:, first : first + together]
        some = np.hstack([some, np.zeros((len(some), -some.shape[1] % LANES))])
        if isinstance(law, LearnedCurve):
            changed, driven = _no_law(some.shape[1]), _driven(chain, law, index, setting, signal, some, size)
        else:
            changed = _law_of(chain, law, index, some, FINER * size)
            driven = Driven(*np.zeros((2, 0, some.shape[1])))
        if chain.work is not None:
            chain.work.add_tangents(len(start), some.shape[1])
        changes = law_tangents(
            mechanics, setting.initial, start, end, setting.start_time, step, *setting.shocks, changed, driven, rows
        )
        if reader is None:
            assert motion is not None
            columns.append(_of_windows(chain, motion, changes, time, signal, size))
        elif motion is None:
            columns.append(chain.weight * reader.mean(changes))
        else:
            reading = read(chain, motion, time, acquisition)
            columns.append(_of_reading(chain, reading, reader.mean(changes), time, signal, size))
    return np.hstack(columns)[:, : ways.shape[1]]


def _meets(row: Array, vector: Array) -> bool:
    """Whether a product is more than the rounding of its sum."""
    return bool(abs(row @ vector) > ROUNDING * (np.abs(row) @ np.abs(vector)))


def _driven(
    chain: Chain, law: LearnedCurve, index: int, setting: Setting, signal: Array, ways: Array, size: float
) -> Driven:
    """Derivatives of the input on the grid by a curve of the actuator, and by what other actuators make of it."""
    acquisition, steps = chain.declared(), int(chain.steps or 0)
    here = setting.input_on_grid(chain, signal, acquisition, steps)
    found = Driven(*np.zeros((2, len(here[0]), ways.shape[1])))
    for c in np.flatnonzero(np.any(ways != 0.0, axis=0)):
        moved = law.with_heights(law.heights + size * ways[:, c])
        other = replace(chain, effects=(*chain.effects[:index], moved, *chain.effects[index + 1 :]))
        there = setting.input_on_grid(other, signal, acquisition, steps)
        for result, before, after in zip(found, here, there, strict=True):
            result[:, c] = (after - before) / size
    return found


def _no_law(count: int) -> Law:
    """No law among the forces, and so many changes that do nothing to them."""
    none, nowhere = np.zeros(count, np.int64), np.full(count, np.inf)
    return Law(
        effect=0,
        first=0,
        over_velocity=False,
        times=0,
        knots=np.array([0.0, 1.0]),
        heights=np.zeros(2),
        place=np.zeros(3, np.int64),
        column=none,
        share=np.zeros(count),
        changes=np.zeros((count, 2)),
        size=1.0,
        begins=none,
        ends=none,
        low=nowhere,
        high=-nowhere,
    )


def _law_of(chain: Chain, law: LearnedForce, index: int, ways: Array, size: float) -> Law:
    """The law among the forces, as compiled code takes it."""
    count = len(law.knots)
    # What becomes of a height of one: it has a sign along the input.
    along = np.array(law.with_heights(np.ones(count)).force_values(chain.plant))
    heights = np.array(law.force_values(chain.plant))
    first = len(along) - count
    shares = along[first:, None] * ways
    changing = ways.T != 0.0
    begins, ends = np.argmax(changing, axis=1), count - np.argmax(changing[:, ::-1], axis=1)
    silent = ~changing.any(axis=1)
    ends[silent] = begins[silent]
    # A height acts up to the knots beside its own, and the outermost ones beyond the knots.
    edges = np.concatenate([[-np.inf], law.knots, [np.inf]])
    low, high = edges[begins], edges[np.minimum(ends + 1, count + 1)]
    low[silent], high[silent] = np.inf, -np.inf
    rows, columns = np.nonzero(ways)
    return Law(
        effect=index,
        first=first,
        over_velocity=law.over == "velocity",
        times=int(along[1]),
        knots=law.knots,
        heights=heights[first:].copy(),
        place=np.searchsorted(rows, np.arange(count + 1)),
        column=np.ascontiguousarray(columns),
        share=shares[rows, columns],
        changes=np.ascontiguousarray(size * shares.T),
        size=size,
        begins=begins,
        ends=ends,
        low=low,
        high=high,
    )


def _of_reading(chain: Chain, output: Array, changes: Array, time: Array, signal: Array, size: float) -> Array:
    """Derivatives of the samples by changes of what the sensor makes of the motion, shape (N, c)."""
    here = after_sensor(chain, output, time, signal)
    found = [(after_sensor(chain, output + size * each, time, signal) - here) / size for each in changes.T]
    return np.column_stack(found)


def _of_windows(chain: Chain, motion: Motion, changes: Changes, time: Array, signal: Array, size: float) -> Array:
    """Derivatives of the samples by changes of the motion, where the sensor is not linear in it, shape (N, c)."""
    here, found = observed(chain, motion, time, signal), []
    rows = (np.ascontiguousarray(each.T) for each in changes)
    for position, velocity, integral in zip(*rows, strict=True):
        beside = replace(
            motion,
            position=motion.position + size * position,
            velocity=motion.velocity + size * velocity,
            integral=motion.integral + size * integral,
            velocity_end=motion.velocity_end + size * velocity[1:],
        )
        found.append((observed(chain, beside, time, signal) - here) / size)
    return np.column_stack(found)
