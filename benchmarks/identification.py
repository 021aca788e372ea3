"""Time and error of one fit of the paper's task: camid against each peer, interleaved in one process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.peers import PEERS, Peer
from benchmarks.report import Goal, Report, number
from benchmarks.task import IDENTIFICATION, Recording, excitation, generator, nominal, plant, record, truth
from benchmarks.timing import silence, timed
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.identification.accuracy import cramer_rao_bound
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, parameter_vector

Array = NDArray[np.float64]

PERIODS = (0.02, 0.1, 0.3)  # s
SEEDS = 60  # noise samples; slow peers get the first few of them
GROSS = 0.5  # relative error of a parameter from which on a fit counts as failed
FEW_FITS = 10  # fewer say little about an rms error
EQUAL = 1.2  # rms errors up to this multiple of camid's count as equal accuracy
CAMID = "camid"
LARGEST_WARM_TIME = 1.0  # ms


def camid_fit(recording: Recording, start: Array | None) -> Array:
    """[b0, a1, a0] by camid, which models hold and camera itself and needs no shifted pairs."""
    believed = None if start is None else TransferFunction((start[0],), (1.0, start[1], start[2]))
    acquisition = Acquisition(recording.period)
    used = np.ones(len(recording.output), bool)
    experiment = Experiment(recording.signal, recording.output, acquisition, used)
    found = estimate(Structure.of_order(2, 0), [experiment], nominal=believed).plant.monic
    return parameter_vector(found.numerator, found.denominator)


TOOLS = (
    Peer(CAMID, "camid", "camid", "none", lambda recording, _: camid_fit(recording, None)),
    Peer(CAMID, "camid", "camid", "nominal", camid_fit),
    *PEERS,
)


@dataclass(frozen=True)
class Fit:
    """One fit: relative errors of b0, a1, a0 (not finite if it raised) and its wall time in ms."""

    errors: Array
    milliseconds: float
    failure: str = ""

    @property
    def gross(self) -> bool:
        """Whether the fit raised, or missed a parameter by more than `GROSS`."""
        return not bool(np.all(np.abs(self.errors) <= GROSS))


def fit_once(tool: Peer, recording: Recording) -> Fit:
    """Time one fit; what a tool raises is a result, too."""
    try:
        found, seconds = timed(lambda: tool.identify(recording, nominal()))
    except Exception as error:
        return Fit(np.full(3, np.nan), np.nan, f"{type(error).__name__}: {error}")
    return Fit(np.asarray(found) / truth() - 1.0, 1e3 * seconds)


def interleaved_fits(tools: tuple[Peer, ...], period: float, seeds: int) -> dict[int, list[Fit]]:
    """Fits of every tool at one sampling period, by the tool's index; every noise sample goes through all tools."""
    index = PERIODS.index(period)
    signal = excitation()
    present = [i for i, tool in enumerate(tools) if not tool.missing()]
    fits: dict[int, list[Fit]] = {i: [] for i in range(len(tools))}
    with silence():
        for i in present:  # the first call, which imports and compiles, does not count
            fit_once(tools[i], record(signal, period, generator(IDENTIFICATION, index, seeds)))
        for seed in range(seeds):
            recording = record(signal, period, generator(IDENTIFICATION, index, seed))
            # No tool always runs after the same neighbour.
            for i in present[seed % len(present) :] + present[: seed % len(present)]:
                if seed < tools[i].most_seeds:
                    fits[i].append(fit_once(tools[i], recording))
    return fits


def median(values: list[float]) -> float:
    """Median, or no number where there is none."""
    return float(np.median(values)) if values else float("nan")


def rms_percent(fits: list[Fit]) -> Array:
    """Root mean square errors of b0, a1, a0 in percent, without gross failures; not finite if nothing is left."""
    errors = np.array([fit.errors for fit in fits if not fit.gross])
    return 100.0 * np.sqrt(np.mean(errors**2, axis=0)) if len(errors) else np.full(3, np.nan)


