"""The compiled view of a chain with forces: a linear system, and functions that are called by their address.

Where the plant has one pole more than zeros, a force changes the velocity at once, so force and velocity follow from
each other: v = v₀ + b f(v). The solution is unique for forces that grow with the speed; where dry friction falls with
it (Stribeck), a body at rest stays at rest as long as it can.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from camid.compiled import kernel
from camid.engine.plant_equations import PlantEquations

Array = NDArray[np.float64]

# Halvings and other steps of the search for a velocity that agrees with its force.
MOST_TRIALS = 60


class Forces(NamedTuple):
    """The forces of a chain, as compiled code takes them.

    Attributes
    ----------
    functions : ndarray of int, shape (5, f)
        Addresses of the compiled force, friction level, inner state, switch and actuator of each effect; 0 where it has
        none.
    values : ndarray, shape (f, v)
    begun : ndarray, shape (f,)
        Inner states at the start.
    data, stride : int
        Where the values begin in memory, and bytes from one effect's to the next one's.
    velocity_force : float
        Velocity in y/s that a unit of force makes at once; zero with two poles more than zeros.
    implicit : bool
        Whether a force depends on a velocity that it changes at once.
    along : float
        Sign of the gain: dry friction against the motion acts along ``-along · direction``.
    slip : float
        Speed in y/s below which dry friction grows in proportion, for plants in which it acts with a lag and would
        chatter; zero elsewhere.
    ramps : bool
        Whether an actuator takes time to follow its command.
    """

    functions: NDArray[np.int64]
    values: Array
    begun: Array
    data: int
    stride: int
    velocity_force: float
    implicit: bool
    along: float
    slip: float
    ramps: bool


class Mechanics(NamedTuple):
    """A linear system with forces, as compiled code takes it; time in a unit of its own.

    Attributes
    ----------
    state_matrix : ndarray, shape (q, q)
        The last state is the integral of the measured motion.
    input_vector, force_vector : ndarray, shape (q,)
        Of the input after the actuator and of a force at the plant's input.
    measured, position, velocity : ndarray, shape (q,)
        Rows for the motion that the sensor sees, for the motion that the forces depend on, and for its velocity (per
        unit of time) without what input and force do to it at once.
    velocity_input : float
        Velocity in y/s that a unit of input makes at once; zero with two poles more than zeros.
    sticks : bool
        Whether a force at the plant's input acts on the acceleration at once, so that friction can hold the body.
    forces : Forces
    time_unit : float
        Seconds; one where the plant has equations.
    equations : PlantEquations
        Of a nonlinear plant, whose part of the matrix is that of the plant linearised at its start.
    """

    state_matrix: Array
    input_vector: Array
    force_vector: Array
    measured: Array
    position: Array
    velocity: Array
    velocity_input: float
    sticks: bool
    forces: Forces
    time_unit: float
    equations: PlantEquations


def _call_by_address(
    typing_context: Any,
    address: Any,
    time: Any,
    position: Any,
    velocity: Any,
    signal: Any,
    memory: Any,
    values: Any,
) -> Any:
    """Call a compiled function by its address, so that code which calls it need not be compiled anew for each."""
    signature = types.float64(types.int64, *[types.float64] * 5, types.int64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        double = ir.DoubleType()
        function = ir.FunctionType(double, [double] * 5 + [double.as_pointer()])
        pointer = builder.inttoptr(arguments[0], function.as_pointer())
        return builder.call(pointer, [*arguments[1:6], builder.inttoptr(arguments[6], double.as_pointer())])

    return signature, generate


call: Any = intrinsic(_call_by_address)


@kernel(inline="always")
def dot(row: Array, state: Array) -> float:
    """Scalar product; a call of BLAS costs more than the few multiplications."""
    total = 0.0
    for i in range(len(row)):
        total += row[i] * state[i]
    return total


@kernel(forceinline=True)
def free_velocity(m: Mechanics, state: Array, signal: float) -> float:
    """Velocity in y/s but for what forces make of it at once."""
    return dot(m.velocity, state) / m.time_unit + m.velocity_input * signal


@kernel(error_model="numpy", forceinline=True)
def _smooth_force(f: Forces, time: float, position: float, velocity: float, signal: float, memory: Array) -> float:
    """Sum of the forces other than dry friction, along the input."""
    functions = f.functions
    data = f.data
    stride = f.stride
    total = 0.0
    for i in range(functions.shape[1]):
        if functions[0, i] != 0:
            total -= call(functions[0, i], time, position, velocity, signal, memory[i], data + i * stride)
    return total


@kernel(error_model="numpy", forceinline=True)
def friction_level(f: Forces, time: float, position: float, speed: float, signal: float) -> float:
    """Sum of all dry friction at a speed ≥ 0, never negative."""
    functions = f.functions
    data = f.data
    stride = f.stride
    total = 0.0
    for i in range(functions.shape[1]):
        if functions[1, i] != 0:
            total += call(functions[1, i], time, position, speed, signal, 0.0, data + i * stride)
    return max(total, 0.0)


@kernel(inline="always")
def _narrowed(
    low: float, at_low: float, high: float, at_high: float, kept: int, between: float, error: float
) -> tuple[float, float, float, float, int]:
    """A bracket of a root with a point between its ends; ``kept`` is the end that stayed before: 1 low, -1 high.

    The value at an end that stays again is reduced (Anderson & Björck 1973, BIT 13, 253–264).
    """
    if error > 0.0:
        if kept == 1:
            reduced = 1.0 - error / at_high
            at_low *= reduced if reduced > 0.0 else 0.5
        return low, at_low, between, error, 1
    if kept == -1:
        reduced = 1.0 - error / at_low
        at_high *= reduced if reduced > 0.0 else 0.5
    return between, error, high, at_high, -1


@kernel
def _agreeing_force(f: Forces, time: float, position: float, free: float, signal: float, memory: Array) -> float:
    """Force along the input that agrees with the velocity v = free + b · force that it leaves."""
    b = f.velocity_force
    rest = free + b * _smooth_force(f, time, position, 0.0, signal, memory)
    held = abs(b) * friction_level(f, time, position, 0.0, signal)
    if abs(rest) <= held:
        return -free / b
    side = 1.0 if rest > 0.0 else -1.0
    low, high = 0.0, abs(rest)
    at_low, at_high = held - abs(rest), 0.0
    # An error of the speed that the rounding of its parts makes anyway.
    least = 1e-15 * abs(free)
    kept = 0
    # The error of a speed: what is left of it once the force that it calls for has acted.
    for trial in range(2 * MOST_TRIALS):
        finding = at_high <= 0.0
        if finding:
            speed = high
        else:
            speed = high - at_high * (high - low) / (at_high - at_low)
            if not low < speed < high or trial % 8 == 7:
                speed = 0.5 * (low + high)
        others = _smooth_force(f, time, position, side * speed, signal, memory)
        error = speed - side * (free + b * others) + abs(b) * friction_level(f, time, position, speed, signal)
        if abs(error) <= 1e-14 * speed + least:
            low = high = speed
            break
        if not finding:
            low, at_low, high, at_high, kept = _narrowed(low, at_low, high, at_high, kept, speed, error)
        elif error > 0.0:
            at_high = error
        else:
            low, at_low = speed, error
            high *= 2.0
        if at_high > 0.0 and high - low <= 1e-14 * high:
            break
    return (side * 0.5 * (low + high) - free) / b


@kernel(error_model="numpy", forceinline=True)
def force_at(
    f: Forces, time: float, position: float, free: float, signal: float, memory: Array, direction: float
) -> float:
    """Total force along the input: all forces, and dry friction against ``direction`` (0: none)."""
    if f.implicit:
        return _agreeing_force(f, time, position, free, signal, memory)
    total = _smooth_force(f, time, position, free, signal, memory)
    if direction != 0.0:
        total -= f.along * direction * friction_level(f, time, position, max(direction * free, 0.0), signal)
    elif f.slip > 0.0:
        share = min(max(free / f.slip, -1.0), 1.0)
        total -= f.along * share * friction_level(f, time, position, abs(free), signal)
    return total


@kernel
def force_in(m: Mechanics, time: float, state: Array, signal: float, memory: Array, direction: float) -> float:
    """Total force along the input in a state; see :func:`force_at`."""
    return force_at(m.forces, time, dot(m.position, state), free_velocity(m, state, signal), signal, memory, direction)


@kernel(forceinline=True)
def remember(f: Forces, time: float, elapsed: float, displacement: float, memory: Array, result: Array) -> None:
    """Inner states after a displacement of the body that took ``elapsed`` seconds."""
    data = f.data
    stride = f.stride
    speed = displacement / elapsed if elapsed > 0.0 else 0.0
    for i in range(f.functions.shape[1]):
        result[i] = memory[i]
        if f.functions[2, i] != 0:
            result[i] = call(f.functions[2, i], time, displacement, speed, 0.0, memory[i], data + i * stride)


@kernel(forceinline=True)
def switches_at(
    f: Forces,
    time: float,
    position: float,
    free: float,
    signal: float,
    memory: Array,
    direction: float,
    result: Array,
) -> None:
    """Values of the functions whose change of sign marks a kink, shape (f + 2,); 1 where an effect has none.

    The last two mark where a velocity that forces change at once leaves the range in which dry friction holds the body.
    """
    data = f.data
    stride = f.stride
    velocity, known = free, f.velocity_force == 0.0
    for i in range(f.functions.shape[1]):
        result[i] = 1.0
        if f.functions[3, i] != 0:
            if not known:
                velocity += f.velocity_force * force_at(f, time, position, free, signal, memory, direction)
                known = True
            result[i] = call(f.functions[3, i], time, position, velocity, signal, memory[i], data + i * stride)
    count = f.functions.shape[1]
    result[count], result[count + 1] = 1.0, 1.0
    if f.implicit:
        b = f.velocity_force
        rest = free + b * _smooth_force(f, time, position, 0.0, signal, memory)
        held = abs(b) * friction_level(f, time, position, 0.0, signal)
        result[count], result[count + 1] = rest - held, rest + held


@kernel
def switches(
    m: Mechanics, time: float, state: Array, signal: float, memory: Array, direction: float, result: Array
) -> None:
    """The same in a state; see :func:`switches_at`."""
    free = free_velocity(m, state, signal)
    switches_at(m.forces, time, dot(m.position, state), free, signal, memory, direction, result)
