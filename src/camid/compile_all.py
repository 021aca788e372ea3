"""Compile everything that camid compiles, once per installation: ``python -m camid.compile_all``.

Each part runs a small example of what it compiles, so that exactly the argument types of real use are compiled; the
parts share out among the processors. What is in the folder of :mod:`camid.compiled` already costs nothing. One part
lets Python compile the modules that commands import: where it may not keep them later, because the installation is
read-only or the shell forbids it, a diagnosis would spend seconds on that each time.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

import numpy as np
from numpy.typing import NDArray

from camid.compiled import folder, keep_quiet

Array = NDArray[np.float64]

PERIOD = 0.05
# What is imported late.
LATE_MODULES = (
    *(f"camid.commands.{name}" for name in ("diagnose", "design", "identify", "simulate")),
    *(f"scipy.{name}" for name in ("interpolate", "ndimage", "optimize", "signal", "sparse", "stats")),
    "ruamel.yaml",
    "rich.console",
    "rich.progress",
    "rich.table",
)


def modules() -> None:
    """Python's own modules: those of the commands, and of the packages that they import where they need them."""
    from importlib import import_module
    from importlib.util import find_spec

    for name in LATE_MODULES:
        import_module(name)
    if find_spec("matplotlib") is not None:  # it comes with camid[plots]
        from camid.diagnosis.report.page import load

        load()


def engine() -> None:
    """The integrator, and how a sensor reads its motion."""
    from camid.chain.acquisition import Acquisition
    from camid.chain.plant import second_order
    from camid.effects import known_effects
    from camid.effects.base import Effect
    from camid.engine.mechanics import Chain
    from camid.engine.run import move

    kind = next(e for e in known_effects().values() if e.friction_level is not None)
    friction = kind(**{parameter.name: 0.1 for parameter in kind.parameters})
    motion = move(Chain(second_order(1.0, 10.0, 0.1), Acquisition(PERIOD), (friction,)), _signal(30), _time(30))
    motion.mean(_time(30), _time(30) + PERIOD)
    motion.mean_over_path(_time(30), _time(30) + PERIOD)
    for kind in known_effects().values():
        if kind.carry is not Effect.carry:
            kind(**{parameter.name: 0.1 for parameter in kind.parameters}).carry(motion)


def learned_laws() -> None:
    """The derivatives of a run by the values of a law."""
    from camid.chain.acquisition import Acquisition
    from camid.chain.plant import second_order
    from camid.effects.learned import LearnedForce
    from camid.engine.law_derivatives import by_law
    from camid.engine.mechanics import Chain

    law = LearnedForce(variables="velocity", knots=[-1.0, 0.0, 1.0], values=[-0.1, 0.0, 0.1])
    chain = Chain(second_order(1.0, 10.0, 0.1), Acquisition(PERIOD), (law,), steps=2)
    by_law(chain, _signal(30), _time(30), 0, np.eye(3), 1e-4)


def effects() -> None:
    """The forces of all effects, and the actuators that remember."""
    from camid.effects import known_effects
    from camid.effects.compiled_part import Compiled
    from camid.effects.pendulum import SineRestoringForce

    finer = [law for kind in known_effects().values() for law in kind.finer_laws]
    for kind in (*known_effects().values(), *finer, SineRestoringForce):
        for name in dir(kind):
            part = getattr(kind, name)
            if isinstance(part, Compiled):
                _ = part.address
    signal = _signal(30)
    for kind in known_effects().values():
        if kind.transforms_by_compiled_code:
            kind(**{parameter.name: 0.1 for parameter in kind.parameters}).transform(signal, signal, PERIOD)


def identification() -> None:
    """Simulated output with its sensitivities, and the default method."""
    from camid.identification.estimate import estimate
    from camid.identification.structure import Structure

    estimate(Structure.of_order(2, 0), [_experiment()])


def starts() -> None:
    """Starting values, the noise that is left, and the method without safeguard."""
    from camid.chain.plant import second_order
    from camid.identification.accuracy import cramer_rao_bound, innovation_variance
    from camid.identification.discrete_time_start import discrete_time_poles

    experiment = _experiment()
    discrete_time_poles(experiment, 2)
    innovation_variance(experiment)
    cramer_rao_bound(second_order(1.0, 10.0, 0.1), experiment.signal, experiment.acquisition, 1.0)


def images() -> None:
    """Images of a marker."""
    from camid.images.forming import FrameFormat, Marker, circular_path, expose

    expose(circular_path((10.0, 10.0), 4.0, 1.0), 0.0, 0.01, Marker(3.0), FrameFormat(20, 20))


def concealed() -> None:
    """The generator of concealed recordings."""
    from camid.proof.concealed import vector_layout as layout
    from camid.proof.concealed.input_path import held, play, slew
    from camid.proof.concealed.machine_integrator import integrate

    parameters = np.zeros(layout.PARAMETERS)
    parameters[[layout.MASS, layout.DAMPING, layout.STIFFNESS, layout.TOP_SPEED]] = 1.0
    segments = held(_time(30), _signal(30))
    for path in (play(0.1, 0.0), slew(1.0)):
        path(segments, PERIOD)
    integrate(parameters, segments, PERIOD, 0, 3)


# What takes longest comes first, so that no processor waits at the end.
PARTS: tuple[Callable[[], None], ...] = (
    learned_laws,
    identification,
    engine,
    modules,
    starts,
    concealed,
    effects,
    images,
)


def _signal(count: int) -> Array:
    levels = np.random.default_rng(1).choice([-1.0, -0.5, 0.3, 1.0], count // 3 + 1)
    return np.array(np.repeat(levels, 3)[:count], dtype=np.float64)


def _time(count: int) -> Array:
    return np.array([PERIOD * k for k in range(count)], dtype=np.float64)


def _experiment():  # type: ignore[no-untyped-def]
    """A noisy recording with an unknown initial state."""
    from camid.chain.acquisition import Acquisition
    from camid.chain.exact import sample
    from camid.chain.plant import second_order
    from camid.identification.experiment import Experiment

    acquisition, signal = Acquisition(PERIOD), _signal(300)
    output = sample(second_order(1.0, 10.0, 0.1), signal, acquisition)
    output += 0.1 * np.random.default_rng(2).standard_normal(len(output))
    return Experiment(signal, output, acquisition, np.ones(len(output), bool), True)


def _timed(part: str) -> tuple[str, float]:
    """Name of a part and the seconds that it took."""
    keep_quiet()
    begun = time.perf_counter()
    globals()[part]()
    return part, time.perf_counter() - begun


def main() -> None:
    """Compile all parts with a line of progress."""
    begun = time.perf_counter()
    folder()
    names = [part.__name__ for part in PARTS]
    workers = min(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1, len(names))
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting = [pool.submit(_timed, name) for name in names]
        for done, future in enumerate(as_completed(waiting), start=1):
            name, _ = future.result()
            print(f"\rcompiling camid: {done} of {len(names)} ({name})".ljust(60), end="", file=sys.stderr, flush=True)
    print(f"\rcompiled camid in {time.perf_counter() - begun:.0f} s".ljust(60), file=sys.stderr)


if __name__ == "__main__":
    main()
