"""Rigs whose constants are known: the plant as a user writes it, and its equations of motion written again by hand.

Nothing here imports camid. The text of a plant goes to the tool; recordings come from :mod:`.motions`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from . import motions, plants
from .motions import Constants, Rates, State


@dataclass(frozen=True)
class Rig:
    """A plant with its true constants, and how it is excited and recorded.

    Attributes
    ----------
    name : str
    form : dict
        How the plant follows from the constants, as a user writes it below ``physical``.
    truth : dict of str to float
        True constants, in the units of ``units``.
    rates : callable
        Equations of motion.
    output : callable
        From the state to what the camera sees.
    start : tuple of float
        State one period before the first frame.
    period, exposure : float
        Of the frames, seconds.
    frames : int
    amplitude : float
        Largest excursion of the input from ``middle``, in the input's unit.
    noise : float
        Standard deviation of the noise, as a share of that of the output.
    fixed : tuple of str
        Constants that the user knows.
    units : dict of str to str
    longest_hold : int
        Most frames for which the input keeps a level.
    middle : float
        Of the input, which is there before the first frame too.
    mirrored : bool
        Whether each level is followed by its negative, so that what integrates does not drift.
    decays_freely : bool
        Whether there is no input.
    at_rest : bool
        Whether the user declares that the rig was at rest before the first frame; the initial state is estimated else.
    offset : float
        Of the camera, in the unit of the output.
    offset_known : bool
        Whether the user declares it, or leaves it to be estimated.
    combinations : dict of str to callable
        What a recording determines of the constants in ``open``, by what a reader would call it.
    open : frozenset of str
        Constants that no recording determines each.
    """

    name: str
    form: Mapping[str, Any]
    truth: Constants
    rates: Rates
    output: Callable[[State], float]
    start: tuple[float, ...]
    period: float
    exposure: float
    frames: int
    amplitude: float
    noise: float
    fixed: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    longest_hold: int = 8
    middle: float = 0.0
    mirrored: bool = False
    decays_freely: bool = False
    at_rest: bool = True
    offset: float = 0.0
    offset_known: bool = True
    combinations: Mapping[str, Callable[[Constants], float]] = field(default_factory=dict)
    open: frozenset[str] = frozenset()

    @property
    def free(self) -> tuple[str, ...]:
        """Constants that the user does not know."""
        return tuple(name for name in self.truth if name not in self.fixed)

    def simulation(self, believed: Constants) -> dict[str, Any]:
        """The user's simulation with the constants that he believes."""
        sensor: dict[str, Any] = {"column": "y", "kind": "camera", "exposure": self.exposure}
        if self.offset_known:
            sensor["offset"] = self.offset
        constants = {"parameters": dict(believed), "units": dict(self.units), **self.form, "fixed": list(self.fixed)}
        return {
            "schema": 1,
            "time": {"column": "t"},
            "input": None if self.decays_freely else {"column": "u", "hold": "zoh"},
            "plant": {"physical": constants},
            "sensor": sensor,
            "initial_state": "zero" if self.at_rest else "estimate",
        }


# -- the rigs ----------------------------------------------------------------------------------------------------------

# Swings of one to three rad: a pendulum that turns over is chaotic, and no integrator's digits would suffice.
PENDULUM = {"mass": 0.3, "length": 0.25, "gravity": 9.81, "inertia": 0.025, "damping": 0.02}
PENDULUM_UNITS = {"mass": "kg", "length": "m", "gravity": "m/s^2", "inertia": "kg m^2", "damping": "N m s"}
MOTOR = {"inertia": 2e-4, "friction": 1.5e-3, "torque_constant": 0.05, "resistance": 1.5}
MOTOR_UNITS = {"inertia": "kg m^2", "friction": "N m s", "torque_constant": "N m/A", "resistance": "ohm"}

