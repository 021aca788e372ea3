"""Plants as an engineer writes them, by name: constants with units, and first values from a resonance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from camid.draft.plant import Resonance

GRAVITY = 9.81


@dataclass(frozen=True)
class Template:
    """A physical plant to start from.

    Attributes
    ----------
    title : str
        In words, with what goes in and comes out.
    units : dict of str to str
        Of the constants, in their order.
    form : str
        How the plant follows from them: lines of YAML.
    fixed : tuple of str
        Constants that no recording tells from the others, or that are known.
    guess : callable
        First values from a resonance of second order, and the means of input and output.
    remark : str
        What to check.
    """

    title: str
    units: Mapping[str, str]
    form: str
    fixed: tuple[str, ...]
    guess: Callable[[Resonance, float, float], dict[str, float]]
    remark: str

    def lines(self, resonance: Resonance, signal: float, output: float) -> list[str]:
        """The part ``plant`` of a simulation file, with first values."""
        values = self.guess(resonance, signal, output)
        shown = ", ".join(f"{name}: {float(f'{values[name]:.4g}')!r}" for name in self.units)
        units = ", ".join(f"{name}: {unit}" for name, unit in self.units.items() if unit)
        fixed = [f"    fixed: [{', '.join(self.fixed)}]  # {self.remark}"] if self.fixed else [f"    # {self.remark}"]
        levels = {"start": float(f"{max(output, 1.0):.4g}")}
        return [
            "plant:",
            f"  physical:  # {self.title}",
            f"    parameters: {{{shown}}}  # guesses",
            f"    units: {{{units}}}",
            *(f"    {line.format(**levels)}" for line in self.form.splitlines()),
            *fixed,
        ]


def _stiffness(resonance: Resonance) -> float:
    return 1.0 / (abs(resonance.gain) or 1.0)


def _mass(resonance: Resonance) -> float:
    return _stiffness(resonance) / resonance.natural_frequency**2


def _damping(resonance: Resonance) -> float:
    return 2.0 * resonance.damping * resonance.natural_frequency * _mass(resonance)


def _mass_spring_damper(resonance: Resonance, signal: float, output: float) -> dict[str, float]:
    return {"mass": _mass(resonance), "damping": _damping(resonance), "stiffness": _stiffness(resonance)}


def _cart(resonance: Resonance, signal: float, output: float) -> dict[str, float]:
    return {"mass": _mass(resonance), "damping": _damping(resonance)}


def _pendulum(resonance: Resonance, signal: float, output: float) -> dict[str, float]:
    length = GRAVITY / resonance.natural_frequency**2
    return {
        "mass": 1.0,
        "length": length,
        "inertia": length**2,
        "damping": 2.0 * resonance.damping * resonance.natural_frequency * length**2,
        "torque_constant": abs(resonance.gain) * GRAVITY * length or 1.0,
        "gravity": GRAVITY,
    }


def _motor(resonance: Resonance, signal: float, output: float) -> dict[str, float]:
    inertia = _mass(resonance)
    return {"inertia": inertia, "friction": 0.5 * _damping(resonance), "torque_constant": 1.0, "resistance": 1.0}


def _two_tanks(resonance: Resonance, signal: float, output: float) -> dict[str, float]:
    level = max(output, 1.0)
    outflow = 2.0 * resonance.natural_frequency * level**0.5
    return {"pump": outflow * level**0.5 / (abs(signal) or 1.0), "upper_outflow": outflow, "lower_outflow": outflow}


def _two_masses(resonance: Resonance, signal: float, output: float) -> dict[str, float]:
    half = 0.5 * _mass(resonance)
    stiffness = 0.5 * half * resonance.natural_frequency**2
    damping = 2.0 * resonance.damping * resonance.natural_frequency * 0.5 * half
    return {"motor_mass": half, "load_mass": half, "stiffness": stiffness, "damping": damping}


TEMPLATES: Mapping[str, Template] = {
    "mass-spring-damper": Template(
        "a force on a mass with a spring and a damper, to its position",
        {"mass": "kg", "damping": "N s/m", "stiffness": "N/m"},
        'transfer_function: {{numerator: ["1"], denominator: [mass, damping, stiffness]}}',
        (),
        _mass_spring_damper,
        "where the input is not a force in N, fix what you have weighed: fixed: [mass], and add a gain",
    ),
    "pendulum": Template(
        "a torque on a pendulum of any amplitude, to its angle from hanging in rad",
        {
            "mass": "kg",
            "length": "m",
            "inertia": "kg m^2",
            "damping": "N m s",
            "torque_constant": "N m/u",
            "gravity": "m/s^2",
        },
        "equations:\n"
        "  states:\n"
        "    angle: speed\n"
        '    speed: "(torque_constant*u - damping*speed - mass*gravity*length*sin(angle))/inertia"\n'
        "  output: angle",
        ("mass", "length", "gravity"),
        _pendulum,
        "weigh it: a swing tells inertia, damping and torque by the product mass*gravity*length",
    ),
    "cart": Template(
        "a force on a cart with viscous friction, to its position",
        {"mass": "kg", "damping": "N s/m"},
        'transfer_function: {{numerator: ["1"], denominator: [mass, damping, "0"]}}',
        (),
        _cart,
        "where the input is not a force in N, fix what you have weighed: fixed: [mass], and add a gain",
    ),
    "motor": Template(
        "a voltage on a motor with inertia and viscous friction, to its angle in rad",
        {"inertia": "kg m^2", "friction": "N m s", "torque_constant": "N m/A", "resistance": "ohm"},
        "transfer_function:\n"
        '  numerator: ["torque_constant/resistance"]\n'
        '  denominator: [inertia, "friction + torque_constant^2/resistance", "0"]',
        ("torque_constant", "resistance"),
        _motor,
        "from its data sheet: a recording tells only two combinations of the four",
    ),
    "two-tanks": Template(
        "a pump that fills a tank which empties into a second one, to the level of that (Torricelli)",
        {"pump": "y/s/u", "upper_outflow": "y^0.5/s", "lower_outflow": "y^0.5/s"},
        "equations:\n"
        "  states:\n"
        '    upper: "pump*u - upper_outflow*sqrt(max(upper, 0))"\n'
        '    lower: "upper_outflow*sqrt(max(upper, 0)) - lower_outflow*sqrt(max(lower, 0))"\n'
        "  output: lower\n"
        "  start: {{upper: {start}, lower: {start}}}",
        (),
        _two_tanks,
        "tanks of one cross section, their levels in the unit of the output",
    ),
    "two-masses": Template(
        "a force on a mass that drives a second one by a spring, to the position of the second",
        {"motor_mass": "kg", "load_mass": "kg", "stiffness": "N/m", "damping": "N s/m"},
        "state_space:\n"
        "  # positions and speeds of motor and load\n"
        "  state_matrix:\n"
        '    - ["0", "1", "0", "0"]\n'
        '    - ["-stiffness/motor_mass", "-damping/motor_mass", "stiffness/motor_mass", "damping/motor_mass"]\n'
        '    - ["0", "0", "0", "1"]\n'
        '    - ["stiffness/load_mass", "damping/load_mass", "-stiffness/load_mass", "-damping/load_mass"]\n'
        '  input_vector: ["0", "1/motor_mass", "0", "0"]\n'
        '  output_row: ["0", "0", "1", "0"]',
        ("motor_mass",),
        _two_masses,
        "the mass that you know: the position of the load tells three combinations of the four",
    ),
}
