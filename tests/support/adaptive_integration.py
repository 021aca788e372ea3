"""Motions with forces, by scipy's adaptive integrator with events: nothing shared with the engine.

The state is the phase vector of z = u/A, then the flexible mode behind the plant where there is one, the integral
of what the sensor sees, and the inner state of a hysteresis. The input is a list of straight pieces (t0, t1, u0, u1),
and what an actuator makes of them is again such a list, so that no kink lies within a piece. Dry friction has three
modes (slip either way, and stuck), each integrated to the event that ends it.
"""

# The slopes and events of a piece are closures over it and are used up before the next begins.
# ruff: noqa: B023, PLR0912, PLR0915

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


def pieces_of(signal, period, hold, start=0.0, past=2):
    """Straight pieces of a held or joined input, which stays constant past its end."""
    u = np.append(np.asarray(signal, float), [signal[-1]] * past)
    following = u if hold == "zoh" else np.append(u[1:], u[-1])
    return [(start + k * period, start + (k + 1) * period, u[k], following[k]) for k in range(len(u))]


def split(pieces, levels):
    """The same pieces, cut where they cross one of the levels."""
    result = []
    for t0, t1, u0, u1 in pieces:
        shares = sorted(s for s in ((x - u0) / (u1 - u0) for x in levels) if 1e-9 < s < 1 - 1e-9) if u0 != u1 else []
        cuts = [0.0, *shares, 1.0]
        result += [
            (t0 + (t1 - t0) * a, t0 + (t1 - t0) * b, u0 + (u1 - u0) * a, u0 + (u1 - u0) * b) for a, b in pairwise(cuts)
        ]
    return result


def mapped(pieces, levels, function):
    """Pieces behind a static map with kinks at the levels."""
    return [
        (t0, t1, function(u0, 0.5 * (u0 + u1)), function(u1, 0.5 * (u0 + u1)))
        for t0, t1, u0, u1 in split(pieces, levels)
    ]


def play(pieces, half_width):
    """Pieces behind backlash."""
    result, value = [], 0.0
    for piece in pieces:
        for t0, t1, u0, u1 in split([piece], [value - half_width, value + half_width]):
            first = min(max(value, u0 - half_width), u0 + half_width)
            value = min(max(first, u1 - half_width), u1 + half_width)
            result.append((t0, t1, first, value))
    return result


def follow(pieces, rate):
    """Pieces behind a rate limit."""
    result, value = [], 0.0
    for t0, t1, u0, u1 in pieces:
        slope, now, distance = (u1 - u0) / (t1 - t0), t0, u0 - value
        if distance != 0.0:
            speed = rate * np.sign(distance)
            meets = t0 + distance / (speed - slope) if (speed - slope) * distance > 0.0 else np.inf
            now = min(meets, t1)
            if now > t0:
                result.append((t0, now, value, value + speed * (now - t0)))
                value = result[-1][3]
        if now < t1:
            following = value + float(np.clip(slope, -rate, rate)) * (t1 - now)
            result.append((now, t1, value, following))
            value = following
    return result