def rows_of(tools: tuple[Peer, ...], period: float, seeds: int) -> Iterator[dict[str, object]]:
    """Rows of the table for one sampling period, the Cramér–Rao bound first."""
    recording = record(excitation(), period, generator(IDENTIFICATION, PERIODS.index(period), 0))
    covariance = cramer_rao_bound(plant(), recording.signal, Acquisition(period), recording.noise_variance)
    bound = 100.0 * np.sqrt(np.diag(covariance)) / truth()
    errors = {f"rms_{p}": b for p, b in zip(PARAMETERS, bound, strict=True)}
    yield {"period": period, "tool": "Cramér–Rao bound", "version": "", "start": "", **errors, "to_bound": 1.0}
    fits = interleaved_fits(tools, period, seeds)
    times = {i: median([fit.milliseconds for fit in found if not fit.failure]) for i, found in fits.items()}
    own = {tool.start: i for i, tool in enumerate(tools) if tool.name == CAMID}
    for i, tool in enumerate(tools):
        rms, gross = rms_percent(fits[i]), sum(fit.gross for fit in fits[i])
        camid = fits[own[tool.start]][: len(fits[i])]  # on the same noise samples
        equal = bool(np.all(rms <= EQUAL * rms_percent(camid))) and gross <= sum(fit.gross for fit in camid)
        raised = [fit.failure for fit in fits[i] if fit.failure]
        yield {
            "period": period,
            "tool": tool.name,
            "version": tool.version(),
            "start": tool.start,
            "fits": len(fits[i]),
            "milliseconds": times[i],
            "to_camid": times[i] / times[own[tool.start]],
            **{f"rms_{p}": r for p, r in zip(PARAMETERS, rms, strict=True)},
            "to_bound": float(np.sqrt(np.mean((rms / bound) ** 2))),
            "gross_failures": gross,
            "equal_accuracy": equal,
            "raised": f"{len(raised)}, e.g. {raised[0]}" if raised else "",
            "missing": tool.missing(),
        }


def people_table(table: pd.DataFrame) -> pd.DataFrame:
    """The table in words and rounded numbers."""
    rows = []
    for _, row in table.iterrows():
        bound = row["tool"] == "Cramér–Rao bound"
        ran = not bound and row["fits"] > 0
        equal = ran and row["equal_accuracy"] and row["tool"] != CAMID
        doubt = f", on {row['fits']:.0f} fits" if ran and row["fits"] < FEW_FITS else ""
        rows.append(
            {
                "T in s": f"{row['period']:g}",
                "tool": f"{row['tool']} {row['version']}".strip(),
                "start": row["start"] if not bound else "",
                "ms a fit": number(row["milliseconds"]) if ran else "",
                "time / camid's": number(row["to_camid"], 2) if ran else "",
                "rms error of b0 / a1 / a0 in %": " / ".join(number(row[f"rms_{p}"], 2) for p in PARAMETERS),
                "error / bound": number(row["to_bound"], 2),
                "gross failures": f"{row['gross_failures']:.0f} of {row['fits']:.0f}" if ran else "",
                "equal accuracy": f"yes{doubt}" if equal else "",
                "not run because": row["missing"] if isinstance(row["missing"], str) else "",
            }
        )
    shown = pd.DataFrame(rows)
    return shown if shown["not run because"].any() else shown.drop(columns="not run because")


def run(periods: tuple[float, ...] = PERIODS, seeds: int = SEEDS, tools: tuple[Peer, ...] = TOOLS) -> Report:
    """Compare all tools at each sampling period."""
    table = pd.DataFrame([row for period in periods for row in rows_of(tools, period, seeds)])
    warm = table[(table["tool"] == CAMID) & (table["start"] == "nominal")]
    samples = len(excitation()) - 1
    return Report(
        "identification",
        "One fit of the paper's task",
        f"b0, a1 and a0 of G0 from {samples} PRBS samples in noise of 10 dB. Median wall time of a fit, first call "
        "excluded, all tools in turn on each noise sample. Start *none*: the tool is given the order only; *nominal*: "
        "a plant whose coefficients are 10 % off; the times are compared with camid's from the same start. The rms "
        f"errors leave out gross failures (a parameter more than {100 * GROSS:.0f} % off, or an exception; most are "
        "pairs of sampled poles that noise has moved onto the negative real axis, from where no continuous-time model "
        "of second order leads back). Error / "
        "bound: root mean square over the three parameters of rms error over Cramér–Rao bound. Equal accuracy: no rms "
        f"error above {EQUAL:g} times camid's on the same noise samples, and no more gross failures.",
        table,
        people_table(table),
        [
            Goal(
                f"a warm fit of {samples} samples, order 2, at T = {row['period']:g} s takes {LARGEST_WARM_TIME:g} ms "
                "or less",
                row["milliseconds"],
                LARGEST_WARM_TIME,
            )
            for _, row in warm.iterrows()
        ],
    )
