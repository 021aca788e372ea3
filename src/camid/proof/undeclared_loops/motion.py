"""Motion of a machine in its loop: Runge and Kutta's fourth order, stopped where a law changes its branch."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .rigs import Array, Rig
from .setup import Setup

State = tuple[float, float, float]
Controller = Callable[[int, float], float]
SUBSTEPS = 8


@dataclass(frozen=True)
class Motion:
    """A run: fine nodes (rows · substeps + 1) of position, speed and third state, and the rows' command and arrival.

    ``command`` is what the controller put out and ``arrived`` the mean over the row of what the actuator made of it,
    both in u and one for each row.
    """

    step: float
    substeps: int
    position: Array
    velocity: Array
    third: Array
    command: Array
    arrived: Array


class Machine:
    """A plant with what acts in it, at one moment; ``side`` is where it slides to, 0 where dry friction holds it."""

    __slots__ = ("guards", "level", "rig", "row_start", "setup", "side", "total", "wave")

    def __init__(self, rig: Rig, setup: Setup) -> None:
        self.rig, self.setup, self.side = rig, setup, 0.0
        self.level, self.row_start = 0.0, 0.0
        self.wave: Callable[[float], float] | None = None
        self.guards = list(setup.guards)
        if setup.hidden is not None:
            self.guards.append(lambda y, v: v)
        forces = list(setup.forces.values())
        self.total = forces[0] if len(forces) == 1 else None if not forces else _sum_of(forces)

    def drive(self, t: float, y: float, v: float, z: float) -> tuple[float, float]:
        """What drives the plant but for dry friction, and what arrives at it (u)."""
        u = self.level if self.wave is None else self.wave(t - self.row_start)
        net = u
        if self.total is not None:
            net -= self.total(t, y, v, u)
        if self.setup.hidden is not None:
            net -= self.setup.hidden.force(z)
        return net, u

    def slope(self, t: float, y: float, v: float, z: float) -> State:
        """Derivatives of position, speed and third state: the acceleration, or that of a hidden law."""
        net, u = self.drive(t, y, v, z)
        setup, rig = self.setup, self.rig
        if setup.friction is not None:
            net -= self.side * setup.friction(y, abs(v), u, self.side)
        if setup.gain is not None:
            net *= setup.gain(t)
        if len(rig.damping) == 2:
            return v, z, rig.gain * net - rig.damping[0] * z - rig.damping[1] * v
        damping = rig.damping[0] if setup.damping is None else rig.damping[0] * setup.damping(t)
        return v, rig.gain * net - damping * v, 0.0 if setup.hidden is None else setup.hidden.rate(y, v, z)

    def rk4(self, t: float, s: State, h: float) -> State:
        """One step of ``h`` (s)."""
        y, v, z = s
        g, half = self.slope, 0.5 * h
        a, b, c = g(t, y, v, z)
        d, e, f = g(t + half, y + half * a, v + half * b, z + half * c)
        i, j, k = g(t + half, y + half * d, v + half * e, z + half * f)
        m, n, o = g(t + h, y + h * i, v + h * j, z + h * k)
        w = h / 6.0
        return y + w * (a + 2 * (d + i) + m), v + w * (b + 2 * (e + j) + n), z + w * (c + 2 * (f + k) + o)

    def holding(self, t: float, s: State) -> float:
        """By how much the drive exceeds what friction can hold at rest, with the drive's sign; 0 where it holds."""
        assert self.setup.friction is not None
        net, u = self.drive(t, s[0], 0.0, s[2])
        side = 1.0 if net > 0.0 else -1.0
        excess = abs(net) - self.setup.friction(s[0], 0.0, u, side)
        return side * excess if excess > 0.0 else 0.0

    def release(self, t: float, s: State, h: float) -> float:
        """Time within ``h`` (s) at which friction lets go; ``h`` where it holds; sets the side."""
        if self.holding(t, s) != 0.0:
            self.side = 1.0 if self.holding(t, s) > 0.0 else -1.0
            return 0.0
        if self.wave is None and self.total is None:
            return h
        if self.holding(t + h, s) == 0.0:
            return h
        low, high = 0.0, h
        for _ in range(30):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.holding(t + middle, s) == 0.0 else (low, middle)
        self.side = 1.0 if self.holding(t + high, s) > 0.0 else -1.0
        return high

    def crossing(self, t: float, s: State, h: float, guard: Callable[[float, float], float], end: float) -> float:
        """Time within ``h`` (s) at which a guard changes its sign (Illinois), a little late; ``end`` is its last."""
        low, high, below, above = 0.0, h, guard(s[0], s[1]), end
        for _ in range(40):
            middle = (low * above - high * below) / (above - below)
            new = self.rk4(t, s, middle)
            value = guard(new[0], new[1])
            if value * above > 0.0:
                high, above, below = middle, value, 0.5 * below
            else:
                low, below, above = middle, value, 0.5 * above
            if high - low < 1e-9 * h or value == 0.0 or abs(below - above) == 0.0:
                break
        return high

    def advance(self, t: float, s: State, h: float) -> State:
        """Advance by ``h`` (s), step by step from one change of a branch to the next."""
        if self.setup.friction is None and not self.guards:
            return self.rk4(t, s, h)
        left = h
        for _ in range(40):
            if left <= 1e-9 * h:
                break
            if self.setup.friction is not None and self.side == 0.0:
                wait = self.release(t, s, left)
                t, left = t + wait, left - wait
                if left <= 1e-9 * h:
                    break
            s, used = self.slide(t, s, left)
            t, left = t + used, left - used
        return s

    def slide(self, t: float, s: State, h: float) -> tuple[State, float]:
        """Advance at most to the first change of a branch; returns the state and the time (s) that it took."""
        new = self.rk4(t, s, h)
        first, stops = h, False
        if self.setup.friction is not None and new[1] * self.side < 0.0:
            if s[1] * self.side <= 0.0:
                self.side = 0.0
                return (s[0], 0.0, s[2]), h
            first, stops = self.crossing(t, s, h, lambda y, v: v, new[1]), True
        for guard in self.guards:
            end = guard(new[0], new[1])
            if guard(s[0], s[1]) * end < 0.0:
                when = self.crossing(t, s, h, guard, end)
                if when < first:
                    first, stops = when, False
        if first < h or stops:
            new = self.rk4(t, s, first)
        if stops:
            new, self.side = (new[0], 0.0, new[2]), 0.0
        return new, first


