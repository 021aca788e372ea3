"""Recordings with a concealed effect: the judge of the diagnosis, made by code that knows nothing of the tool.

A recording is made from the mechanics of a drawn machine, in physical units; the simulation that goes with it knows
the machine up to several per cent and knows nothing of the effect.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.proof.concealed.camera_readings import clean, motion, readings, record
from camid.proof.concealed.cases import Case, plan
from camid.proof.concealed.detectability import multiple
from camid.proof.concealed.drawn_recording import DrawnRecording, add_effect, draw_recording, make_gentle
from camid.proof.concealed.image_readings import image_readings
from camid.proof.concealed.rig_setup import Setup
from camid.proof.concealed.size_in_company import sizes_in_company

__all__ = ["Case", "ConcealedRecording", "make", "plan"]

Array = NDArray[np.float64]

# Effects that add a constant to a signal.
CONSTANTS = frozenset({"sensor-offset", "input-bias"})


@dataclass(frozen=True)
class ConcealedRecording:
    """A recording, what its user believes, what is true, and further recordings of the same rig.

    Attributes
    ----------
    recording : pandas.DataFrame
        Columns t in s, u and y.
    simulation : dict
        Content of a simulation file: what the user believes.
    same_kind, double_amplitude : pandas.DataFrame
        Held-out recordings with another input of the same kind, at the same and at twice the amplitude; the column
        clean is the output without what is random.
    truth : dict
        What is concealed, for the judge; fit for JSON.
    """

    recording: pd.DataFrame
    simulation: dict[str, Any]
    same_kind: pd.DataFrame
    double_amplitude: pd.DataFrame
    truth: dict[str, Any]


def make(case: Case) -> ConcealedRecording:
    """Make one recording; the same case always gives the same.

    Parameters
    ----------
    case : Case
        From :func:`plan`.

    Returns
    -------
    ConcealedRecording
    """
    draws, effect_draws, noise_draws = (
        np.random.default_rng(child) for child in np.random.SeedSequence([case.seed, case.index]).spawn(3)
    )
    drawn = draw_recording(case, draws)
    for name in case.effects:
        add_effect(drawn, name, effect_draws)
    commands = [factor * drawn.excitation.draw(draws, drawn.setup.input_length) for factor in (1.0, 2.0)]
    make_gentle(drawn, commands)

    setup = drawn.setup_with(drawn.effects)
    output = drawn.output(setup, drawn.command)
    noise_std, largest = drawn.noise_std(output), float(np.max(np.abs(output)))
    events = np.random.default_rng(drawn.seed + 1)  # those that the effects were sized with
    recording = _table(drawn, setup, drawn.command, noise_std, largest, noise_draws, events)
    # What happened once does not happen again.
    lasting = [b for b in drawn.effects if b.effect.repeatable or b.effect.place != "disturbance"]
    again = drawn.setup_with(lasting)
    same_kind, double_amplitude = (
        _table(drawn, again, command, noise_std, largest, noise_draws, noise_draws) for command in commands
    )
    if drawn.images:
        noise_std = float(np.std(recording["y"] - recording["clean"]))
    return ConcealedRecording(
        recording.drop(columns="clean"),
        _simulation(drawn, draws),
        same_kind,
        double_amplitude,
        _truth(drawn, setup, output, noise_std),
    )


def _table(
    drawn: DrawnRecording,
    setup: Setup,
    command: Array,
    noise_std: float,
    largest: float,
    noise: np.random.Generator,
    events: np.random.Generator,
) -> pd.DataFrame:
    """Record the rig under a command; columns t, u, y and clean."""
    trajectory = motion(setup, command)
    values = clean(setup, readings(setup, trajectory))
    if drawn.images:
        recorded = image_readings(setup, trajectory, largest, noise_std, noise)
    else:
        recorded = record(setup, trajectory, noise_std, noise, events)
    time = np.arange(setup.frames, dtype=np.float64) * setup.period
    return pd.DataFrame({"t": time, "u": drawn.recorded(command), "y": recorded, "clean": values})


def _simulation(drawn: DrawnRecording, draws: np.random.Generator) -> dict[str, Any]:
    """What the user believes: the contract of a simulation file."""
    plant, acquisition = drawn.setup.rig.believed(draws), drawn.belief.acquisition
    sensor: dict[str, Any] = {"column": "y", "kind": acquisition.sensor, "latency": float(acquisition.latency)}
    if acquisition.sensor == "camera":
        sensor["exposure"] = float(drawn.setup.exposure)
    # Where nothing is said of it the sensor's zero is estimated, and no constant is left to be found. Half of the users
    # who have nothing of the kind to find declare their zero, too.
    concealed = {built.effect.identity for built in drawn.effects}
    if concealed & CONSTANTS or draws.random() < 0.5:
        sensor["offset"] = 0.0
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": list(plant.numerator), "denominator": list(plant.denominator)}},
        "sensor": sensor,
        "initial_state": "estimate" if drawn.setup.moving else "zero",
        "effects": [],
    }


def _truth(drawn: DrawnRecording, setup: Setup, output: Array, noise_std: float) -> dict[str, Any]:
    """What is concealed, in numbers and words that JSON knows."""
    effects = []
    in_company = sizes_in_company(drawn) if len(drawn.effects) > 1 else [None] * len(drawn.effects)
    for built, beside in zip(drawn.effects, in_company, strict=True):
        squares = built.sum_of_squares
        if len(drawn.effects) == 1 and not built.effect.noise_like:
            squares = drawn.belief.left_over_after_estimate(drawn.recorded(drawn.command), output)
        alone = None if squares is None else multiple(squares, noise_std)
        effects.append(
            {
                "id": built.effect.identity,
                "place": built.effect.place,
                "law": built.effect.law,
                "parameters": {
                    name: value if value is None or isinstance(value, str) else float(value)
                    for name, value in built.effect.parameters(built.strength).items()
                },
                "multiple": alone if beside is None else beside,
                "multiple_alone": alone,
            }
        )
    plant = drawn.belief.plant
    return {
        "kind": drawn.case.kind,
        "effects": effects,
        "snr_db": float(20.0 * np.log10(np.std(output) / noise_std)),
        "excitation": drawn.excitation.kind,
        "noise_std": float(noise_std),
        "initial_state": "estimate" if drawn.setup.moving else "zero",
        "plant": {"numerator": list(plant.numerator), "denominator": list(plant.denominator)},
        "period": float(setup.period),
        "exposure": float(setup.exposure),
        "latency": float(setup.latency),
        "hold": setup.hold,
        "frames": setup.frames,
        "images": bool(drawn.images),
        "repeatable": all(b.effect.repeatable for b in drawn.effects),
    }