RIGS = (
    Rig(
        "mass-spring-damper",
        plants.SPRING,
        {"mass": 1.2, "damping": 4.0, "stiffness": 310.0},
        rates=motions.spring,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.02,
        exposure=0.01,
        frames=1000,
        amplitude=10.0,
        noise=0.01,
        units={"mass": "kg", "damping": "N s/m", "stiffness": "N/m"},
    ),
    Rig(
        "cart",
        {"transfer_function": {"numerator": ["1"], "denominator": ["mass", "damping", "0"]}},
        {"mass": 2.0, "damping": 1.5},
        rates=motions.cart,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.05,
        exposure=0.02,
        frames=800,
        amplitude=2.0,
        noise=0.01,
        units={"mass": "kg", "damping": "N s/m"},
        longest_hold=12,
    ),
    Rig(
        "motor",
        plants.MOTOR,
        MOTOR,
        rates=motions.motor,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.02,
        exposure=0.01,
        frames=900,
        amplitude=6.0,
        noise=0.02,
        fixed=("torque_constant", "resistance"),
        units=MOTOR_UNITS,
        mirrored=True,
        offset=0.3,
        offset_known=False,
    ),
    Rig(
        "two masses",
        plants.TWO_MASSES,
        {"motor_mass": 1.0, "load_mass": 1.5, "stiffness": 600.0, "damping": 1.5, "friction": 4.0},
        rates=motions.two_masses,
        output=motions.third,
        start=(0.0, 0.0, 0.0, 0.0),
        period=0.02,
        exposure=0.008,
        frames=1200,
        amplitude=20.0,
        noise=0.01,
        fixed=("motor_mass",),
        units={"motor_mass": "kg", "load_mass": "kg", "stiffness": "N/m", "damping": "N s/m", "friction": "N s/m"},
        mirrored=True,
    ),
    Rig(
        "quarter car",
        plants.QUARTER_CAR,
        {"body_mass": 300.0, "wheel_mass": 40.0, "spring": 16e3, "damper": 1000.0, "tyre": 180e3},
        rates=motions.quarter_car,
        output=motions.travel,
        start=(0.0, 0.0, 0.0, 0.0),
        period=0.01,
        exposure=0.005,
        frames=1200,
        amplitude=0.02,
        noise=0.01,
        fixed=("body_mass",),
        units={"body_mass": "kg", "wheel_mass": "kg", "spring": "N/m", "damper": "N s/m", "tyre": "N/m"},
        longest_hold=20,
    ),
    Rig(
        "heater",
        plants.HEATER,
        {"heater_capacity": 60.0, "plate_capacity": 200.0, "transfer": 3.0, "loss": 1.5},
        rates=motions.heater,
        output=motions.second,
        start=(0.0, 0.0),
        period=2.0,
        exposure=0.5,
        frames=900,
        amplitude=20.0,
        noise=0.01,
        fixed=("heater_capacity",),
        units={"heater_capacity": "J/K", "plate_capacity": "J/K", "transfer": "W/K", "loss": "W/K"},
        longest_hold=30,
        offset=21.0,
        offset_known=False,
    ),
    Rig(
        "pendulum",
        plants.PENDULUM,
        PENDULUM,
        rates=motions.pendulum,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.02,
        exposure=0.01,
        frames=1000,
        amplitude=0.25,
        noise=0.01,
        fixed=("mass", "length", "gravity"),
        units=PENDULUM_UNITS,
        longest_hold=25,
    ),
    Rig(
        "hardening spring",
        plants.HARDENING,
        {"mass": 0.5, "damping": 0.6, "linear": 80.0, "cubic": 4000.0},
        rates=motions.hardening,
        output=motions.first,
        start=(0.15, 0.0),
        period=0.01,
        exposure=0.005,
        frames=600,
        amplitude=0.0,
        noise=0.02,
        fixed=("mass",),
        units={"mass": "kg", "damping": "N s/m", "linear": "N/m", "cubic": "N/m^3"},
        decays_freely=True,
        at_rest=False,
    ),
    Rig(
        "two tanks",
        plants.TANKS,
        {"pump": 0.01, "upper_outflow": 0.012, "lower_outflow": 0.014},
        rates=motions.tanks,
        output=motions.second,
        start=(0.34, 0.25),
        period=2.0,
        exposure=0.5,
        frames=1000,
        amplitude=0.3,
        noise=0.01,
        units={"pump": "m/s", "upper_outflow": "m^0.5/s", "lower_outflow": "m^0.5/s"},
        longest_hold=40,
        middle=0.7,
        at_rest=False,
    ),
    Rig(
        "float",
        plants.FLOAT,
        {"mass": 80.0, "drag": 400.0, "buoyancy": 700.0},
        rates=motions.float_with_drag,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.05,
        exposure=0.02,
        frames=1000,
        amplitude=150.0,
        noise=0.02,
        units={"mass": "kg", "drag": "N s^2/m^2", "buoyancy": "N/m"},
        longest_hold=30,
    ),
)

