"""The engine: the whole chain hold → actuator → plant → sensor with any effects of the catalogue.

A chain that is linear behind a held or straight input takes the exact path of :mod:`camid.chain.exact`; any other is
run by the compiled integrator on a grid of several steps a frame, and the sensor reads the motion between the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.controller import Loop
from camid.chain.exact import companion, derivative_rows, sample, time_scale
from camid.chain.motion import Motion
from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.plant import motion_sign
from camid.engine.forces import Forces, Mechanics
from camid.engine.input import feedback_of, grid_input
from camid.engine.integrator import integrate

Array = NDArray[np.float64]

# Length of a step of the integrator in radians of the fastest motion that forces can excite. Smooth forces leave an
# error of the fourth power of it; the parts of steps that events split are more sensitive.
STEP_SMOOTH = 0.25
STEP_EVENTS = 0.25
FEWEST_STEPS = 2
FEWEST_STEPS_EVENTS = 3
MOST_STEPS = 400
MOST_STEPS_ASTRAY = 64
# Nodes of the grid of a simulation that doubts itself, beyond which it is left to.
MOST_NODES = 200_000
# Change of the motion from half as many steps, in its standard deviations, that is none.
SETTLED = 2e-5
# How much finer than at first the steps become where a simulation doubts itself.
MOST_FINER = 16
# Steps a frame, and their length in radians, where an actuator bends the input within a frame: the kinks lie anywhere.
INPUT_STEPS = 24
# Length of a step where the velocity follows from the force at once.
STEP_IMPLICIT = 0.06
STEP_INPUT = 0.022
# Difference of two forces that should be the same, as a share of the largest force or input, above which a motion is
# integrated again with half the step; the error of the output is a tenth of it. Where a force depends on the velocity
# it is of second order in the step and not of third, and the error a hundredth of it.
MOST_DOUBT = 2e-4
MOST_DOUBT_VELOCITY = 4e-3
MOST_DOUBT_EVENTS = 1e-3
# Share of the largest speed below which friction that acts with a lag grows in proportion to the speed.
SLIP = 0.01


class NotApplicable(ValueError):  # noqa: N818 - it says what the effect is here
    """An effect that has no meaning with this plant."""


@dataclass(frozen=True)
class Chain:
    """A chain, ready to run.

    Attributes
    ----------
    plant : TransferFunction
    acquisition : Acquisition
        As declared; effects may declare another.
    effects : tuple of Effect
        Actuator effects act in this order, sensor effects too.
    initial_state : ndarray, shape (n,), optional
        Companion state of the plant in units of its time scale, at the time that ``state_before_record`` says.
    state_before_record : bool
        Whether that is the begin of the interval in which the first frame's exposure begins, or the first sample.
    steps : int, optional
        Steps of the integrator in a period; where it is not given they follow the plant, and become finer until the
        motion no longer changes.
    loop : Loop, optional
        A controller that makes the input. The recorded input then only tells what actuator effects do to it.
    known_force : tuple of (ndarray of shape (N,), {"zoh", "foh"}), optional
        A force at the plant's input that is a function of time, and how it goes on between the samples.

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
    known_force: tuple[Array, str] | None = None

    def declared(self) -> Acquisition:
        """Acquisition with what the effects declare."""
        acquisition = self.acquisition
        for effect in self.effects:
            acquisition = effect.declare(acquisition)
        return acquisition

    def whole_plant(self) -> TransferFunction:
        """Plant with the linear dynamics before and behind it."""
        plant = self.plant
        for effect in self.effects:
            for part in (effect.before_plant(), effect.behind_plant()):
                if part is not None:
                    plant = plant * part
        return plant


