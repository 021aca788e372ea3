"""Results on the real recordings: what two diagnoses, the published split and the published values say about each."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from camid.chain.plant import TransferFunction
from camid.commands.diagnose import diagnose
from camid.commands.simulate import simulate
from camid.effects import known_effects
from camid.real_recordings.download import SILVERBOX_ARROW, SILVERBOX_MULTISINE, SILVERBOX_TRANSIENT
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

RECORDINGS = {
    "silverbox": "Silverbox: an electronic oscillator",
    "emps": "EMPS: a drive in closed loop",
    "pendulum_decay": "A pendulum swings out",
    "pendulum_clip": "A clip of a pendulum",
    "pendulum2_decay": "A lighter pendulum swings out",
    "coupled_drives": "Coupled electric drives, first record",
    "cascaded_tanks": "Cascaded tanks, validation record",
}
MODELS = ("nominal", "refitted", "improved")
# Units of input and output, which a diagnosis calls u and y.
UNITS = {
    "silverbox": {"u": "V", "y": "V"},
    "emps": {"u": "N", "y": "m"},
    "pendulum_decay": {"u": "rad", "y": "rad"},
    "pendulum_clip": {"u": "px", "y": "px"},
    "pendulum2_decay": {"u": "rad", "y": "rad"},
    "coupled_drives": {"u": "V", "y": "a.u."},
    "cascaded_tanks": {"u": "V", "y": "V"},
}
GRAVITY = 9.81  # m/s²
# Seconds of the pendulums' records from the release to the rest, and a remainder above what the improved models leave
# there, so that plant and friction are re-estimated and nothing is looked for.
PENDULUM_WHOLE = {"pendulum_decay": (4.5, 73.0), "pendulum2_decay": (4.5, 46.0)}
ANY_REMAINDER = 0.2  # rad


@dataclass(frozen=True)
class Results:
    """Files of one recording.

    Attributes
    ----------
    name : str
        Key of ``RECORDINGS``.
    recording : Path
        The untouched file, or the table that ``camid track`` wrote.
    nominal, improved : Simulation
    diagnosis, again : dict
        diagnosis.json, of the first diagnosis and of that from improved.yaml.
    residuals : DataFrame
        residuals.csv of the first diagnosis.
    """

    name: str
    recording: Path
    nominal: Simulation
    improved: Simulation
    diagnosis: dict[str, Any]
    again: dict[str, Any]
    residuals: pd.DataFrame

    @classmethod
    def read(cls, name: str, recording: Path, nominal: Path, folder: Path, again: Path) -> Results:
        """Read what ``camid diagnose`` wrote into two folders."""
        return cls(
            name,
            recording,
            load_simulation(nominal),
            load_simulation(folder / "improved.yaml"),
            json.loads((folder / "diagnosis.json").read_text(encoding="utf-8")),
            json.loads((again / "diagnosis.json").read_text(encoding="utf-8")),
            pd.read_csv(folder / "residuals.csv"),
        )

    def coefficient(self, name: str, model: str) -> tuple[float, float | None]:
        """Coefficient (``b0``, ``a1``, ``a0``) of the monic plant in a model, and its standard deviation."""
        rows = {c["name"]: c for c in self.diagnosis["coefficients"]}
        if name not in rows:  # a pendulum is told of by its own constants
            return _of_pendulum(rows, name, model)
        return rows[name][model], rows[name].get(f"{model}_deviation")

    def parameter(self, effect: str, name: str) -> float:
        """Value of a parameter of an effect that the improved model holds; zero if it does not, or its law has none."""
        return float(next((e.parameters.get(name, 0.0) for e in self.improved.effects if e.identifier == effect), 0.0))


def _of_pendulum(rows: Mapping[str, Any], name: str, model: str) -> tuple[float, float | None]:
    """A coefficient of a pendulum's equation, a0 or a1, with its standard deviation."""
    frequency, damping = rows["natural frequency"], rows["damping"]
    value, ratio = frequency[model], damping[model]
    deviation, spread = frequency.get(f"{model}_deviation"), damping.get(f"{model}_deviation")
    if name == "a0":
        return value**2, None if deviation is None else 2.0 * value * deviation
    # The frequency is known so much better that nothing else counts.
    return 2.0 * ratio * value, None if spread is None else 2.0 * value * spread


Row = tuple[str, float, float | None, str]