# Rigs with constants that no recording tells apart.
AMBIGUOUS = (
    Rig(
        "spring with a gain",
        {"transfer_function": {"numerator": ["gain"], "denominator": ["mass", "damping", "stiffness"]}},
        {"mass": 1.2, "damping": 4.0, "stiffness": 310.0, "gain": 2.5},
        rates=motions.spring_with_gain,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.02,
        exposure=0.01,
        frames=1000,
        amplitude=4.0,
        noise=0.01,
        open=frozenset({"mass", "damping", "stiffness", "gain"}),
        combinations={
            "damping/mass": lambda c: c["damping"] / c["mass"],
            "stiffness/mass": lambda c: c["stiffness"] / c["mass"],
            "gain/mass": lambda c: c["gain"] / c["mass"],
        },
    ),
    Rig(
        "two dampers in parallel",
        {"transfer_function": {"numerator": ["1"], "denominator": ["mass", "bearing + brake", "stiffness"]}},
        {"mass": 1.2, "bearing": 1.5, "brake": 2.5, "stiffness": 310.0},
        rates=motions.spring_with_two_dampers,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.02,
        exposure=0.01,
        frames=1000,
        amplitude=10.0,
        noise=0.01,
        open=frozenset({"bearing", "brake"}),
        combinations={"bearing + brake": lambda c: c["bearing"] + c["brake"]},
    ),
    Rig(
        "motor without a data sheet",
        plants.MOTOR,
        MOTOR,
        rates=motions.motor,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.02,
        exposure=0.01,
        frames=900,
        amplitude=6.0,
        noise=0.02,
        units=MOTOR_UNITS,
        mirrored=True,
        open=frozenset(MOTOR),
        combinations={
            "torque_constant/(inertia*resistance)": lambda c: c["torque_constant"] / (c["inertia"] * c["resistance"]),
            "(friction + torque_constant^2/resistance)/inertia": lambda c: (
                (c["friction"] + c["torque_constant"] ** 2 / c["resistance"]) / c["inertia"]
            ),
        },
    ),
    Rig(
        "pendulum that was not weighed",
        plants.PENDULUM,
        PENDULUM,
        rates=motions.pendulum,
        output=motions.first,
        start=(0.0, 0.0),
        period=0.02,
        exposure=0.01,
        frames=1000,
        amplitude=0.25,
        noise=0.01,
        fixed=("gravity",),
        units=PENDULUM_UNITS,
        longest_hold=25,
        open=frozenset({"mass", "length"}),
        combinations={"mass*length": lambda c: c["mass"] * c["length"]},
    ),
    Rig(
        "two unequal tanks",
        plants.UNEQUAL_TANKS,
        {"pump": 0.01, "upper_out": 0.012, "lower_in": 0.018, "lower_out": 0.02},
        rates=motions.unequal_tanks,
        output=motions.second,
        start=(0.34, 0.2756),
        period=2.0,
        exposure=0.5,
        frames=1000,
        amplitude=0.3,
        noise=0.01,
        longest_hold=40,
        middle=0.7,
        at_rest=False,
        open=frozenset({"pump", "upper_out", "lower_in"}),
        combinations={
            "pump/upper_out^2": lambda c: c["pump"] / c["upper_out"] ** 2,
            "lower_in*upper_out": lambda c: c["lower_in"] * c["upper_out"],
        },
    ),
)
