"""Industrial controllers at the rate of the rows; each reads the true position through an encoder of its own."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .rigs import Array, Generator, Rig

# of row, reference (its value) and reading (y) to the command (u), not yet limited; the flag says that it was limited
Rule = Callable[[int, float, bool], float]


@dataclass(frozen=True)
class Loop:
    """A controller's kind, bandwidth (rad/s), shares that it is mistuned by, and its encoder's noise and step (y)."""

    kind: str
    bandwidth: float
    tuning: tuple[float, float, float]
    noise: float
    step: float

    @property
    def fast(self) -> float:
        """Bandwidth of what reacts fastest (rad/s)."""
        return self.bandwidth * (4.0 if self.kind.startswith("P position") else 2.6)


KINDS = (
    "P position, PI velocity cascade",
    "P position, PI velocity cascade with velocity feedforward",
    "PID with filtered derivative",
    "PD with feedforward",
    "lead-lag",
    "PI-P: PI of the position, P of the velocity",
)


def draw_loop(rng: Generator, rig: Rig) -> Loop:
    """Draw a controller that suits the machine; the encoder is still perfect."""
    kind = KINDS[int(rng.integers(len(KINDS)))]
    top = 0.075 if kind.startswith("P position") else 0.1
    bandwidth = float(np.exp(rng.uniform(np.log(0.03), np.log(top)))) / rig.period
    bandwidth = max(bandwidth, 0.65 * rig.slow_damping)
    if rig.order == 3:
        bandwidth = min(bandwidth, 0.08 * rig.damping[0])
    tuning = tuple(float(np.exp(rng.uniform(-0.18, 0.18))) for _ in range(3))
    return Loop(kind, bandwidth, (tuning[0], tuning[1], tuning[2]), 0.0, 0.0)


def _speed(period: float, corner: float) -> Callable[[float], float]:
    """Return a filtered difference of readings (y/s), with its corner in rad/s."""
    keep = float(np.exp(-corner * period))
    past: list[float | None] = [None]
    held = [0.0]

    def of(reading: float) -> float:
        before = past[0]
        past[0] = reading
        if before is not None:
            held[0] = keep * held[0] + (1.0 - keep) * (reading - before) / period
        return held[0]

    return of


def _cascade(rig: Rig, loop: Loop, reference: Array) -> Rule:
    """P of the position gives the velocity that a PI follows."""
    inner = 4.0 * loop.bandwidth
    proportional = max(inner - rig.slow_damping, 0.5 * inner) / rig.slow_gain * loop.tuning[0]
    integral, outer = inner / 5.0 * loop.tuning[1], loop.bandwidth * loop.tuning[2]
    speed, sums = _speed(rig.period, 6.0 * inner), [0.0]
    forward = np.gradient(reference, rig.period) * (0.8 if loop.kind.endswith("feedforward") else 0.0)

    def rule(row: int, reading: float, limited: bool) -> float:
        error = outer * (reference[row] - reading) + forward[row] - speed(reading)
        if not limited:
            sums[0] += integral * rig.period * error
        return float(proportional * (error + sums[0]))

    return rule


def _three_terms(rig: Rig, loop: Loop, reference: Array) -> Rule:
    """PID; or PI of the position with P of the velocity, which the reference does not kick."""
    w, a, b = loop.bandwidth, rig.slow_damping, rig.slow_gain
    derivative = max(2.6 * w - a, 0.2 * w) / b * loop.tuning[0]
    proportional, integral = 2.6 * w**2 / b * loop.tuning[1] * 0.8, 0.5 * w**3 / b * loop.tuning[2]
    speed, sums = _speed(rig.period, 12.0 * w), [0.0]
    kicked = loop.kind.startswith("PID")

    def rule(row: int, reading: float, limited: bool) -> float:
        error = reference[row] - reading
        rate = speed(error) if kicked else -speed(reading)
        if not limited:
            sums[0] += integral * rig.period * error
        return float(proportional * error + sums[0] + derivative * rate)

    return rule


def _forward(rig: Rig, loop: Loop, reference: Array) -> Rule:
    """PD with what the reference asks of the machine that its engineer had in mind."""
    w, a, b = loop.bandwidth, rig.slow_damping, rig.slow_gain
    proportional = 1.6 * w**2 / b * loop.tuning[0]
    derivative = max(2.2 * w - a, 0.2 * w) / b
    rate = np.gradient(reference, rig.period)
    wanted = (np.gradient(rate, rig.period) * loop.tuning[1] + a * loop.tuning[2] * rate) / b
    speed = _speed(rig.period, 10.0 * w)

    def rule(row: int, reading: float, limited: bool) -> float:
        error = reference[row] - reading
        return float(proportional * error + derivative * (rate[row] - speed(reading)) + wanted[row])

    return rule


def _lead_lag(rig: Rig, loop: Loop, reference: Array) -> Rule:
    """A lead around the crossover and a lag far below it, each by Tustin's rule."""
    w = loop.bandwidth * 1.3
    gain = w * np.hypot(w, rig.slow_damping) / rig.slow_gain / 3.2 * loop.tuning[0]
    pairs = ((w / 3.2 * loop.tuning[1], 3.2 * w), (w / 10.0 * loop.tuning[2], w / 40.0))
    scales = (3.2 * 3.2, 1.0)
    sections = []
    for (zero, pole), scale in zip(pairs, scales, strict=True):
        k = 2.0 / rig.period
        sections.append([scale * (k + zero) / (k + pole), scale * (zero - k) / (k + pole), (pole - k) / (k + pole)])
    memory = [[0.0, 0.0], [0.0, 0.0]]

    def rule(row: int, reading: float, limited: bool) -> float:
        value = float(reference[row] - reading)
        for (b0, b1, a1), past in zip(sections, memory, strict=True):
            made = b0 * value + b1 * past[0] - a1 * past[1]
            past[0], past[1] = value, made
            value = made
        return float(gain * value)

    return rule


def controller(
    rig: Rig, loop: Loop, reference: Array, seed: int, limit: float | None = None
) -> Callable[[int, float], float]:
    """Return what reads the position (y) of a row and puts out its command (u); ``reference`` has a value a row (y)."""
    makers = (_cascade, _cascade, _three_terms, _forward, _lead_lag, _three_terms)
    rule = makers[KINDS.index(loop.kind)](rig, loop, reference)
    noise = np.random.default_rng(seed).normal(0.0, 1.0, reference.size) * loop.noise
    most = rig.limit if limit is None else limit
    limited = [False]

    def put_out(row: int, position: float) -> float:
        reading = position + float(noise[row])
        if loop.step > 0.0:
            reading = round(reading / loop.step) * loop.step
        wanted = rule(row, reading, limited[0])
        limited[0] = abs(wanted) > most
        return min(max(wanted, -most), most)

    return put_out
