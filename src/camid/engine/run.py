"""The engine: the whole chain hold → actuator → plant → sensor with any effects of the catalogue.

A linear chain with a held or straight input takes the exact path of :mod:`camid.chain.exact`; any other is run
by the compiled integrator on a grid of several steps per frame, and the sensor reads the motion between the nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, inf

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.motion import Motion
from camid.effects.base import Effect
from camid.engine.forces import Mechanics
from camid.engine.input import feedback_of, grid_input, parts_in_a_period, periods_past
from camid.engine.integrator import integrate
from camid.engine.mechanics import Chain, jump_of, mechanics_of

Array = NDArray[np.float64]

# Length of a step of the integrator in radians of the fastest motion that forces can excite. Smooth forces leave an
# error of the fourth power of it; the parts of steps that events split are more sensitive.
STEP_SMOOTH = 0.25
STEP_EVENTS = 0.25
# How much shorter steps are for linear parts beside a plant of equations, whose doubts do not measure their error.
FINER_BESIDE = 2.5
# Steps in radians of the fastest pole of the dynamics beside, before and after the plant: a Runge-Kutta step of 2.8 is
# unstable. The second one is for rough simulations.
STEP_STIFF, STEP_STIFF_ROUGH = 1.5, 2.2
FEWEST_STEPS = 2
FEWEST_STEPS_EVENTS = 3
MOST_STEPS = 400
MOST_STEPS_ASTRAY = 64
# Steps per frame for an input with times of its own, which changes anywhere in a step: one for each sample at best.
FEWEST_STEPS_LOG = 4
MOST_STEPS_LOG = 8
# Value of ``steps`` for a rough simulation: as few as plant and effects suggest, and at most so many.
ROUGH = 0
MOST_ROUGH_STEPS = 12
# Nodes of the grid of a simulation that doubts itself, beyond which it is left to.
MOST_NODES = 200_000
# Largest difference from the motion with half as many steps, in its standard deviations, that counts as none.
LARGEST_CHANGE = 2e-5
# How much finer than at first the steps become where a simulation doubts itself.
MOST_FINER = 16
# Parts of a bent input of which the integrator takes the mean and the first moment at once.
PARTS_IN_A_STEP = 4
# Length of a step where the velocity follows from the force at once.
STEP_IMPLICIT = 0.15
# Difference of two forces that should be the same, as a share of the largest force or input, above which a motion is
# integrated again with half the step; the error of the output is a tenth of it. Where a force depends on the velocity
# it is of second order in the step and not of third, and the error a hundredth of it.
MOST_DOUBT = 2e-4
MOST_DOUBT_VELOCITY = 4e-3
MOST_DOUBT_EVENTS = 1e-3
# The same where the velocity follows from the force at once.
MOST_DOUBT_IMPLICIT = 1.5e-3
# Where a force jumps, a step that holds the jump sees two forces however short it is.
MOST_DOUBT_JUMPS = 1e3


def run(chain: Chain, signal: Array, time: Array, *, moved: Callable[[], Motion] | None = None) -> Array:
    """Samples of the sensor at the end of a chain.

    Parameters
    ----------
    chain : Chain
    signal : ndarray, shape (N,)
        Recorded input u_k.
    time : ndarray, shape (N,)
        Recorded times in seconds.
    moved : callable, optional
        The motion before the sensor, of a caller that may know it already; asked only where the integrator is needed.

    Returns
    -------
    ndarray, shape (N,)
        w_k, in units of y; in a closed loop what the controller puts out, in units of u: there the position follows the
        reference whatever the plant is like, and the control is what tells of the plant.
    """
    acquisition = chain.declared()
    if chain.work is not None:
        chain.work.add_run(len(signal))
    output = exactly(chain, signal, acquisition)
    if output is None:
        motion = move(chain, signal, time, acquisition) if moved is None else moved()
        if motion.control is not None:
            return motion.control
        return observed(chain, motion, time, signal)
    return after_sensor(chain, output, time, signal)


def after_sensor(chain: Chain, output: Array, time: Array, signal: Array) -> Array:
    """What effects on the reading make of it beside the recorded input, weighted."""
    for effect in chain.effects:
        output = effect.observe(output, time)
        picked_up = effect.picked_up(signal)
        output = output if picked_up is None else output + picked_up
    return output if chain.weight == 1.0 else chain.weight * output


def observed(chain: Chain, motion: Motion, time: Array, signal: Array) -> Array:
    """Samples of the sensor, shape (N,), of a motion at the recorded times, beside the recorded input."""
    return after_sensor(chain, read(chain, motion, time, chain.declared()), time, signal)


# Hooks that say what the sensor makes of a motion.
OF_THE_MOTION = ("carry", "windows", "measure")


def overrides(effect: Effect, *names: str) -> bool:
    """Whether an effect does something by one of these hooks."""
    return any(getattr(type(effect), name) is not getattr(Effect, name) for name in names)


def _acts_on_motion(effect: Effect) -> bool:
    """Whether the effect is a force, one that depends on the motion or not."""
    compiled = (effect.force, effect.friction_level)
    return any(part is not None for part in compiled) or overrides(effect, "impulses")


def exactly(chain: Chain, signal: Array, acquisition: Acquisition) -> Array | None:
    """Output of a linear chain with a held or straight input, or None."""
    if any(part is not None for part in (chain.loop, chain.pull, chain.known_force, chain.equations, chain.input_log)):
        return None
    if any(_acts_on_motion(e) or overrides(e, *OF_THE_MOTION) for e in chain.effects):
        return None
    shapes = [e for e in chain.effects if overrides(e, "transform")]
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
    return _moved(chain, signal, time, chain.declared() if acquisition is None else acquisition)[0]


def _moved(
    chain: Chain, signal: Array, time: Array, acquisition: Acquisition, negligible: float = LARGEST_CHANGE
) -> tuple[Motion, int]:
    """Motion before the sensor, and steps per period that are enough.

    Where a change of the motion is ``negligible``, as a share of its standard deviation, that would not count as none,
    they begin with few, and half as many steps as those of the motion are enough where it differs by less from that.
    """
    setting = prepared(chain, signal, time, acquisition)
    mechanics, period = setting.mechanics, acquisition.period
    steps = chain.steps or _first_steps(chain, acquisition, mechanics)
    fewest = steps
    if chain.steps == ROUGH or negligible > LARGEST_CHANGE:
        steps = _few(steps, chain, acquisition)
    affordable = max(MOST_NODES // max(len(signal), 1), steps)
    most_steps = steps if chain.steps is not None else min(MOST_FINER * fewest, MOST_STEPS, affordable)
    most_doubt = MOST_DOUBT
    if any(e.jumps for e in chain.effects):
        most_doubt = MOST_DOUBT_JUMPS
    elif any(e.uses_velocity for e in chain.effects):
        most_doubt = MOST_DOUBT_IMPLICIT if mechanics.forces.implicit else MOST_DOUBT_VELOCITY
    elif any(e.switch is not None for e in chain.effects):
        most_doubt = MOST_DOUBT_EVENTS
    coarser: Array | None = None
    enough = 0
    while True:
        step = period / steps
        start, end = setting.input_on_grid(chain, signal, acquisition, steps)
        feedback = feedback_of(chain.loop, chain.pull, steps)
        position, velocity, integral, velocity_end, doubt = integrate(
            mechanics, setting.initial, start, end, setting.start_time, step, *setting.shocks, feedback
        )
        if chain.work is not None and doubt < inf:
            chain.work.add_steps(mechanics, len(start))
        # A motion that runs away may do so with any step, so that not much is spent on it.
        trusted = doubt <= most_doubt and (steps >= fewest or chain.steps is not None)
        if trusted or steps >= (most_steps if doubt < inf else min(most_steps, MOST_STEPS_ASTRAY)):
            break
        if coarser is not None:
            change, spread = np.max(np.abs(position[::2] - coarser)), np.std(position)
            if change <= LARGEST_CHANGE * spread:
                break
            if change <= negligible * spread:
                enough = steps // 2
                break
        coarser = position
        steps = 2 * steps
    _, times, sizes = setting.shocks
    jumps = np.outer(sizes, jump_of(mechanics)) if len(sizes) else np.zeros((0, 3))
    control = None if chain.loop is None else feedback.control
    motion = Motion(setting.start_time, step, position, velocity, integral, velocity_end, times, jumps, control)
    return motion, enough or steps


@dataclass(frozen=True)
class Setting:
    """What a run of the integrator begins with, whatever its steps.

    Attributes
    ----------
    mechanics : Mechanics
    initial : ndarray, shape (q,)
    delay : int
        Periods by which the grid begins before the record.
    start_time : float
        Of the grid, in seconds.
    shocks : tuple of ndarray
        Times in seconds at which a force jumps, and times and sizes of impulses, both sorted.
    margin : int
        Periods by which the grid goes on past the record.
    """

    mechanics: Mechanics
    initial: Array
    delay: int
    start_time: float
    shocks: tuple[Array, Array, Array]
    margin: int

    def input_on_grid(self, chain: Chain, signal: Array, acquisition: Acquisition, steps: int) -> tuple[Array, Array]:
        """Input at the start and end of each of so many steps in a period; see :func:`grid_input`."""
        log = None if chain.input_log is None else (chain.input_log, self.start_time)
        parts = parts_in_a_period(chain.effects, acquisition, chain.plant)
        return grid_input(
            chain.effects,
            signal,
            acquisition,
            self.delay,
            steps,
            chain.loop,
            chain.known_force,
            log,
            parts,
            self.margin,
        )


def prepared(chain: Chain, signal: Array, time: Array, acquisition: Acquisition) -> Setting:
    """What a run of the integrator begins with."""
    mechanics, order = mechanics_of(chain, signal)
    before = chain.initial_state is not None and chain.state_before_record and chain.loop is None and chain.pull is None
    delay = acquisition.window()[0] if before else 0
    impulses = sorted(i for e in chain.effects for i in e.impulses())
    shocks = (
        np.array(sorted(t for e in chain.effects for t in e.breaks()), dtype=float),
        np.array([t for t, _ in impulses], dtype=float),
        np.array([s for _, s in impulses], dtype=float),
    )
    initial = _initial_state(chain, len(mechanics.input_vector), order[0])
    margin = periods_past(chain.effects, time, acquisition.period)
    return Setting(mechanics, initial, delay, float(time[0]) - delay * acquisition.period, shocks, margin)


def _initial_state(chain: Chain, size: int, first: int) -> Array:
    """State at the start of the grid, shape (size,); that of the plant begins at ``first``."""
    initial = np.zeros(size)
    state = chain.initial_state
    if state is None and chain.equations is not None:
        state = chain.equations.start
    if state is not None:
        # The states of the dynamics beside and after the plant follow those of the plant, and behind these come those
        # before it and what forces remember; the last one is the integral.
        memories = sum(effect.largest_memory is not None for effect in chain.effects)
        if chain.equations is None and len(state) == size - 1 + memories:
            initial[:first] = state[size - 1 - first : size - 1]
        state = state[: size - 1 - first]
        initial[first : first + len(state)] = state
    return initial


def _first_steps(chain: Chain, acquisition: Acquisition, mechanics: Mechanics) -> int:
    """Steps per period by the plant and the effects, before anything is simulated."""
    steps = _steps(chain, acquisition)
    if mechanics.forces.implicit:
        fastest = chain.plant.fastest_pole
        steps = max(steps, min(ceil(acquisition.period * fastest / STEP_IMPLICIT), MOST_STEPS))
    return steps


def few_steps_of(chain: Chain, signal: Array) -> int:
    """Steps per period of a rough simulation, for other chains that are to be compared with it."""
    acquisition = chain.declared()
    if exactly(chain, signal, acquisition) is not None:
        return FEWEST_STEPS
    return _few(_first_steps(chain, acquisition, mechanics_of(chain, signal)[0]), chain, acquisition)


def _few(steps: int, chain: Chain, acquisition: Acquisition) -> int:
    """As many steps, but no more than are rough and stable."""
    return min(steps, max(MOST_ROUGH_STEPS, _stable_steps(chain, acquisition, STEP_STIFF_ROUGH)))


def steps_of(chain: Chain, signal: Array, time: Array, *, finest: bool, negligible: float = LARGEST_CHANGE) -> int:
    """Steps per period with which a chain is simulated, for other chains that are to be compared with it.

    Parameters
    ----------
    chain : Chain
    signal, time : ndarray, shape (N,)
    finest : bool
        Whether they become finer until the motion no longer changes, at the cost of a simulation or more.
    negligible : float
        Change of the motion, as a share of its standard deviation, for which they need not become finer.
    """
    acquisition = chain.declared()
    if exactly(chain, signal, acquisition) is not None:
        return FEWEST_STEPS
    if finest:
        return _moved(chain, signal, time, acquisition, negligible)[1]
    return _first_steps(chain, acquisition, mechanics_of(chain, signal)[0])


def exposures(time: Array, acquisition: Acquisition) -> tuple[Array, Array]:
    """Start and end of the exposures in seconds, shape (N,), where no effect shifts them."""
    frames = time[0] + acquisition.period * np.arange(len(time))
    exposure = 0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0)
    end = frames - acquisition.latency
    return end - exposure, end


def read(chain: Chain, motion: Motion, time: Array, acquisition: Acquisition) -> Array:
    """What the sensor makes of a motion."""
    start, end = exposures(time, acquisition)
    for effect in chain.effects:
        motion = effect.carry(motion)
    for effect in chain.effects:
        start, end = effect.windows(motion, start, end)
    for effect in chain.effects:
        measured = effect.measure(motion, start, end)
        if measured is not None:
            return measured
    return motion.mean(start, end)


def _steps(chain: Chain, acquisition: Acquisition) -> int:
    """Steps of the integrator per period."""
    fastest = chain.plant.fastest_pole
    if chain.equations is not None:
        # Their steps are not exact for the linear parts of the chain either.
        fastest = max(fastest, FINER_BESIDE * _fastest_part(chain))
    fastest += sum(e.frequency(chain.plant) for e in chain.effects)
    if chain.input_log is not None:
        samples = ceil(acquisition.period / chain.input_log.period - 1e-9)
        least = min(max(samples, FEWEST_STEPS_LOG), MOST_STEPS_LOG)
        fastest = max(fastest, STEP_SMOOTH * least / acquisition.period)
    events = _has_events(chain)
    steps = ceil(acquisition.period * fastest / (STEP_EVENTS if events else STEP_SMOOTH))
    if chain.input_log is None:
        parts = parts_in_a_period(chain.effects, acquisition, chain.plant)
        # What an actuator makes of a controller's output, the integrator has to find out as it goes.
        steps = max(steps, ceil(parts / PARTS_IN_A_STEP) if chain.loop is None else parts)
    steps = max(steps, _stable_steps(chain, acquisition, STEP_STIFF))
    return min(max(steps, FEWEST_STEPS_EVENTS if events else FEWEST_STEPS), MOST_STEPS)


def _fastest_part(chain: Chain) -> float:
    """Largest absolute value of the poles of the dynamics before, beside and after the plant, in rad/s."""
    parts = [p for e in chain.effects for p in (e.before_plant(), e.beside_plant(), e.after_plant()) if p is not None]
    return max((p.fastest_pole for p in parts), default=0.0)


def _stable_steps(chain: Chain, acquisition: Acquisition, longest: float) -> int:
    """Steps per period with which no part of the chain is unstable, each at most so many radians long.

    A step without events is exact for the linear parts, however fast: only those of Runge and Kutta are unstable.
    """
    by_parts = any(e.breaks() or e.impulses() for e in chain.effects)
    if not (by_parts or chain.equations is not None or _has_events(chain)):
        return FEWEST_STEPS
    return min(ceil(acquisition.period * _fastest_part(chain) / longest), MOST_STEPS)


def _has_events(chain: Chain) -> bool:
    """Whether forces may change at once on the way."""
    return any(e.friction_level is not None or e.switch is not None for e in chain.effects)
