"""A chain, and the linear system with forces that the compiled integrator takes in its place.

Dynamics before the plant, the plant and dynamics after it become one companion system in scaled time, with the
integral of the measured motion as its last state; the effects' forces become addresses of compiled functions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.companion_form import companion, derivative_rows, time_scale
from camid.chain.controller import Loop
from camid.chain.input_log import InputLog
from camid.chain.observer import Pull
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.plant_force import motion_sign
from camid.engine.forces import Forces, Mechanics
from camid.engine.nonlinear_plant import NonlinearPlant
from camid.engine.plant_equations import PlantEquations, no_equations
from camid.engine.work import Work

Array = NDArray[np.float64]

# Share of the largest speed below which friction that acts with a lag grows in proportion to the speed.
SLIP = 0.01

# Time of the difference of velocities that is an acceleration of a plant of equations, in radians of its fastest pole.
PROBE = 1e-5

# Numbers that a compiled part may read: zeros behind those that it gets.
FEWEST_VALUES = 10


class NotApplicable(ValueError):  # noqa: N818 - it says what the effect is here
    """An effect that has no meaning with this plant."""


class MotionJumps(NotApplicable):
    """A plant that passes its input without delay, effects before and after it included: its motion jumps."""


@dataclass(frozen=True)
class Chain:
    """A chain, ready to run.

    Attributes
    ----------
    plant : TransferFunction
        Of a plant of equations, that of small motions about its start.
    acquisition : Acquisition
        As declared; effects may declare another.
    effects : tuple of Effect
        Actuator effects act in this order, sensor effects too.
    initial_state : ndarray, shape (n,) or more, optional
        Companion state of the plant in units of its time scale, at the time that ``state_before_record`` says; those
        of the dynamics of effects beside the plant, then of those after it and before it, may follow.
    state_before_record : bool
        Whether that is the start of the interval in which the first frame's exposure starts, or the first sample.
    steps : int, optional
        Steps of the integrator per period; where it is not given they follow the plant, and become finer until the
        motion no longer changes; where it is 0 they only follow the plant.
    loop : Loop, optional
        A controller that makes the input; the recorded one then says nothing.
    pull : Pull, optional
        An observer that adds to what drives the plant, and holds the motion near the recorded one.
    known_force : tuple of (ndarray of shape (N,), {"zoh", "foh"}), optional
        A force at the plant's input that is a function of time, and how it goes on between the samples.
    equations : NonlinearPlant, optional
        Of a nonlinear plant; ``initial_state`` is then its states.
    input_log : InputLog, optional
        The input at times of its own, which takes the place of the samples at the frames.
    weight : float
        Factor of what the sensor reads.
    work : Work, optional
        Counts what running the chain takes.
    initial_memory : ndarray, shape (number of effects,), optional
        What the forces that remember begin with; they have forgotten everything where it is not given.

    Raises
    ------
    NotApplicable
        If an effect has no meaning with this plant.
    ValueError
        If effects declare an impossible acquisition.
    """

    plant: TransferFunction
    acquisition: Acquisition
    effects: tuple[Effect, ...] = ()
    initial_state: Array | None = None
    state_before_record: bool = True
    steps: int | None = None
    loop: Loop | None = None
    pull: Pull | None = None
    known_force: tuple[Array, str] | None = None
    equations: NonlinearPlant | None = None
    input_log: InputLog | None = None
    weight: float = 1.0
    work: Work | None = None
    initial_memory: Array | None = None

    def declared(self) -> Acquisition:
        """Acquisition with what the effects declare."""
        acquisition = self.acquisition
        for effect in self.effects:
            acquisition = effect.declare(acquisition)
        return acquisition

    def whole_plant(self) -> TransferFunction:
        """Plant with the linear dynamics before, beside and after it."""
        plant = self.plant
        for effect in self.effects:
            beside = effect.beside_plant()
            plant = plant if beside is None else plant + beside
        for effect in self.effects:
            for part in (effect.before_plant(), effect.after_plant()):
                if part is not None:
                    plant = plant * part
        return plant


def jump_of(mechanics: Mechanics) -> Array:
    """Jump of motion, velocity and acceleration before the sensor at an impulse of one, in seconds; shape (3,)."""
    row, jump = mechanics.measured, np.empty(3)
    for i in range(3):
        jump[i] = row @ mechanics.force_vector / mechanics.time_unit ** (i + 1)
        row = row @ mechanics.state_matrix
    return jump


# A screening simulates the same plant some hundred times, each time with another effect.
@lru_cache(maxsize=64)
def companion_block(plant: TransferFunction, unit: float) -> tuple[Array, Array, Array]:
    """Companion matrix, output row, and whether the input passes at once, in scaled time; none may be written to."""
    monic = plant.monic
    order, degree = monic.order, len(monic.numerator) - 1
    denominator = np.asarray(monic.denominator) * unit ** np.arange(order + 1)
    numerator = np.asarray(monic.numerator) * unit ** (order - degree + np.arange(degree + 1.0))
    row = numerator @ derivative_rows(denominator, range(degree, -1, -1))
    matrix = companion(denominator)
    for array in (matrix, row):
        array.flags.writeable = False
    return matrix, row[:order], row[order:]


class _Line(NamedTuple):
    """Linear dynamics before the plant, the plant with those beside it, and those after, as one system in scaled time.

    ``plant`` says where the plant's states lie, ``driving`` and ``driving_input`` what enters it; ``measured`` and
    ``position`` are rows for the motion that the sensor sees and for that of the plant, before the integral of the
    measured motion is added as the last state. ``moved_at_once`` and ``seen_at_once`` say whether input or force move
    the plant, and what the sensor sees, without delay.
    """

    state_matrix: Array
    input_vector: Array
    force_vector: Array
    measured: Array
    position: Array
    plant: tuple[int, int]
    driving: Array
    driving_input: float
    moved_at_once: bool
    seen_at_once: bool


def _line(chain: Chain, unit: float) -> _Line:
    """The dynamics of a chain.

    Raises
    ------
    MotionJumps
        If what the sensor sees does.
    """
    before = tuple(p for e in chain.effects if (p := e.before_plant()) is not None)
    beside = tuple(p for e in chain.effects if (p := e.beside_plant()) is not None)
    after = tuple(p for e in chain.effects if (p := e.after_plant()) is not None)
    if chain.equations is None:
        line = _line_of(before, chain.plant, beside, after, unit)
    else:
        blocks = [_block(p, unit) for p in (*before, chain.plant, *beside, *after)]
        blocks[len(before)] = chain.equations.block()
        line = _joined(blocks, len(before), len(before) + len(beside))
        if chain.equations.seen is not None:
            # Forces depend on the plant's output, and not on what a column of the sensor reads.
            position = np.zeros_like(line.position)
            position[line.plant[0] + len(chain.equations.equations.states)] = 1.0
            line = line._replace(position=position)
    if line.moved_at_once:
        _refuse_direct(chain)
    if line.seen_at_once:
        raise MotionJumps("the input passes the plant without delay: its motion jumps")
    return line


Parts = tuple[TransferFunction, ...]


# A screening simulates the same dynamics some hundred times, each time with another force.
@lru_cache(maxsize=64)
def _line_of(before: Parts, plant: TransferFunction, beside: Parts, after: Parts, unit: float) -> _Line:
    """The dynamics of transfer functions; no array may be written to.

    They are not flagged so: compiled code takes arrays that cannot be written to for another type.
    """
    blocks = [_block(p, unit) for p in (*before, plant, *beside, *after)]
    return _joined(blocks, len(before), len(before) + len(beside))


Block = tuple[Array, Array, Array, Array]


def _joined(blocks: Sequence[Block], first: int, last: int) -> _Line:
    """The dynamics of blocks in series, of which the first to the last are the plant and those beside it."""
    size = sum(len(b[0]) for b in blocks)
    matrix = np.zeros((size + 1, size + 1))
    input_vector, force_vector = np.zeros(size + 1), np.zeros(size + 1)
    position = np.zeros(size + 1)
    # Row and direct input of the signal that enters the next block.
    row, direct_input, direct_force = np.zeros(size + 1), 1.0, 0.0
    offset, where, moved_at_once = 0, (0, 0), False
    driving, driving_input = row.copy(), direct_input
    for i, (block, enters, output, direct) in enumerate(blocks):
        order = len(block)
        if i == first:
            where, direct_force = (offset, offset + order), 1.0
            # What drives the plant drives the dynamics beside it.
            driving, driving_input = row.copy(), direct_input
        elif first < i <= last:
            outputs, passed_input, passed_force = row, direct_input, direct_force
            row, direct_input, direct_force = driving, driving_input, 1.0
        if order:
            matrix[offset : offset + order, offset : offset + order] = block
            matrix[offset : offset + order] += np.outer(enters, row)
            input_vector[offset : offset + order] = enters * direct_input
            force_vector[offset : offset + order] = enters * direct_force
        through = float(direct[0])
        row, direct_input, direct_force = row * through, direct_input * through, direct_force * through
        row[offset : offset + order] += output
        if first < i <= last:
            row, direct_input, direct_force = row + outputs, direct_input + passed_input, direct_force + passed_force
        offset += order
        if i == last:
            position = row.copy()
            moved_at_once = bool(direct_input or direct_force)
    seen_at_once = bool(direct_input or direct_force)
    matrix[size] = row
    return _Line(
        matrix,
        input_vector,
        force_vector,
        row,
        position,
        where,
        driving,
        driving_input,
        moved_at_once,
        seen_at_once,
    )


def _block(plant: TransferFunction, unit: float) -> Block:
    """Companion matrix, where the input enters, output row, and whether the input passes at once, in scaled time."""
    matrix, row, direct = companion_block(plant, unit)
    return matrix, np.eye(1, len(matrix))[0], row, direct


def mechanics_of(chain: Chain, signal: Array) -> tuple[Mechanics, tuple[int, int]]:
    """The chain as the integrator takes it, and where the plant's states lie.

    Raises
    ------
    NotApplicable
        If an effect has no meaning with this plant.
    """
    unit = 1.0 if chain.equations is not None else time_scale(chain.plant.monic.denominator)
    line = _line(chain, unit)
    velocity = line.position @ line.state_matrix
    at_once = np.array([line.position @ line.input_vector, line.position @ line.force_vector]) / unit
    at_once[np.abs(at_once) <= 1e-12 * float(np.max(np.abs(line.position), initial=0.0)) / unit] = 0.0
    dry = any(e.friction_level is not None for e in chain.effects)
    implicit = at_once[1] != 0.0 and (dry or any(e.uses_velocity for e in chain.effects))
    acceleration = float(velocity @ line.force_vector)
    sticks = at_once[1] == 0.0 and abs(acceleration) > 1e-9 * float(np.max(np.abs(velocity), initial=0.0))
    slip = _slip(chain, signal) if dry and not sticks and not implicit else 0.0
    forces = _forces(chain, float(at_once[1]), bool(implicit), slip)
    mechanics = Mechanics(
        line.state_matrix,
        line.input_vector,
        line.force_vector,
        line.measured,
        line.position,
        velocity,
        float(at_once[0]),
        bool(sticks),
        forces,
        unit,
        _equations(chain, line, dry=bool(dry and sticks)),
    )
    return mechanics, line.plant


def _equations(chain: Chain, line: _Line, *, dry: bool) -> PlantEquations:
    """The plant's equations as compiled code takes them."""
    if chain.equations is None:
        for effect in chain.effects:
            if effect.limited_state() is not None:
                raise NotApplicable(f"{effect.identifier} limits a state, and the plant has no equations")
        return no_equations()
    fastest = chain.plant.fastest_pole or 1.0
    limited = [limit for effect in chain.effects if (limit := effect.limited_state()) is not None]
    entering = (line.plant[0], line.driving, line.driving_input)
    forced = any(e.force is not None or e.friction_level is not None for e in chain.effects)
    return chain.equations.compiled(entering, PROBE / fastest, limited, forced=forced, dry=dry)