def run(chain: Chain, signal: Array, time: Array) -> Array:
    """Samples of the sensor at the end of a chain.

    Parameters
    ----------
    chain : Chain
    signal : ndarray, shape (N,)
        Recorded input u_k.
    time : ndarray, shape (N,)
        Recorded times in seconds.

    Returns
    -------
    ndarray, shape (N,)
        w_k, in units of y; in a closed loop what the controller puts out, in units of u: there the position follows the
        reference whatever the plant is like, and the control is what tells of the plant.
    """
    acquisition = chain.declared()
    output = _exactly(chain, signal, acquisition)
    if output is None:
        motion = move(chain, signal, time, acquisition)
        if motion.control is not None:
            return motion.control
        return observed(chain, motion, time)
    for effect in chain.effects:
        output = effect.observe(output, time)
    return output


def observed(chain: Chain, motion: Motion, time: Array) -> Array:
    """Samples of the sensor, shape (N,), of a motion at the recorded times."""
    output = _read(chain, motion, time, chain.declared())
    for effect in chain.effects:
        output = effect.observe(output, time)
    return output


def _overrides(effect: Effect, *names: str) -> bool:
    return any(getattr(type(effect), name) is not getattr(Effect, name) for name in names)


def _acts_on_motion(effect: Effect) -> bool:
    """Whether the effect is a force, one that depends on the motion or not."""
    compiled = (effect.force, effect.friction_level)
    return any(part is not None for part in compiled) or _overrides(effect, "impulses")


def _exactly(chain: Chain, signal: Array, acquisition: Acquisition) -> Array | None:
    """Output of a chain that is linear behind a held or straight input, or None."""
    if chain.loop is not None or chain.known_force is not None:
        return None
    if any(_acts_on_motion(e) or _overrides(e, "windows", "measure") for e in chain.effects):
        return None
    shapes = [e for e in chain.effects if _overrides(e, "transform")]
    if shapes:
        if acquisition.hold != "zoh" or any(not e.keeps_hold for e in shapes):
            return None
        for effect in shapes:
            signal, end = effect.transform(signal, signal, acquisition.period)
            if end is not signal and not np.array_equal(end, signal):
                return None
    if chain.initial_state is not None:
        return None
    return sample(chain.whole_plant(), signal, acquisition)


