"""What the user of a rig believes: the simulation without what is concealed, with coefficients that are off."""

from typing import Any

import numpy as np

from .excitations import Generator
from .rigs import Rig, rounded

LARGEST_ERROR = 0.2  # relative, of a coefficient


def _off(rng: Generator, value: float, largest: float) -> float:
    """Return a coefficient that is wrong by up to a share of itself, as somebody would write it down."""
    return rounded(value * (1.0 + float(rng.uniform(-0.95 * largest, 0.95 * largest))), 4)


def _transfer_function(rng: Generator, rig: Rig) -> dict[str, list[float]]:
    """Return a believed transfer function; a free decay's numerator is exact: it gives forces their unit."""
    largest = 0.06 if "two masses" in rig.traits else LARGEST_ERROR
    for _ in range(50):
        denominator = [value if not k or value == 0.0 else _off(rng, value, largest)
                       for k, value in enumerate(rig.denominator)]  # fmt: skip
        numerator = [_off(rng, value, largest) if rig.driven else value for value in rig.numerator]
        true_damping = -np.max(np.roots(rig.denominator).real)
        poles = np.roots(denominator)
        if rig.integrates or -np.max(poles.real) > 0.3 * true_damping:
            break
    return {"numerator": numerator, "denominator": denominator}


def _plant(rng: Generator, rig: Rig) -> dict[str, Any]:
    """Return the believed plant."""
    if rig.pendulum is None:
        return {"transfer_function": _transfer_function(rng, rig)}
    frequency, damping, gain, _ = rig.pendulum
    plant = {"natural_frequency": _off(rng, frequency, 0.1), "damping": _off(rng, damping, LARGEST_ERROR), "rest": 0.0}
    if rig.driven:
        plant["gain"] = _off(rng, gain, LARGEST_ERROR)
    return {"pendulum": plant}


def believed(rng: Generator, rig: Rig, bias_known: bool, spectrum: tuple[float, ...] = ()) -> dict[str, Any]:
    """Return the content of the user's simulation; ``spectrum`` is that of coloured noise which the user knows."""
    sensor: dict[str, Any] = {"column": "y", "kind": rig.kind}
    if rig.kind == "camera" and (rig.exposure != rig.period or rng.random() < 0.5):
        sensor["exposure"] = rig.exposure
    if rig.latency > 0.0:
        sensor["latency"] = rig.latency
    if rig.unit is not None:
        sensor["unit"] = rig.unit
    if rig.offset_known and rig.pendulum is None and rig.controller is None:
        sensor["offset"] = rig.offset
    inlet: dict[str, Any] | None = None
    if rig.driven:
        inlet = {"column": "u", "hold": "foh" if rig.straight else "zoh"}
        if bias_known and rig.integrates and rig.controller is None:
            inlet["bias"] = 0.0
    simulation: dict[str, Any] = {"schema": 1, "time": {"column": "t"}, "input": inlet, "plant": _plant(rng, rig)}
    if rig.controller is not None:
        position_gain, velocity_gain, limit = rig.controller
        simulation["controller"] = {
            "reference": "r",
            "position_gain": position_gain,
            "velocity_gain": velocity_gain,
            "limit": limit,
        }
    known = [{"id": "coloured-noise", "parameters": {"spectrum": list(spectrum)}}] if spectrum else []
    return {
        **simulation,
        "sensor": sensor,
        "initial_state": "zero" if rig.initial is None else "estimate",
        "effects": known,
    }
