"""Diagnoses with realistic numbers and signals, one a verdict, for the tests of what is written of them."""

from __future__ import annotations

import numpy as np

from camid.chain.plant import TransferFunction
from camid.diagnosis.diagnosis import Coefficient, Diagnosis, Location, Signals, StructureTest, Undetectable
from camid.diagnosis.effect_signals import EffectSignals
from camid.diagnosis.finding import Finding, ParameterEstimate
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.provenance import FILE_TIME, Provenance, RecordedFile
from camid.simulation.model import Simulation

PERIOD, COUNT, STEPS = 0.02, 2044, 10
FORCE, NOISE = 0.15, 0.012
NATURAL_FREQUENCY, DAMPING = 10.0, 0.06


def motion(signal, damping, force):
    """Position and velocity at the frames of a mass on a spring with viscous and Coulomb friction.

    Parameters
    ----------
    signal : ndarray, shape (N,)
        Input, held over a period.
    damping : float
        Ratio.
    force : float
        Coulomb friction in units of the input.

    Returns
    -------
    position, velocity : ndarray, shape (N,)
    """
    position, velocity = np.zeros(len(signal)), np.zeros(len(signal))
    y = v = 0.0
    step = PERIOD / STEPS
    for k, u in enumerate(signal.tolist()):
        position[k], velocity[k] = y, v
        for _ in range(STEPS):
            pull = u - force * np.tanh(v / 0.02)
            v += step * (NATURAL_FREQUENCY**2 * (pull - y) - 2.0 * damping * NATURAL_FREQUENCY * v)
            y += step * v
    return position, velocity