def quantities(results: Results, linear: Mapping[str, pd.DataFrame] | None = None) -> pd.DataFrame:
    """What the diagnosis of a recording says in numbers, and the scores on rows that it did not see.

    Parameters
    ----------
    results : Results
    linear : dict of DataFrame, optional
        Silverbox: output of linear models with held (``zoh``) and first-order-hold (``foh``) input for its multisine.

    Returns
    -------
    DataFrame
        Columns ``target``, ``quantity``, ``value``, ``standard_deviation``, ``unit``; no recorded sample.
    """
    rows: list[Row] = [*_common(results), *SPECIFIC[results.name](results)]
    for hold, table in (linear or {}).items():
        error = 1e3 * _root_mean_square((table["V2"] - table["simulated"])[SILVERBOX_TRANSIENT:])
        rows.append((f"multisine_linear_{hold}", error, None, "mV"))
    table = pd.DataFrame(rows, columns=["quantity", "value", "standard_deviation", "unit"])
    table.insert(0, "target", f"recording_{results.name}")
    return table


def _common(results: Results) -> Iterable[Row]:
    """Errors, effects and the second diagnosis."""
    diagnosis, residuals = results.diagnosis, results.residuals
    fitted = residuals["fitted"] == 1
    spread = float(residuals["recorded"][fitted].std(ddof=0))
    for model in MODELS:
        yield f"held_out_error_{model}", 100.0 * diagnosis["fit"][f"nrmse_{model}"], None, "%"
    for model in MODELS[1:]:
        error = _root_mean_square(residuals[f"residual_{model}"][fitted])
        yield f"fitted_error_{model}", 100.0 * error / spread, None, "%"
    learned = [effect for effect in diagnosis["effects"] if "knots" in effect]
    named = [effect for effect in diagnosis["effects"] if "knots" not in effect]
    yield "effects", float(len(named)), None, ""
    for law in learned:
        kind = "" if " over " in law["variables"] else f"{law['id'].removeprefix('learned-')} over "
        yield f"learned_{kind}{law['variables']}".replace(" ", "_"), 1.0, None, ""
    for effect in named:
        yield f"named_{effect['id']}", 1.0, None, ""
        for name, parameter in effect["parameters"].items():
            if isinstance(parameter["value"], str):
                yield f"{effect['id']}_{parameter['value']}", 1.0, None, ""
            else:
                unit = re.sub(r"\b[uy]\b", lambda match: UNITS[results.name][match[0]], parameter["unit"])
                yield f"{effect['id']}_{name}", parameter["value"], parameter["std"], unit
    unlisted = [a["weight"] for e in named for a in e["alternatives"] if a["id"] == "unlisted"]
    yield "weight_outside_catalogue", 100.0 * max(unlisted, default=0.0), None, "%"
    yield "structure_left", float(diagnosis["verdict"] in {"partly-explained", "unexplained"}), None, ""
    yield "again_adequate", float(results.again["verdict"] == "adequate"), None, ""


def _root_mean_square(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(np.asarray(values, float)))))


def _silverbox(results: Results) -> Iterable[Row]:
    """Resonance, damping and gain; root mean square errors on the published test sets."""
    for model in MODELS:
        (b0, _), (a1, _), (a0, spread) = (results.coefficient(c, model) for c in ("b0", "a1", "a0"))
        frequency = np.sqrt(a0)
        deviation = None if spread is None else spread / (4.0 * np.pi * frequency)
        yield f"natural_frequency_{model}", frequency / (2.0 * np.pi), deviation, "Hz"
        yield f"damping_ratio_{model}", a1 / (2.0 * frequency), None, ""
        yield f"static_gain_{model}", b0 / a0, None, "V/V"
    refitted = replace(results.nominal, plant=_plant(results, "refitted"))
    models = dict(zip(MODELS, (results.nominal, refitted, results.improved), strict=True))
    for part, (first, stop) in {"multisine": SILVERBOX_MULTISINE, "arrow": SILVERBOX_ARROW}.items():
        for model, simulation in models.items():
            period = float(results.nominal.reading.period or np.nan)
            reading = replace(simulation.reading, start=(first - 0.5) * period, end=(stop - 0.5) * period)
            table = simulate(results.recording, replace(simulation, reading=reading))
            error = table[simulation.output_column] - table["simulated"]
            yield f"{part}_{model}", 1e3 * _root_mean_square(error[SILVERBOX_TRANSIENT:]), None, "mV"


def _plant(results: Results, model: str) -> TransferFunction:
    """Second-order transfer function of a model."""
    b0, a1, a0 = (results.coefficient(c, model)[0] for c in ("b0", "a1", "a0"))
    return TransferFunction((b0,), (1.0, a1, a0))