def move(chain: Chain, signal: Array, time: Array, acquisition: Acquisition | None = None) -> Motion:
    """Motion before the sensor.

    Parameters
    ----------
    chain : Chain
    signal, time : ndarray, shape (N,)
    acquisition : Acquisition, optional
        What the chain declares, where it is known already.

    Raises
    ------
    NotApplicable
        If an effect has no meaning with this plant.
    """
    acquisition = chain.declared() if acquisition is None else acquisition
    mechanics, order = _mechanics(chain, signal)
    period = acquisition.period
    before = chain.initial_state is not None and chain.state_before_record and chain.loop is None
    delay = acquisition.window()[0] if before else 0
    initial = np.zeros(len(mechanics.input_vector))
    if chain.initial_state is not None:
        initial[order[0] : order[1]] = chain.initial_state
    begin = float(time[0]) - delay * period
    breaks = np.array(sorted(t for e in chain.effects for t in e.breaks()), dtype=float)
    impulses = sorted(i for e in chain.effects for i in e.impulses())
    times = np.array([t for t, _ in impulses], dtype=float)
    sizes = np.array([s for _, s in impulses], dtype=float)
    steps = _first_steps(chain, acquisition, mechanics) if chain.steps is None else chain.steps
    affordable = max(MOST_NODES // max(len(signal), 1), steps)
    most_steps = steps if chain.steps is not None else min(MOST_FINER * steps, MOST_STEPS, affordable)
    most_doubt = MOST_DOUBT
    if any(e.uses_velocity for e in chain.effects):
        most_doubt = MOST_DOUBT_VELOCITY
    elif any(e.switch is not None for e in chain.effects):
        most_doubt = MOST_DOUBT_EVENTS
    coarser: Array | None = None
    while True:
        step = period / steps
        start, end = grid_input(chain.effects, signal, acquisition, delay, steps, chain.loop, chain.known_force)
        feedback = feedback_of(chain.loop, steps)
        position, velocity, integral, velocity_end, doubt = integrate(
            mechanics, initial, start, end, begin, step, breaks, times, sizes, feedback
        )
        # A motion that runs away may do so with any step, so that not much is spent on it.
        if doubt <= most_doubt or steps >= (most_steps if doubt < inf else min(most_steps, MOST_STEPS_ASTRAY)):
            break
        if coarser is not None and np.max(np.abs(position[::2] - coarser)) <= SETTLED * np.std(position):
            break
        coarser = position
        steps = 2 * steps
    jumps = np.outer(sizes, _jump(mechanics)) if impulses else np.zeros((0, 3))
    control = None if chain.loop is None else feedback.control
    return Motion(begin, step, position, velocity, integral, velocity_end, times, jumps, control)


def _first_steps(chain: Chain, acquisition: Acquisition, mechanics: Mechanics) -> int:
    """Steps in a period by the plant and the effects, before anything is simulated."""
    steps = _steps(chain, acquisition)
    if mechanics.forces.implicit:
        fastest = float(np.max(np.abs(chain.plant.poles()), initial=0.0))
        steps = max(steps, min(ceil(acquisition.period * fastest / STEP_IMPLICIT), MOST_STEPS))
    return steps


def steps_of(chain: Chain, signal: Array, time: Array, *, finest: bool) -> int:
    """Steps in a period with which a chain is simulated, for other chains that are to be compared with it.

    Parameters
    ----------
    chain : Chain
    signal, time : ndarray, shape (N,)
    finest : bool
        Whether they become finer until the motion no longer changes, at the cost of a simulation or more.
    """
    acquisition = chain.declared()
    if _exactly(chain, signal, acquisition) is not None:
        return FEWEST_STEPS
    if finest:
        return round(acquisition.period / move(chain, signal, time, acquisition).step)
    return _first_steps(chain, acquisition, _mechanics(chain, signal)[0])


def _jump(mechanics: Mechanics) -> Array:
    """Jump of motion, velocity and acceleration before the sensor at an impulse of one, in seconds; shape (3,)."""
    row, jump = mechanics.measured, np.empty(3)
    for i in range(3):
        jump[i] = row @ mechanics.force_vector / mechanics.time_unit ** (i + 1)
        row = row @ mechanics.state_matrix
    return jump


def _read(chain: Chain, motion: Motion, time: Array, acquisition: Acquisition) -> Array:
    """What the sensor makes of a motion."""
    frames = time[0] + acquisition.period * np.arange(len(time))
    end = frames - acquisition.latency
    start = end - (0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0))
    for effect in chain.effects:
        start, end = effect.windows(motion, start, end)
    for effect in chain.effects:
        measured = effect.measure(motion, start, end)
        if measured is not None:
            return measured
    return motion.mean(start, end)


def _steps(chain: Chain, acquisition: Acquisition) -> int:
    """Steps of the integrator in a period."""
    fastest = float(np.max(np.abs(chain.plant.poles()), initial=0.0))
    fastest += sum(e.frequency(chain.plant) for e in chain.effects)
    events = any(e.friction_level is not None or e.switch is not None for e in chain.effects)
    steps = ceil(acquisition.period * fastest / (STEP_EVENTS if events else STEP_SMOOTH))
    if any(_overrides(e, "transform") and not (acquisition.hold == "zoh" and e.keeps_hold) for e in chain.effects):
        steps = max(steps, INPUT_STEPS, ceil(acquisition.period * fastest / STEP_INPUT))
    return min(max(steps, FEWEST_STEPS_EVENTS if events else FEWEST_STEPS), MOST_STEPS)


def companion_block(plant: TransferFunction, unit: float) -> tuple[Array, Array, Array]:
    """Companion matrix, output row, and whether the input passes at once, in scaled time."""
    monic = plant.monic
    order, degree = monic.order, len(monic.numerator) - 1
    denominator = np.asarray(monic.denominator) * unit ** np.arange(order + 1)
    numerator = np.asarray(monic.numerator) * unit ** (order - degree + np.arange(degree + 1.0))
    row = numerator @ derivative_rows(denominator, range(degree, -1, -1))
    return companion(denominator), row[:order], row[order:]


