"""Rigs: a plant, its input, its sensor, and what the user declares of them rightly."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .excitations import Generator

Array = np.ndarray[Any, np.dtype[np.float64]]
Matrices = tuple[Array, Array, Array, Array]


@dataclass(frozen=True)
class Rig:
    """A rig without anything concealed. Units: seconds, and those of input u and output y that the plant has.

    ``pace`` is the time (s) in which the rig reacts. ``initial`` is the output and its rate (y, y/s) at the first
    sample less ``lead`` periods; None stands for rest. ``offset`` (y) is what the sensor reads at rest, and ``cells``
    the number of cell units in a unit of y. A pendulum has ``pendulum``: natural frequency (rad/s), damping, gain
    (rad/u), rest (rad).
    """

    name: str
    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    pace: float
    period: float
    samples: int
    largest_input: float
    start: float = 0.0
    straight: bool = False
    kind: str = "instant"
    exposure: float = 0.0
    latency: float = 0.0
    offset: float = 0.0
    offset_known: bool = False
    initial: tuple[float, float] | None = None
    driven: bool = True
    one_sided: bool = False
    pendulum: tuple[float, float, float, float] | None = None
    controller: tuple[float, float, float] | None = None
    unit: str | None = None
    cells: float = 1.0
    traits: frozenset[str] = field(default_factory=frozenset)

    lead: int = 8

    @property
    def order(self) -> int:
        """Number of poles."""
        return len(self.denominator) - 1

    @property
    def integrates(self) -> bool:
        """Whether a constant input moves the output on and on."""
        return self.denominator[-1] == 0.0

    @property
    def stiffness(self) -> float:
        """Input that holds the output at one (u/y)."""
        return 0.0 if self.integrates else self.denominator[-1] / self.numerator[-1]

    def matrices(self) -> tuple[Matrices, float]:
        """Return A, B, C and C A of the controllable form, and the share of the input in the rate (y/s/u)."""
        if self.pendulum is not None:
            frequency, damping, gain, _ = self.pendulum
            system = np.array([[0.0, 1.0], [0.0, -2.0 * damping * frequency]])
            outlet = np.array([1.0, 0.0])
            return (system, np.array([0.0, gain * frequency**2]), outlet, outlet @ system), 0.0
        order = self.order
        system = np.zeros((order, order))
        system[:-1, 1:] = np.eye(order - 1)
        system[-1] = -np.array(self.denominator[:0:-1])
        inlet = np.zeros(order)
        inlet[-1] = 1.0
        outlet = np.zeros(order)
        outlet[: len(self.numerator)] = self.numerator[::-1]
        return (system, inlet, outlet, outlet @ system), float(outlet @ inlet)

    def state(self) -> Array:
        """Return the state before the first sample."""
        state = np.zeros(self.order)
        if self.initial is not None:
            scale = 1.0 if self.pendulum is not None else self.numerator[-1]
            state[: min(self.order, 2)] = np.array(self.initial)[: self.order] / scale
        return state

    def coefficients(self) -> list[tuple[str, int, float]]:
        """Return what a fit re-estimates: group, index, value."""
        if self.pendulum is not None:
            found = [("pendulum", i, value) for i, value in enumerate(self.pendulum)]
            return found if self.driven else [found[0], found[1], found[3]]
        found = [("denominator", i, value) for i, value in enumerate(self.denominator) if i and value != 0.0]
        if self.driven:
            found = [("numerator", i, value) for i, value in enumerate(self.numerator) if value != 0.0] + found
        return found

    def changed(self, group: str, index: int, value: float) -> "Rig":
        """Return the rig with one other coefficient."""
        values = list(getattr(self, group))
        values[index] = value
        changes: dict[str, Any] = {group: tuple(values)}
        return replace(self, **changes)


def rounded(value: float, digits: int = 3) -> float:
    """Return a number rounded to significant digits."""
    return float(f"{value:.{digits - 1}e}")


def _second_order(rng: Generator, low: float, high: float, output: float, force: float) -> dict[str, Any]:
    """Return the plant of a mass on a spring with a damping ratio between two numbers."""
    frequency = float(np.exp(rng.uniform(np.log(1.0), np.log(60.0))))
    damping = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    gain = output / force * float(rng.uniform(0.5, 1.5)) * min(1.0, 4.0 * damping)
    return {
        "numerator": (gain * frequency**2,),
        "denominator": (1.0, 2.0 * damping * frequency, frequency**2),
        "pace": 1.0 / frequency,
    }


def _two_masses(rng: Generator, output: float, force: float) -> dict[str, Any]:
    """Return two masses on a spring to the ground and one between them, pushed and seen at the first."""
    frequency = float(np.exp(rng.uniform(np.log(2.0), np.log(30.0))))
    first, second = 1.0, float(rng.uniform(0.2, 0.6))
    ground, coupling = frequency**2, frequency**2 * float(rng.uniform(1.0, 4.0))
    loss, coupling_loss = frequency * float(rng.uniform(0.05, 0.3)), frequency * float(rng.uniform(0.02, 0.1))
    near = np.array([first, loss + coupling_loss, ground + coupling])
    far = np.array([second, coupling_loss, coupling])
    between = np.array([coupling_loss, coupling])
    denominator: Array = np.polysub(np.polymul(near, far), np.polymul(between, between))
    gain = output / force * ground * 0.5
    lead = denominator[0]
    return {
        "numerator": tuple(float(v) for v in gain * far / lead),
        "denominator": tuple(float(v) for v in denominator / lead),
        "pace": 1.0 / frequency,
        "traits": frozenset({"two masses"}),
    }


NAMES = (
    *("spring carriage",) * 5,
    *("damped stage",) * 3,
    *("motor position",) * 3,
    *("heater",) * 2,
    *("tank",) * 2,
    *("two masses",) * 2,
    *("pendulum",) * 2,
    *("swinging pendulum",),
    *("servo",) * 2,
    *("free decay",) * 2,
)


def _plant(rng: Generator, name: str, output: float, force: float) -> dict[str, Any]:
    """Return the plant of a rig of that name for typical sizes of output (y) and input (u)."""
    if name in {"spring carriage", "free decay"}:
        low, high = (0.004, 0.03) if name == "free decay" else (0.03, 0.35)
        return _second_order(rng, low, high, output, force)
    if name == "damped stage":
        return _second_order(rng, 0.6, 2.0, output, force)
    if name == "two masses":
        return _two_masses(rng, output, force)
    if name in {"motor position", "servo"}:
        constant = float(np.exp(rng.uniform(np.log(0.05), np.log(1.0))))
        return {
            "numerator": (output / force / constant**2 * float(rng.uniform(0.3, 0.8)),),
            "denominator": (1.0, 1.0 / constant, 0.0),
            "pace": constant,
        }
    if name in {"heater", "tank"}:
        constant = float(np.exp(rng.uniform(np.log(0.5), np.log(50.0))))
        gain = output / force * float(rng.uniform(0.7, 1.5))
        return {"numerator": (gain / constant,), "denominator": (1.0, 1.0 / constant), "pace": constant}
    frequency = float(rng.uniform(2.0, 8.0))
    free = name == "swinging pendulum"
    damping = float(np.exp(rng.uniform(np.log(0.004 if free else 0.02), np.log(0.02 if free else 0.15))))
    gain = 1.0 if free else float(rng.uniform(0.1, 0.3)) / force
    return {
        "numerator": (gain * frequency**2,),
        "denominator": (1.0, 2.0 * damping * frequency, frequency**2),
        "pendulum": (frequency, damping, gain, float(rng.uniform(-0.1, 0.1))),
        "pace": 1.0 / frequency,
    }


def _sensor(rng: Generator, name: str, period: float) -> dict[str, Any]:
    """Return an instant sensor, or a camera with a rightly declared exposure and latency (s)."""
    if name == "servo" or rng.random() < 0.4:
        latency = rounded(period * float(rng.uniform(0.2, 1.5))) if name != "servo" and rng.random() < 0.2 else 0.0
        return {"kind": "instant", "latency": latency}
    share = float(rng.choice([1.0, 0.75, 0.5, 0.25]))
    latency = rounded(period * float(rng.uniform(0.1, 2.0))) if rng.random() < 0.3 else 0.0
    return {"kind": "camera", "exposure": share * period, "latency": latency}


# unit of the cells, cells in a unit of the plant, typical size of the output in the plant's unit
SCALES: tuple[tuple[str | None, float, float], ...] = (
    (None, 1.0, 150.0),  # pixels
    (None, 1.0, 30.0),  # degrees, or kelvins
    (None, 1.0, 5.0),  # millimetres, or volts
    (None, 1.0, 0.08),  # metres, or radians
    ("um", 1e6, 4e-4),
    ("mm", 1e3, 0.02),
)


def draw_rig(rng: Generator, name: str) -> Rig:
    """Draw a rig of that name."""
    unit, cells, output = SCALES[int(rng.integers(len(SCALES)))]
    if "pendulum" in name or name == "servo":
        unit, cells = None, 1.0
    force = float(rng.choice([1.0, 5.0, 12.0, 40.0]))
    plant = _plant(rng, name, output, force)
    free = name in {"free decay", "swinging pendulum"}
    samples = int(rng.integers(1200, 2501))
    pace = plant["pace"]
    period = rounded(pace * float(np.exp(rng.uniform(np.log(0.08), np.log(0.4)))), 2)
    if name == "servo":
        period = rounded(pace * float(rng.uniform(0.01, 0.03)), 2)
    if free:
        # the decay fills the recording, whatever the damping
        damping = plant["denominator"][1] * pace / 2.0
        period = rounded(pace * float(np.clip(rng.uniform(2.0, 5.0) / damping / samples, 0.04, 0.4)), 2)
    rig = Rig(
        name=name, period=period, samples=samples, largest_input=force, driven=not free, **plant,
        **_sensor(rng, name, period),
    )  # fmt: skip
    rig = replace(rig, unit=unit, cells=cells, one_sided=name == "tank")
    if rng.random() < 0.15:
        rig = replace(rig, start=rounded(float(rng.uniform(1.0, 10.0)), 2))
    if free:
        swing = float(rng.uniform(0.5, 1.6)) if rig.pendulum is not None else output
        rig = replace(rig, initial=(swing, swing / pace * float(rng.uniform(-0.5, 0.5))))
    elif rig.order == 2 and name not in {"servo", "motor position"} and rng.random() < 0.35:
        size = 0.15 if rig.pendulum is not None else output
        rig = replace(rig, initial=(size * float(rng.normal()), size / pace * float(rng.normal())))
    if name == "servo":
        # a loop that is about twice as fast as the motor and well damped
        gain, pole = rig.numerator[0], rig.denominator[1]
        speed = pole * float(rng.uniform(1.5, 4.0))
        velocity_gain = (2.0 * speed - pole) / gain
        limit = force * float(rng.uniform(1.0, 3.0))
        return replace(rig, controller=(speed**2 / (gain * velocity_gain), velocity_gain, limit), largest_input=output)
    if rig.pendulum is None:
        known = rng.random() < 0.35
        return replace(rig, offset=output * float(rng.uniform(-1.5, 1.5)), offset_known=bool(known))
    return rig
