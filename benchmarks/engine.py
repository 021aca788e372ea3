"""Time of the engine beside scipy's adaptive integrator of comparable accuracy, for forces that follow the motion."""

from __future__ import annotations

from math import exp

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

from benchmarks.report import Goal, Report, number
from benchmarks.timing import alternate
from camid.chain.acquisition import Acquisition
from camid.chain.plant import second_order
from camid.effects import damping, friction, hysteresis, stiffness
from camid.engine.mechanics import Chain
from camid.engine.run import run as simulate

FRAMES, PERIOD, ROUNDS = 2000, 0.02, 15
PEER_FRAMES = 100  # scipy takes seconds for all
PLANT = second_order(1.0, 10.0, 0.1)
LIMIT = 3e-3
EFFECTS = {
    "cubic stiffness": (stiffness.CubicStiffness(coefficient=0.1), lambda y, v, z: 0.1 * y**3, None),
    "quadratic drag": (damping.QuadraticDrag(coefficient=0.005), lambda y, v, z: 0.005 * abs(v) * v, None),
    "end stop": (stiffness.EndStop(position=1.0, stiffness=5.0), lambda y, v, z: 5.0 * max(y - 1.0, 0.0), None),
    "Coulomb friction": (friction.CoulombFriction(force=0.1), lambda y, v, z: 0.1 * np.tanh(v / 1e-3), None),
    "Stribeck friction": (
        friction.StribeckFriction(coulomb=0.1, breakaway=0.16, velocity=2.0),
        lambda y, v, z: (0.1 + 0.06 * exp(-((v / 2.0) ** 2))) * np.tanh(v / 1e-3),
        None,
    ),
    "hysteresis": (
        hysteresis.Hysteresis(strength=0.1, shape=2.0),
        lambda y, v, z: 0.1 * z,
        lambda v, z: 2.0 * (v - 0.5 * abs(v) * z - 0.5 * v * abs(z)),
    ),
}


def peer(signal: np.ndarray, force, memory, tolerance: float) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Camera samples by LSODA, restarted at each sample of the held input; dry friction is a steep tanh there."""
    state = np.zeros(4)  # y, ẏ, the integral of y, and the inner state
    integrals = [0.0]
    for value in signal[:-1]:

        def slope(_time, x, value=value):  # type: ignore[no-untyped-def]
            y, v, _, z = x
            rate = 0.0 if memory is None else memory(v, z)
            return [v, 100.0 * (value - force(y, v, z)) - 2.0 * v - 100.0 * y, y, rate]

        state = solve_ivp(slope, (0.0, PERIOD), state, method="LSODA", rtol=tolerance, atol=1e-2 * tolerance).y[:, -1]
        integrals.append(state[2])
    return np.diff(integrals, prepend=0.0) / PERIOD


def run() -> Report:
    """Measure."""
    signal = np.repeat(np.random.default_rng(1).choice([-1.0, -0.5, 0.3, 1.0], FRAMES // 4), 4)
    time = PERIOD * np.arange(FRAMES)
    rows = []
    for name, (effect, force, memory) in EFFECTS.items():
        chain, short = Chain(PLANT, Acquisition(PERIOD), (effect,)), signal[:PEER_FRAMES]
        calls = {
            "camid": lambda _round, chain=chain: simulate(chain, signal, time),
            "scipy": lambda _round, short=short, force=force, memory=memory: peer(short, force, memory, 1e-6),
        }
        times = alternate({"camid": calls["camid"]}, ROUNDS) | alternate({"scipy": calls["scipy"]}, 2)
        found = simulate(chain, short, time[:PEER_FRAMES])
        other, exact = peer(short, force, memory, 1e-6), peer(short, force, memory, 1e-10)
        scale = float(np.std(exact))
        rows.append(
            {
                "effect": name,
                "camid_seconds": times["camid"],
                "scipy_seconds": times["scipy"] * FRAMES / PEER_FRAMES,
                "camid_difference": float(np.max(np.abs(found - exact))) / scale,
                "scipy_difference": float(np.max(np.abs(other - exact))) / scale,
            }
        )
    table = pd.DataFrame(rows)
    shown = pd.DataFrame(
        {
            "effect": table["effect"],
            "ms, camid": [number(1e3 * t) for t in table["camid_seconds"]],
            "ms, scipy LSODA": [number(1e3 * t) for t in table["scipy_seconds"]],
            "camid's difference": [f"{x:.1e}" for x in table["camid_difference"]],
            "LSODA's difference": [f"{x:.1e}" for x in table["scipy_difference"]],
        }
    )
    slowest = float(table["camid_seconds"].max())
    return Report(
        "engine",
        "Simulation with an effect",
        f"{FRAMES} frames of a second-order plant at T ω₀ = 0.2 with a held input and a camera, median of "
        f"{ROUNDS} runs. scipy's LSODA (relative tolerance 1e-6, restarted at each sample of the input, forces in "
        f"plain Python) was timed on {PEER_FRAMES} frames. Differences are the largest from LSODA at 1e-10, in "
        "standard deviations of the output; dry friction is a tanh of v / (0.001 y/s) in LSODA and exact in camid, "
        "which is most of the difference there.",
        table,
        shown,
        [Goal("slowest simulation of 2 000 frames with one effect, ms", 1e3 * slowest, 1e3 * LIMIT)],
    )