def _emps(results: Results) -> Iterable[Row]:
    """Mass and viscous friction; the error of the position."""
    for model in MODELS:
        (b0, spread), (a1, _) = results.coefficient("b0", model), results.coefficient("a1", model)
        deviation = None
        if model == "improved" and results.improved.covariance is not None:
            lead = results.improved.plant.denominator[0]
            covariance = np.array(results.improved.covariance)[:2, :2] / lead**2
            slope = np.array([-a1 / b0**2, 1.0 / b0])
            deviation = float(np.sqrt(slope @ covariance @ slope))
        yield f"mass_{model}", 1.0 / b0, None if spread is None else spread / b0**2, "kg"
        yield f"viscous_friction_{model}", a1 / b0, deviation, "N s/m"
    for model in MODELS[1:]:
        yield f"position_error_{model}", 100.0 * results.diagnosis["fit"]["position"][f"nrmse_{model}"], None, "%"


def _pendulum_decay(results: Results) -> Iterable[Row]:
    """Frequency and damping; what is left over the whole record, from the release to the rest."""
    for model in MODELS:
        (a1, damping), (a0, stiffness) = results.coefficient("a1", model), results.coefficient("a0", model)
        deviation = None if stiffness is None else stiffness / (2.0 * np.sqrt(a0))
        yield f"natural_frequency_{model}", np.sqrt(a0), deviation, "rad/s"
        yield f"viscous_damping_{model}", a1, damping, "1/s"
    start, end = PENDULUM_WHOLE[results.name]
    reading = replace(results.improved.reading, start=start, end=end)
    improved = replace(results.improved, reading=reading, remainder=ANY_REMAINDER)
    # What was learned says nothing beyond the swings that it was learned from: the named laws are judged alone, too.
    named = tuple(effect for effect in improved.effects if effect.identifier in known_effects())
    for model, simulation in {"improved": improved, "named": replace(improved, effects=named)}.items():
        whole = diagnose(results.recording, simulation)
        if whole.known_remainder is None:
            raise ValueError(f"{results.name}: the simulation leaves more than {ANY_REMAINDER} rad of the record")
        error = _root_mean_square(whole.signals.recorded - whole.signals.improved)
        yield f"whole_record_error_{model}", 100.0 * error / float(np.std(whole.signals.recorded)), None, "%"


def _pendulum_clip(results: Results) -> Iterable[Row]:
    """Period, length of a mathematical pendulum of that period, and what is left."""
    for model in MODELS:
        a0, spread = results.coefficient("a0", model)
        period = 2.0 * np.pi / np.sqrt(a0)
        yield f"period_{model}", period, None if spread is None else period * spread / (2.0 * a0), "s"
        yield f"length_{model}", GRAVITY / a0, None if spread is None else GRAVITY * spread / a0**2, "m"
    for model in MODELS[1:]:
        yield f"residual_{model}", _root_mean_square(results.residuals[f"residual_{model}"]), None, "px"


def _coupled_drives(results: Results) -> Iterable[Row]:
    """Resonance of belt and spring, and the motors' time constant, from the poles."""
    for model in MODELS:
        a2, a1, a0 = (results.coefficient(c, model)[0] for c in ("a2", "a1", "a0"))
        poles = np.roots([1.0, a2, a1, a0])
        vibrating = poles[poles.imag > 0.0]
        if len(vibrating) == 1:
            yield f"resonance_{model}", float(abs(vibrating[0])), None, "rad/s"
            yield f"time_constant_{model}", float(-1.0 / poles[np.argmin(abs(poles.imag))].real), None, "s"


def _cascaded_tanks(results: Results) -> Iterable[Row]:
    """Errors on the rows of the validation record that no fit used, and on all of it."""
    table = results.residuals
    whole = table[table["recording"] == table["recording"].max()]
    unseen = whole[whole["fitted"] == 0]
    for model in MODELS:
        yield f"validation_{model}", _root_mean_square(unseen["recorded"] - unseen[model]), None, "V"
        yield f"whole_validation_{model}", _root_mean_square(whole["recorded"] - whole[model]), None, "V"


SPECIFIC: dict[str, Callable[[Results], Iterable[Row]]] = {
    "silverbox": _silverbox,
    "emps": _emps,
    "pendulum_decay": _pendulum_decay,
    "pendulum_clip": _pendulum_clip,
    "pendulum2_decay": _pendulum_decay,
    "coupled_drives": _coupled_drives,
    "cascaded_tanks": _cascaded_tanks,
}
