"""The page on the real recordings: what was believed, refitted and improved beside what others published."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from camid.number_text import plain, with_deviation
from camid.real_recordings.results import MODELS

BASELINES = "Champneys et al., arXiv 2405.10779, Tables 3 and 4"
DRIVE = "Janot, Gautier & Brunot 2019, hal-02178709: inverse dynamics, least squares"
THESIS = "code of the thesis, nielsSkov/masterThesisMatlab, cartPendulum/initCartPendulum.m at b7eb298: whole record"
REPORT = "experimenter's report beside the clip, juangomez177/Pendulum_Oscillatory_Motion"
BY_HAND = "fitted with an integrator written apart from this project, from near upright, the horizon grown"
DRIVES = "measured independently: a linear model, and the same behind an absolute value, in free run"
TANKS = "reported for this benchmark (Schoukens & Noël 2017), whole validation record"
NOT_FOUND = "not found"
# Data for the thesis's friction, from the same file: mass, length, gravity, Coulomb and viscous friction.
THESIS_MASS, THESIS_LENGTH, THESIS_GRAVITY = 0.2235, 0.31692, 9.82  # kg, m, m/s²
THESIS_COULOMB, THESIS_VISCOUS = 4.1e-3, 0.5e-3  # N m, N m s


# Effects that would explain what the experiment lets one expect, whether or not a diagnosis names them.
SUSPECTED = {"pendulum_clip": "perspective"}


@dataclass(frozen=True)
class TableLine:
    """A line of a table.

    Attributes
    ----------
    label : str
        With the unit.
    quantity : str
        Name in the results; ``_nominal``, ``_refitted`` and ``_improved`` follow it unless it is an effect's.
    published, source : str
    """

    label: str
    quantity: str
    published: str = NOT_FOUND
    source: str = ""


LINES: dict[str, list[TableLine]] = {
    "silverbox": [
        TableLine("natural frequency (Hz)", "natural_frequency"),
        TableLine("damping ratio", "damping_ratio"),
        TableLine("cubic stiffness (V/V³)", "cubic-stiffness_coefficient"),
        TableLine("quadratic part of it (V/V²)", "cubic-stiffness_quadratic"),
        TableLine("offset of the input (V)", "input-bias_bias"),
        TableLine("rms error, test multisine (mV)", "multisine", "6.95 linear; 0.301 best there (GP NARX)", BASELINES),
        TableLine("rms error, test arrow (mV)", "arrow", "14.2 linear; 0.60 (GP NARX)", BASELINES),
    ],
    "emps": [
        TableLine("mass (kg)", "mass", "95.11", DRIVE),
        TableLine("viscous friction (N s/m)", "viscous_friction", "203.5", DRIVE),
        TableLine("Coulomb friction (N)", "coulomb-friction_force", "20.39", DRIVE),
        TableLine("offset of the force (N)", "input-bias_bias", "−3.165, subtracted", DRIVE),
        TableLine("error of the force, rows not fitted (%)", "held_out_error", "4.08 of the norm, fitted rows", DRIVE),
        TableLine("error of the position, rows not fitted (%)", "position_error"),
    ],
    "pendulum_decay": [
        TableLine(
            "natural frequency (rad/s)", "natural_frequency", plain((THESIS_GRAVITY / THESIS_LENGTH) ** 0.5, 3), THESIS
        ),
        TableLine(
            "viscous damping (1/s)",
            "viscous_damping",
            plain(THESIS_VISCOUS / THESIS_MASS / THESIS_LENGTH**2, 3),
            THESIS,
        ),
        TableLine(
            "Coulomb friction (rad of static deflection)",
            "coulomb-friction_force",
            plain(THESIS_COULOMB / THESIS_MASS / THESIS_GRAVITY / THESIS_LENGTH, 3),
            THESIS,
        ),
        TableLine("error, fitted rows, 16 to 42.5 s (%)", "fitted_error"),
        TableLine("error, rows not fitted, 42.5 to 47.5 s (%)", "held_out_error"),
    ],
    "pendulum_clip": [
        TableLine("period (s)", "period"),
        TableLine("length (m)", "length", "1.7", REPORT),
        TableLine("rms residual, all frames (px)", "residual"),
        TableLine("error, frames not fitted (%)", "held_out_error"),
    ],
    "pendulum2_decay": [
        TableLine("natural frequency (rad/s)", "natural_frequency"),
        TableLine("viscous damping (1/s)", "viscous_damping"),
        TableLine("friction at rest (rad of static deflection)", "stribeck-friction_breakaway"),
        TableLine("the same at high speed", "stribeck-friction_coulomb"),
        TableLine("error, fitted rows (%)", "fitted_error"),
        TableLine("error, rows not fitted (%)", "held_out_error"),
        TableLine("error, 4.5 to 46 s (%)", "whole_record_error", "0.60 with Coulomb, 0.34 with drag, too", BY_HAND),
    ],
    "coupled_drives": [
        TableLine("resonance of belt and spring (rad/s)", "resonance"),
        TableLine("time constant of the motors (s)", "time_constant"),
        TableLine("error, fitted rows (%)", "fitted_error"),
        TableLine("error, rows not fitted (%)", "held_out_error", "110 with a sign; 33 without", DRIVES),
    ],
    "cascaded_tanks": [
        TableLine("rms error, validation rows not fitted (V)", "validation"),
        TableLine(
            "rms error, whole validation record (V)", "whole_validation", "0.65 linear; 0.18 to 0.19 grey box", TANKS
        ),
        TableLine("error, rows not fitted (%)", "held_out_error"),
        TableLine("error, fitted rows (%)", "fitted_error"),
    ],
}


def table(name: str, quantities: pd.DataFrame) -> str:
    """Markdown table of a recording.

    Parameters
    ----------
    name : str
        Key of :data:`camid.real_recordings.results.RECORDINGS`.
    quantities : DataFrame
        From :func:`camid.real_recordings.results.quantities`.
    """
    from tabulate import tabulate

    known = quantities.set_index("quantity")
    rows = []
    for line in LINES[name]:
        row = {"": line.label}
        for model in MODELS:
            key = f"{line.quantity}_{model}"
            if line.quantity in known.index:  # a parameter of an effect
                key = line.quantity if model == "improved" else ""
            row[model] = _number(known, key)
        rows.append({**row, "published": line.published, "source": line.source})
    cells = pd.DataFrame(rows).map(lambda cell: str(cell).replace("|", "\\|"))
    return tabulate(cells.to_dict("list"), headers="keys", tablefmt="pipe", disable_numparse=True)


def _number(known: pd.DataFrame, key: str) -> str:
    """Value with its standard deviation, with as many digits as that has."""
    if key not in known.index:
        return "–"
    value, deviation = (float(known[column].loc[key]) for column in ("value", "standard_deviation"))
    return with_deviation(value, deviation) if deviation > 0.0 else plain(value, 3)


def _parameter(known: pd.DataFrame, key: str, words: str) -> str:
    """A parameter with its number and unit; a choice, which a table of numbers holds as 1 without both, alone."""
    unit, deviation = known["unit"].loc[key], known["standard_deviation"].loc[key]
    unit = unit if isinstance(unit, str) else ""
    chosen = not unit and not deviation > 0.0
    return words if chosen else f"{words} {_number(known, key)} {unit}".rstrip()


def page(template: Path, quantities: Mapping[str, pd.DataFrame]) -> str:
    """The page, its numbers and tables from the results.

    Parameters
    ----------
    template : Path
        Jinja template, in which ``value(recording, quantity, digits)``, ``table(recording)``, ``effects(recording)``
        and ``suspicion_confirmed(recording)`` insert results.
    quantities : dict of DataFrame
        By recording.
    """
    import jinja2

    def value(name: str, quantity: str, digits: int = 3) -> str:
        known = quantities[name].set_index("quantity")["value"]
        return plain(float(known.loc[quantity]), digits)

    def effects(name: str) -> str:
        known = quantities[name].set_index("quantity")
        found = [q.removeprefix("named_") for q in known.index if q.startswith("named_")]
        words = []
        for effect in found:
            parameters = [q for q in known.index if q.startswith(f"{effect}_")]
            numbers = [_parameter(known, q, q.removeprefix(f"{effect}_").replace("_", " ")) for q in parameters]
            words.append(f"`{effect}` ({', '.join(numbers)})" if numbers else f"`{effect}`")
        return ", ".join(words) or "nothing"

    def learned(name: str) -> str:
        """What stands in an improved simulation without a name, as words."""
        known = quantities[name]["quantity"]
        found = [q.replace("_", " ").replace(" over ", " over the ") for q in known if q.startswith("learned_")]
        return " and ".join(f"a {law}" for law in found) or "nothing else"

    def suspicion_confirmed(name: str) -> bool:
        return f"named_{SUSPECTED[name]}" in set(quantities[name]["quantity"])

    functions: dict[str, Callable[..., Any]] = {
        "value": value,
        "table": lambda name: table(name, quantities[name]),
        "effects": effects,
        "learned": learned,
        "suspicion_confirmed": suspicion_confirmed,
    }
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False)
    return _wrapped(environment.from_string(template.read_text(encoding="utf-8")).render(**functions))


def _wrapped(text: str) -> str:
    """Markdown with its paragraphs rewrapped, as they contain numbers of any length."""
    import textwrap

    blocks = text.rstrip("\n").split("\n\n")
    kept = ("|", "#", "!", "```")
    filled = [
        block if block.startswith(kept) else textwrap.fill(block, 120, break_long_words=False, break_on_hyphens=False)
        for block in (block.strip("\n") for block in blocks)
    ]
    return "\n\n".join(filled) + "\n"
