"""What flows out of a storage and over its edge at a level, and the level that belongs to a flow, as compiled code."""

from __future__ import annotations

from math import sqrt

from camid.chain.plant import TransferFunction
from camid.compiled import njit

# Damping ratio from which two poles are those of two storages; fits wander about the double pole.
LEAST_DAMPING = 0.8
# Steps to the level that belongs to an outflow.
NEWTON_STEPS = 4


def time_constants(plant: TransferFunction) -> list[float]:
    """Time constants in s of the storages that a plant consists of, the shortest first; none where it does not."""
    monic = plant.monic
    if len(monic.numerator) != 1 or monic.order not in (1, 2) or monic.denominator[-1] <= 0.0:
        return []
    if monic.order == 1:
        return [1.0 / monic.denominator[1]]
    rate, square = 0.5 * monic.denominator[1], monic.denominator[2]
    if rate < LEAST_DAMPING * sqrt(square):
        return []
    spread = sqrt(max(rate * rate - square, 0.0))
    return [1.0 / (rate + spread), (rate + spread) / square]


@njit(error_model="numpy")
def outflow(level: float, excess: float, trickle: float) -> tuple[float, float]:
    """Outflow g of a storage and its slope: in proportion to the level, and with its square root ``excess`` times."""
    square, smoothed = level * level, level * level + trickle * trickle
    root = sqrt(sqrt(smoothed))
    return level + excess * level / root, 1.0 + excess / root * (1.0 - 0.5 * square / smoothed)


@njit(error_model="numpy")
def level_of(flow: float, excess: float, trickle: float) -> float:
    """Level ≥ 0 of a storage that has this outflow."""
    # The outflow grows ever more slowly, so that Newton's steps from below do not overshoot.
    root = 0.5 * (sqrt(excess * excess + 4.0 * flow) - excess)
    level = root * root
    for _ in range(NEWTON_STEPS):
        given, slope = outflow(level, excess, trickle)
        level += (flow - given) / slope
    return level


@njit(error_model="numpy")
def spilt(beyond: float, width: float) -> tuple[float, float]:
    """What comes over an edge, q, and its slope, at a level beyond its beginning."""
    if beyond > width:
        return beyond - 0.5 * width, 1.0
    return 0.5 * beyond * beyond / width, beyond / width


@njit(error_model="numpy")
def beyond_edge(known: float, passed: float, width: float) -> float:
    """Level z beyond an edge where z + ``passed`` · q(z) is known."""
    if passed <= 0.0:
        return known
    beyond = (sqrt(1.0 + 2.0 * passed * known / width) - 1.0) * width / passed
    return beyond if beyond <= width else (known + 0.5 * passed * width) / (1.0 + passed)