@dataclass
class Reference:
    """A plant with forces.

    ``force(t, y, v, u, m)`` acts against the input, ``level(t, y, speed)`` against the motion; ``kinks`` are functions
    (t, y, v) at whose zeros the force has a kink; ``memory(v, m)`` is the rate of an inner state; ``times`` are those
    at which the force jumps; ``impulses`` are (time, size); ``lag`` is a time constant before the plant and ``mode`` a
    pair (frequency, damping) behind it; ``tolerance`` is the relative one of a step.
    """

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    force: object = None
    level: object = None
    kinks: tuple = ()
    memory: object = None
    times: tuple[float, ...] = ()
    impulses: tuple = ()
    lag: float = 0.0
    mode: tuple[float, float] | None = None
    tolerance: float = 1e-10
    solutions: list = field(default_factory=list)

    def __post_init__(self):
        lead = self.denominator[0]
        self.a = np.asarray(self.denominator[1:], float) / lead
        self.n = len(self.a)
        self.row = np.zeros(self.n)
        self.row[self.n - len(self.numerator) :] = np.asarray(self.numerator, float) / lead
        self.direct = self.row[0]  # what a force does to the velocity at once: not zero with one pole more than zeros
        self.gain = next(b for b in self.numerator if b != 0.0) / lead

    def motion(self, t, x, u, mode):
        """Position, velocity and acceleration but for the force."""
        z = x[: self.n]
        top = u - self.a @ z
        rate = np.concatenate([[top], z[:-1]])
        return self.row @ z, self.row @ rate, rate

    def total(self, t, x, u, mode):
        """Force along the input."""
        y, v, _ = self.motion(t, x, u, mode)
        m = x[-1]
        along = np.sign(self.gain)
        if self.direct:
            return self._implicit(t, y, v, u, m)
        total = -self.force(t, y, v, u, m) if self.force else 0.0
        if self.level and mode != 0:
            total -= along * mode * self.level(t, y, max(mode * v, 0.0))
        return total

    def _implicit(self, t, y, free, u, m):
        """Force that agrees with the velocity it leaves, v = free + direct · force."""
        b = self.direct

        def wanted(v):
            total = -self.force(t, y, v, u, m) if self.force else 0.0
            return total - (np.sign(b) * np.sign(v) * self.level(t, y, abs(v)) if self.level else 0.0)

        def error(v):
            return v - free - b * wanted(v)

        if self.level and abs(free + b * (wanted(0.0))) <= abs(b) * self.level(t, y, 0.0):
            return -free / b
        low, high = (0.0, free) if free > 0.0 else (free, 0.0)
        low, high = min(low, free - 1e-12), max(high, free + 1e-12)
        while error(low) > 0.0:
            low -= 1.0 + abs(low)
        while error(high) < 0.0:
            high += 1.0 + abs(high)
        return (brentq(error, low, high, xtol=1e-14, rtol=1e-14) - free) / b

    def velocity(self, t, x, u, mode):
        """Velocity with the force."""
        v = self.motion(t, x, u, mode)[1]
        return v + self.direct * self.total(t, x, u, mode) if self.direct else v

    def holding(self, t, x, u):
        """Force along the input that friction has to make up for at rest, where two poles more than zeros are."""
        y, _, rate = self.motion(t, x, u, 0)
        others = -self.force(t, y, 0.0, u, x[-1]) if self.force else 0.0
        rate = rate.copy()
        rate[0] += others
        acceleration = self.row @ np.concatenate([[-self.a @ rate], rate[:-1]]) + self._second(0.0)
        return acceleration / self.gain

    def _second(self, slope):
        """Contribution of the input's slope to the acceleration: none with two poles more than zeros."""
        return self.direct * slope

    def run(self, pieces, state=None, begin=None):  # noqa: C901 - one loop over the events of a motion
        """Integrate over the pieces from rest or from a phase vector."""
        size = self.n + (1 if self.lag else 0) + (2 if self.mode else 0) + 2
        x = np.zeros(size)
        if state is not None:
            x[: self.n] = state
        if self.lag:
            lag_at = self.n
        mode_at = self.n + (1 if self.lag else 0)
        cuts = sorted({*self.times, *(t for t, _ in self.impulses)})
        signs = [1.0 if k(pieces[0][0], 0.0, 0.0) >= 0.0 else -1.0 for k in self.kinks]
        friction = 0
        self.begin = pieces[0][0]
        queue = []
        for t0, t1, u0, u1 in pieces:
            points = [t0, *(c for c in cuts if t0 < c < t1), t1]
            queue += [
                (a, b, u0 + (u1 - u0) * (a - t0) / (t1 - t0), u0 + (u1 - u0) * (b - t0) / (t1 - t0))
                for a, b in pairwise(points)
            ]
        scale = np.full(size, 1e-13)
        for t0, t1, u0, u1 in queue:
            for when, amount in self.impulses:
                if when == t0:
                    x[0] += amount
                    friction = 0
            now, begins = t0, False
            # Just inside, so that a force which jumps at the ends of the piece is taken from within.
            inside = (t0 + 1e-9 * (t1 - t0), t1 - 1e-9 * (t1 - t0))
            while now < t1:

                def command(t):
                    return u0 + (u1 - u0) * (t - t0) / (t1 - t0)

                def entering(t, x):
                    return x[lag_at] if self.lag else command(t)

                if self.level and not self.direct and not begins:
                    v = self.velocity(now, x, entering(now, x), 0)
                    if friction == 0 or abs(v) < 1e-12:
                        hold = self.holding(now, x, entering(now, x))
                        rest = self.level(now, self.row @ x[: self.n], 0.0)
                        if abs(v) > 1e-12:
                            friction = int(np.sign(v))
                        elif abs(hold) > rest * (1 + 1e-9):
                            friction = int(np.sign(hold * self.gain))
                        else:
                            friction = 0
                begins = False
                stuck = bool(self.level) and not self.direct and friction == 0

                def slope(t, x, stuck=stuck, friction=friction):
                    t = min(max(t, inside[0]), inside[1])
                    u = entering(t, x)
                    y, v, rate = self.motion(t, x, u, friction)
                    force = -self.holding(t, x, u) + self.total(t, x, u, 0) if stuck else self.total(t, x, u, friction)
                    rate[0] += force
                    result = np.zeros(size)
                    result[: self.n] = rate
                    seen = y
                    if self.lag:
                        result[lag_at] = (command(t) - x[lag_at]) / self.lag
                    if self.mode:
                        w, damping = self.mode
                        result[mode_at] = x[mode_at + 1]
                        result[mode_at + 1] = w * w * (y - x[mode_at]) - 2.0 * damping * w * x[mode_at + 1]
                        seen = x[mode_at]
                    result[-2] = seen
                    if self.memory:
                        result[-1] = self.memory(v + self.direct * force, x[-1])
                    return result

                events = []
                if stuck:
                    for side in (1.0, -1.0):

                        def slips(t, x, side=side):
                            rest = self.level(t, self.row @ x[: self.n], 0.0)
                            return side * self.holding(t, x, entering(t, x)) - rest

                        slips.direction, slips.terminal = 1.0, True
                        events.append(slips)
                elif self.level and not self.direct:

                    def reverses(t, x):
                        return self.motion(t, x, entering(t, x), 0)[1]

                    reverses.direction, reverses.terminal = -float(friction), True
                    events.append(reverses)
                first_kink = len(events)
                for kink, sign in zip(self.kinks, signs, strict=True):

                    def crosses(t, x, kink=kink):
                        y, v, _ = self.motion(t, x, entering(t, x), 0)
                        return kink(t, y, v)

                    crosses.direction, crosses.terminal = -sign, True
                    events.append(crosses)
                found = solve_ivp(
                    slope,
                    (now, t1),
                    x,
                    method="DOP853",
                    rtol=self.tolerance,
                    atol=scale,
                    events=events or None,
                    dense_output=True,
                )
                if not found.success:
                    raise RuntimeError(found.message)
                self.solutions.append((now, found.t[-1], found.sol))
                now, x = found.t[-1], found.y[:, -1].copy()
                if found.status == 1:
                    which = next(i for i, times in enumerate(found.t_events) if len(times))
                    if which >= first_kink:
                        signs[which - first_kink] *= -1.0
                    elif stuck:
                        friction = int(np.sign(self.gain)) * (1 if which == 0 else -1)
                        begins = True
                    else:
                        # At rest exactly; the next turn says whether it sticks.
                        v = self.motion(now, x, entering(now, x), 0)[1]
                        x[0] -= v / self.row[1] if self.n > 1 and self.row[1] else 0.0
                        friction = 0
                    if t1 - now < 1e-13 * max(abs(t1), t1 - t0):
                        break
            self.final = x
        self.edges = np.array([s[0] for s in self.solutions])
        return self

    def _at(self, times, pick):
        times = np.asarray(times, float)
        result = np.empty(times.size)
        index = np.searchsorted(self.edges, times.ravel(), side="right") - 1
        for i in range(-1, len(self.solutions)):
            rows = index == i
            if not rows.any():
                continue
            if i < 0:
                result[rows] = pick(self.solutions[0][2](self.edges[0])[:, None], times.ravel()[rows] - self.edges[0])
            else:
                result[rows] = pick(self.solutions[i][2](times.ravel()[rows]), np.zeros(rows.sum()))
        return result.reshape(times.shape)

    def seen(self, times):
        """What the sensor looks at, at any times."""
        at = self.n + (1 if self.lag else 0)
        return self._at(
            times, lambda x, before: x[at] + 0 * before if self.mode else self.row @ x[: self.n] + 0 * before
        )

    def integral(self, times):
        """Its integral."""
        at = self.n + (1 if self.lag else 0)

        def pick(x, before):
            seen = x[at] if self.mode else self.row @ x[: self.n]
            return x[-2] + seen * before

        return self._at(times, pick)

    def mean(self, start, end):
        """Means over exposures."""
        if np.all(end == start):
            return self.seen(end)
        return (self.integral(end) - self.integral(start)) / (end - start)