def signals(seed, force=FORCE, *, held_input=True):
    """Recorded and simulated signals of a rig with Coulomb friction that the simulation leaves out.

    The refitted simulation has more damping, as a fit without friction would; so its residual force is the friction
    less what that damping takes.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed))
    levels = random.choice([-1.0, -0.5, 0.5, 1.0], size=COUNT // 8 + 1) if held_input else np.zeros(COUNT // 8 + 1)
    signal = np.repeat(levels, 8)[:COUNT]
    if not held_input:
        signal[:20] = 1.0
    true, velocity = motion(signal, DAMPING, force)
    extra = 0.06 if force else 0.0
    nominal, _ = motion(signal, 0.7 * DAMPING, 0.0)
    refitted, refitted_velocity = motion(signal, DAMPING + extra, 0.0)
    noise = NOISE * random.standard_normal(COUNT)
    smooth = np.convolve(random.standard_normal(COUNT), np.ones(5) / 5.0, mode="same")
    equivalent = -force * np.tanh(velocity / 0.02) + 2.0 * extra / NATURAL_FREQUENCY * velocity + 0.06 * smooth
    equivalent[:3] = np.nan
    time = PERIOD * np.arange(COUNT)
    fitted = (time < 24.0) | (time >= 34.0)
    return Signals(
        time=time,
        signal=signal,
        recorded=true + noise,
        nominal=nominal,
        refitted=refitted,
        improved=true if force else refitted,
        position=refitted,
        velocity=refitted_velocity,
        equivalent_input=equivalent,
        fitted=fitted,
        validates=~fitted,
    )


def finding():
    """Coulomb friction with a rival."""
    return Finding(
        identifier="coulomb-friction",
        place="plant",
        title="Coulomb friction",
        equation=r"f = f_c\,\mathrm{sgn}(\dot{y})",
        reference="Armstrong-Hélouvry, Dupont & Canudas de Wit, Automatica 30(7), 1994",
        parameters={"force": ParameterEstimate(FORCE, 0.0021, "u")},
        evidence={
            "share": 0.953,
            "delta_bic": 4321.7,
            "validation_gain": 0.948,
            "nrmse_without": 0.2423,
            "false_alarm_probability": 1e-12,
        },
        weight=0.88,
        alternatives=[("hysteresis", 0.11), ("unlisted", 0.01)],
        separating_experiment="a free decay, or slow small reversals: hysteresis yields before it slides.",
    )


def second_finding():
    """A periodic force with three parameters of different sizes."""
    return Finding(
        identifier="periodic-disturbance",
        place="disturbance",
        title="Periodic disturbance",
        equation=r"d = a\,\sin(\omega t + \varphi)",
        reference="Ljung, System Identification, 1999, section 2.2",
        parameters={
            "amplitude": ParameterEstimate(3.21e-7, 4.4e-9, "u"),
            "frequency": ParameterEstimate(7.5612, 0.0019, "rad/s"),
            "phase": ParameterEstimate(0.42, 0.05, "rad"),
        },
        evidence={
            "share": 0.021,
            "delta_bic": 44.0,
            "validation_gain": 0.019,
            "nrmse_without": 0.1023,
            "false_alarm_probability": 3e-6,
        },
    )


def effect_signals(shown, findings):
    """What the recording shows of each of these effects that is a force: its law, smoothed, and noise."""
    random = np.random.default_rng(np.random.SeedSequence(17))
    laws = {
        "coulomb-friction": -FORCE * np.sign(shown.velocity),
        "periodic-disturbance": 0.05 * np.sin(7.5612 * shown.time + 0.42),
    }
    found = []
    for each in findings:
        if each.identifier in laws:
            law = laws[each.identifier]
            seen = np.convolve(law, np.ones(5) / 5.0, mode="same")
            data = seen + 0.02 * random.standard_normal(len(law))
            rate = np.gradient(shown.position, PERIOD)
            found.append(EffectSignals(each.identifier, shown.position, shown.velocity, rate, data, law, seen))
    return found


PROVENANCE = Provenance(
    "camid diagnose bench/run_07.csv --simulation S.yaml --output found",
    "S.yaml",
    [RecordedFile("bench/run_07.csv", "0123456789abcdef" * 4, "2026-05-04 03:02:01 UTC", FILE_TIME)],
    {"camid": "0.1.0", "Python": "3.12.1", "NumPy": "2.1.0", "SciPy": "1.14.0"},
)
UNDETECTABLE = [
    Undetectable("dead-zone", "the input never is smaller than 0.5: a dead zone is a smaller gain"),
    Undetectable("quadratic-drag", "not needed", "coefficient", 0.0041, "u s^2/y^2"),
    Undetectable("cubic-stiffness", "not needed", "coefficient", 0.0123, "u/y^3"),
    Undetectable("delay", "not needed", "delay", 0.00031, "s"),
    Undetectable("backlash", "not needed", "half_width", 0.021, "u"),
    Undetectable("sensor-offset", "the same as a bias of the input for a plant with a static gain"),
]


def diagnosis(verdict, *, seed=7, **changes):
    """A diagnosis with this verdict.

    Parameters
    ----------
    verdict : str
    seed : int
    **changes
        Attributes of the Diagnosis, and ``input_column`` and ``output_column``.
    """
    columns = {"input_column": "u", "output_column": "y"}
    columns |= {key: changes.pop(key) for key in list(changes) if key in columns}
    improved = Simulation("t", plant=TransferFunction((100.0,), (1.0, 1.2, 100.0)), exposure=0.02, **columns)
    shown = signals(seed, 0.0 if verdict == "adequate" else FORCE)
    places = {"plant": 0.89, "actuator": 0.02, "sensor": 0.01, "disturbance": 0.08, "noise": 0.0}
    state = ("velocity", -2.5, 2.5)
    content = {
        "adequate": {
            "explanation": "With its coefficients re-estimated, the simulation leaves 6.1 % of the output's standard "
            "deviation on rows that were not fitted; the noise alone leaves 6.0 %. No test finds structure.",
            "location": Location(),
            "findings": [],
            "fit": NormalisedErrors(0.0631, 0.0612, 0.0612, 0.0604, (24.0, 34.0)),
        },
        "explained": {
            "explanation": "Coulomb friction of 0.150 ± 0.002 removes 95 % of the error that re-estimated "
            "coefficients leave. On rows that were not fitted the error falls from 24.1 % to 4.2 %; the noise alone "
            "leaves 4.1 %.",
            "location": Location("plant", places, state=state),
            "findings": [finding()],
            "fit": NormalisedErrors(0.684, 0.241, 0.0421, 0.0412, (24.0, 34.0)),
        },
        "partly-explained": {
            "explanation": "Coulomb friction and a periodic disturbance remove 97 % of the error. What is left is "
            "still three times the noise and depends on the velocity.",
            "location": Location("plant", places, time=(12.0, 31.0), frequency=(1.1, 2.3), state=state),
            "findings": [finding(), second_finding()],
            "fit": NormalisedErrors(0.684, 0.241, 0.0921, 0.0312, (24.0, 34.0), chosen=False),
        },
        "unexplained": {
            "explanation": "The recording holds a structured error of 24 % that no effect of the catalogue explains. "
            "It acts at the plant and depends on the velocity.",
            "location": Location("plant", places, state=state),
            "findings": [],
            "fit": NormalisedErrors(0.684, 0.241, 0.241, 0.0412, (24.0, 34.0)),
        },
    }[verdict]
    after = 0.38 if verdict in {"adequate", "explained"} else 2e-9
    before = 0.38 if verdict == "adequate" else 0.0
    tests = [
        StructureTest("lack of fit", "Is the residual larger than the noise?", before, after),
        StructureTest("whiteness", "Does the residual depend on its own past?", before, after),
        StructureTest("independence", "Does the residual depend on the input?", 0.21, 0.4),
        StructureTest("non-repeatability", "Does it differ between periods of the input?", None, None),
    ]
    coefficients = [
        Coefficient("b0", 100.0, 93.21, 1.1, 100.07, 0.42),
        Coefficient("a1", 0.84, 3.62, 0.21, 1.203, 0.034),
        Coefficient("a0", 100.0, 97.8, 0.9, 100.11, 0.19),
    ]
    content |= {"undetectable": UNDETECTABLE, "coefficients": coefficients, "tests": tests, "signals": shown}
    content |= {"recordings": ["bench/run_07.csv"], "rows_fitted": 1544, "period": PERIOD, "seconds": 2.31}
    content |= {"provenance": PROVENANCE, "structured": verdict in {"partly-explained", "unexplained"}} | changes
    content = {"effect_signals": effect_signals(content["signals"], content["findings"])} | content
    return Diagnosis(verdict=verdict, improved=improved, **content)