def _sum_of(forces: list[Callable[[float, float, float, float], float]]) -> Callable[..., float]:
    def total(t: float, y: float, v: float, u: float) -> float:
        return sum(force(t, y, v, u) for force in forces)

    return total


def run(rig: Rig, setup: Setup, controller: Controller, rows: int, start: int = 0, substeps: int = SUBSTEPS) -> Motion:
    """Run a machine from rest at zero for ``rows`` rows, the first of them at the time ``start`` · period (s)."""
    machine, step = Machine(rig, setup), rig.period / substeps
    curves = [make() for make in setup.curves]
    nodes = np.zeros((rows * substeps + 1, 3))
    command, arrived = np.zeros(rows), np.zeros(rows)
    fractions = [(2 * j + 1) / 16 * rig.period for j in range(8)]
    state: State = (0.0, 0.0, 0.0)
    last, corner = 0.0, -np.inf if setup.onset is None else setup.onset
    blow = -1 if setup.blow is None else round((setup.blow[0] / rig.period - start) * substeps)
    for row in range(rows):
        command[row] = wanted = controller(row, state[0])
        for curve in curves:
            wanted = curve(wanted)
        machine.level = arrived[row] = wanted
        begin = machine.row_start = (row + start) * rig.period
        if setup.approach is not None:
            machine.wave = _wave(setup.approach, last, wanted)
            arrived[row] = sum(machine.wave(time) for time in fractions) / 8
            corner = begin + setup.corner(last, wanted) if setup.corner is not None else corner
            last = machine.wave(rig.period)
        for part in range(substeps):
            if row * substeps + part == blow and setup.blow is not None:
                kick = rig.gain * setup.blow[1]
                state = (state[0], state[1] + kick, 0.0) if rig.order == 2 else (*state[:2], state[2] + kick)
                machine.side = 1.0 if state[1] > 0.0 else -1.0
            state = _part(machine, begin + part * step, state, step, corner)
            nodes[row * substeps + part + 1] = state
        if not abs(state[0]) < 1e12:
            nodes[row * substeps + 1 :] = np.nan
            break
    return Motion(step, substeps, nodes[:, 0], nodes[:, 1], nodes[:, 2], command, arrived)


def _wave(approach: Callable[[float, float, float], float], last: float, wanted: float) -> Callable[[float], float]:
    return lambda time: approach(last, wanted, time)


def _part(machine: Machine, t: float, state: State, h: float, corner: float) -> State:
    """Advance by ``h`` (s), in two parts where what arrives has a corner in between (s)."""
    first = corner - t
    if not 0.0 < first < h:
        return machine.advance(t, state, h)
    # what sets in at the corner is not there at the end of the first part
    return machine.advance(corner, machine.advance(t, state, first * (1.0 - 1e-9)), h - first)
