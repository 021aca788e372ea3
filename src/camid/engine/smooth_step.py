"""A step without events: that of Cox & Matthews (2002, ETDRK4).

It is exact for the linear part and for an input that is a straight line over the step, and of fourth order in the
forces.

Reference: Cox, S. M. & Matthews, P. C. (2002), J. Comput. Phys. 176, 430–455.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.chain.matrix_exponential import exponential_and_integral
from camid.compiled import kernel, njit
from camid.engine.forces import Mechanics, force_at, remember

Array = NDArray[np.float64]


@njit
def _coefficients(matrix: Array, vector: Array, step: float) -> tuple[Array, Array]:
    """exp(A h) and the columns h φ1 b, h φ2 b and h φ3 b of a vector b, shape (q, 3)."""
    size = len(vector)
    augmented = np.zeros((size + 3, size + 3))
    for i in range(size):
        augmented[i, size] = vector[i] * step
        for j in range(size):
            augmented[i, j] = matrix[i, j] * step
    augmented[size, size + 1] = 1.0
    augmented[size + 1, size + 2] = 1.0
    exponential, _ = exponential_and_integral(augmented, 1.0)
    whole, columns = np.empty((size, size)), np.empty((size, 3))
    for i in range(size):
        for j in range(size):
            whole[i, j] = exponential[i, j]
        for j in range(3):
            columns[i, j] = exponential[i, size + j]
    return whole, columns


class SmoothStep(NamedTuple):
    """Coefficients of a step without events; see Cox & Matthews (2002), equations (26)–(29).

    Forces depend on position and velocity only, so the stages need these two of the state and not the state itself:
    ``rows_half`` and ``rows_whole`` give them after half a step and a whole one without forces, shape (2, q);
    ``input_half``, ``input_whole`` (2, 2) add the input and its change over the step, ``force_half`` (2,) half a step
    of force, and ``force_carried`` (2,) the force of the first half at the end of the second.
    """

    whole: Array
    input_columns: Array
    force_columns: Array
    rows_half: Array
    rows_whole: Array
    input_half: Array
    input_whole: Array
    force_half: Array
    force_carried: Array


@njit
def smooth_step_of(m: Mechanics, scaled: float) -> SmoothStep:
    """Coefficients for steps of a scaled length."""
    whole, whole_force = _coefficients(m.state_matrix, m.force_vector, scaled)
    half, half_force = _coefficients(m.state_matrix, m.force_vector, 0.5 * scaled)
    _, whole_input = _coefficients(m.state_matrix, m.input_vector, scaled)
    _, half_input = _coefficients(m.state_matrix, m.input_vector, 0.5 * scaled)
    size = len(m.force_vector)
    columns, rows, entering = np.empty((size, 3)), np.empty((2, size)), np.empty((size, 2))
    input_columns, force_half = np.empty((size, 2)), np.empty(size)
    for i in range(size):
        columns[i, 0] = whole_force[i, 0] - 3.0 * whole_force[i, 1] + 4.0 * whole_force[i, 2]
        columns[i, 1] = 2.0 * whole_force[i, 1] - 4.0 * whole_force[i, 2]
        columns[i, 2] = 4.0 * whole_force[i, 2] - whole_force[i, 1]
        rows[0, i] = m.position[i]
        rows[1, i] = m.velocity[i] / m.time_unit
        entering[i, 0] = half_input[i, 0]
        entering[i, 1] = 0.5 * half_input[i, 1]
        input_columns[i, 0] = whole_input[i, 0]
        input_columns[i, 1] = whole_input[i, 1]
        force_half[i] = half_force[i, 0]
    rows_half = rows @ half
    input_half = rows @ entering
    input_whole = rows @ input_columns
    # What the input does to the velocity at once.
    input_half[1, 0] += m.velocity_input
    input_half[1, 1] += 0.5 * m.velocity_input
    input_whole[1, 0] += m.velocity_input
    input_whole[1, 1] += m.velocity_input
    return SmoothStep(
        whole,
        input_columns,
        columns,
        rows_half,
        rows @ whole,
        input_half,
        input_whole,
        rows @ force_half,
        rows_half @ force_half,
    )


class HeldStep(NamedTuple):
    """Coefficients of a step of a body that sticks: exp(A h), and the columns of the input and of its change."""

    whole: Array
    input_columns: Array


@njit
def held_step_of(m: Mechanics, scaled: float, sticks: bool) -> HeldStep:
    """Coefficients for steps of a scaled length; empty where nothing holds the body.

    The force that holds it leaves of each derivative what does not change the velocity.
    """
    size = len(m.force_vector)
    if not sticks:
        return HeldStep(np.empty((0, 0)), np.empty((0, 2)))
    by_force, by_input = 0.0, 0.0
    by_state = np.zeros(size)
    for i in range(size):
        by_force += m.velocity[i] * m.force_vector[i]
        by_input += m.velocity[i] * m.input_vector[i]
        for j in range(size):
            by_state[j] += m.velocity[i] * m.state_matrix[i, j]
    matrix, vector = np.empty((size, size)), np.empty(size)
    for i in range(size):
        share = m.force_vector[i] / by_force
        vector[i] = m.input_vector[i] - share * by_input
        for j in range(size):
            matrix[i, j] = m.state_matrix[i, j] - share * by_state[j]
    whole, columns = _coefficients(matrix, vector, scaled)
    return HeldStep(whole, columns)


@kernel(inline="always")
def linear_step(c: SmoothStep, state: Array, first: float, last: float, following: Array) -> None:
    """Step of a system without forces: the state at its end."""
    size = len(state)
    for i in range(size):
        total = c.input_columns[i, 0] * first + c.input_columns[i, 1] * (last - first)
        for j in range(size):
            total += c.whole[i, j] * state[j]
        following[i] = total


@kernel(error_model="numpy", fastmath={"reassoc", "contract", "nsz"}, forceinline=True)
def smooth_step(
    m: Mechanics,
    c: SmoothStep,
    time: float,
    step: float,
    state: Array,
    memory: Array,
    first: float,
    last: float,
    direction: float,
    remembers: bool,
    remembered: Array,
    following: Array,
) -> tuple[float, float, float, float]:
    """Step without events: the state at its end, and in ``remembered`` the inner states.

    Returns
    -------
    halfway, speed, largest, doubt : float
        Position and velocity in the middle, largest force, and the difference of the two forces in the middle: it is of
        third order in the step, and so measures how well the step resolves the force.
    """
    whole, input_columns, force_columns = c.whole, c.input_columns, c.force_columns
    rows_half, rows_whole, input_half, input_whole = c.rows_half, c.rows_whole, c.input_half, c.input_whole
    force_half, force_carried = c.force_half, c.force_carried
    position_row, velocity_row, forces, inverse = m.position, m.velocity, m.forces, 1.0 / m.time_unit
    size = len(state)
    slope = last - first
    middle = first + 0.5 * slope
    origin, velocity = 0.0, m.velocity_input * first
    half_position = input_half[0, 0] * first + input_half[0, 1] * slope
    half_velocity = input_half[1, 0] * first + input_half[1, 1] * slope
    whole_position = input_whole[0, 0] * first + input_whole[0, 1] * slope
    whole_velocity = input_whole[1, 0] * first + input_whole[1, 1] * slope
    for i in range(size):
        value = state[i]
        origin += position_row[i] * value
        velocity += velocity_row[i] * inverse * value
        half_position += rows_half[0, i] * value
        half_velocity += rows_half[1, i] * value
        whole_position += rows_whole[0, i] * value
        whole_velocity += rows_whole[1, i] * value
    at_half, finish = time + 0.5 * step, time + step
    force_1 = force_at(forces, time, origin, velocity, first, memory, direction)
    position = half_position + force_half[0] * force_1
    halfway = half_velocity + force_half[1] * force_1
    if remembers:
        remember(forces, at_half, 0.5 * step, position - origin, memory, remembered)
    force_2 = force_at(forces, at_half, position, halfway, middle, remembered, direction)
    position = half_position + force_half[0] * force_2
    halfway = half_velocity + force_half[1] * force_2
    if remembers:
        remember(forces, at_half, 0.5 * step, position - origin, memory, remembered)
    force_3 = force_at(forces, at_half, position, halfway, middle, remembered, direction)
    middle_position = position
    change = 2.0 * force_3 - force_1
    position = whole_position + force_carried[0] * force_1 + force_half[0] * change
    velocity = whole_velocity + force_carried[1] * force_1 + force_half[1] * change
    if remembers:
        remember(forces, finish, step, position - origin, memory, remembered)
    force_4 = force_at(forces, finish, position, velocity, last, remembered, direction)
    both = force_2 + force_3
    ending = 0.0
    for i in range(size):
        total = input_columns[i, 0] * first + input_columns[i, 1] * slope
        total += force_columns[i, 0] * force_1
        total += force_columns[i, 1] * both
        total += force_columns[i, 2] * force_4
        for j in range(size):
            total += whole[i, j] * state[j]
        following[i] = total
        ending += position_row[i] * total
    if remembers:
        remember(forces, finish, step, ending - origin, memory, remembered)
    return middle_position, halfway, max(abs(force_1), abs(force_3)), abs(force_3 - force_2)