def _mechanics(chain: Chain, signal: Array) -> tuple[Mechanics, tuple[int, int]]:
    """The chain as the integrator takes it, and where the plant's states lie."""
    unit = time_scale(chain.plant.monic.denominator)
    before = [p for e in chain.effects if (p := e.before_plant()) is not None]
    behind = [p for e in chain.effects if (p := e.behind_plant()) is not None]
    blocks = [companion_block(p, unit) for p in (*before, chain.plant, *behind)]
    size = sum(len(b[0]) for b in blocks)
    matrix = np.zeros((size + 1, size + 1))
    input_vector, force_vector = np.zeros(size + 1), np.zeros(size + 1)
    position = np.zeros(size + 1)
    # Row and direct input of the signal that enters the next block.
    row, direct_input, direct_force = np.zeros(size + 1), 1.0, 0.0
    offset, where = 0, (0, 0)
    for i, (block, output, direct) in enumerate(blocks):
        order = len(block)
        if i == len(before):
            where, direct_force = (offset, offset + order), 1.0
        if order:
            matrix[offset : offset + order, offset : offset + order] = block
            matrix[offset] += row
            input_vector[offset] = direct_input
            force_vector[offset] = direct_force
        through = float(direct[0])
        row, direct_input, direct_force = row * through, direct_input * through, direct_force * through
        row[offset : offset + order] += output
        offset += order
        if i == len(before):
            position = row.copy()
            _refuse_direct(chain, np.array([direct_input, direct_force]))
    if direct_input or direct_force:
        raise NotApplicable("the input passes the plant without delay: its motion jumps")
    matrix[size] = row
    velocity = position @ matrix
    at_once = np.array([position @ input_vector, position @ force_vector]) / unit
    at_once[np.abs(at_once) <= 1e-12 * float(np.max(np.abs(position), initial=0.0)) / unit] = 0.0
    count = len(chain.effects)
    addresses = np.zeros((4, count), np.int64)
    values = np.zeros((count, 8))
    for i, effect in enumerate(chain.effects):
        for kind, part in enumerate((effect.force, effect.friction_level, effect.memory_after, effect.switch)):
            addresses[kind, i] = 0 if part is None else part.address
        numbers = effect.force_values(chain.plant)
        values[i, : len(numbers)] = numbers
    dry = any(e.friction_level is not None for e in chain.effects)
    implicit = at_once[1] != 0.0 and (dry or any(e.uses_velocity for e in chain.effects))
    acceleration = float(velocity @ force_vector)
    sticks = at_once[1] == 0.0 and abs(acceleration) > 1e-9 * float(np.max(np.abs(velocity), initial=0.0))
    slip = _slip(chain, signal) if dry and not sticks and not implicit else 0.0
    forces = Forces(
        addresses,
        values,
        values.ctypes.data,
        values.shape[1] * 8,
        float(at_once[1]),
        bool(implicit),
        motion_sign(chain.plant),
        slip,
    )
    mechanics = Mechanics(
        matrix, input_vector, force_vector, row, position, velocity, float(at_once[0]), bool(sticks), forces, unit
    )
    return mechanics, where


def _slip(chain: Chain, signal: Array) -> float:
    """Speed in y/s below which dry friction is taken to grow in proportion: a part of what the input can cause."""
    poles = np.abs(chain.plant.poles())
    frequencies = poles[poles > 0.0] if np.any(poles > 0.0) else np.ones(1)
    reached = np.max(frequencies * np.abs(chain.plant.frequency_response(frequencies)))
    return SLIP * float(reached) * (float(np.max(np.abs(signal), initial=0.0)) or 1.0)


def _refuse_direct(chain: Chain, direct: Array) -> None:
    if np.any(direct):
        for effect in chain.effects:
            if effect.force is not None or effect.friction_level is not None:
                raise NotApplicable(f"{effect.identifier} depends on a motion that jumps with the input")