def _forces(chain: Chain, velocity_force: float, implicit: bool, slip: float) -> Forces:
    """Addresses of the compiled parts of all effects, and their values."""
    count = len(chain.effects)
    addresses = np.zeros((5, count), np.int64)
    numbers = [
        effect.beside(chain.effects, chain.acquisition.period).force_values(chain.plant) for effect in chain.effects
    ]
    values = np.zeros((count, max([FEWEST_VALUES, *(len(n) for n in numbers)])))
    for i, effect in enumerate(chain.effects):
        parts = (effect.force, effect.friction_level, effect.memory_after, effect.switch, effect.actuated)
        for kind, part in enumerate(parts):
            addresses[kind, i] = 0 if part is None else part.address
        values[i, : len(numbers[i])] = numbers[i]
    along = motion_sign(chain.plant)
    data, stride = values.ctypes.data, values.shape[1] * 8
    ramps = any(e.actuated is not None and not e.keeps_hold for e in chain.effects)
    begun = np.zeros(count) if chain.initial_memory is None else chain.initial_memory
    return Forces(addresses, values, begun, data, stride, velocity_force, implicit, along, slip, ramps)


def _slip(chain: Chain, signal: Array) -> float:
    """Speed in y/s below which dry friction is taken to grow in proportion: a part of what the input can cause."""
    poles = np.abs(chain.plant.poles())
    frequencies = poles[poles > 0.0] if np.any(poles > 0.0) else np.ones(1)
    reached = np.max(frequencies * np.abs(chain.plant.frequency_response(frequencies)))
    return SLIP * float(reached) * (float(np.max(np.abs(signal), initial=0.0)) or 1.0)


def _refuse_direct(chain: Chain) -> None:
    for effect in chain.effects:
        if effect.force is not None or effect.friction_level is not None:
            raise NotApplicable(f"{effect.identifier} depends on a motion that jumps with the input")
