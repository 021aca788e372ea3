"""One adapter a peer: from 511 pairs of the paper's task to [b0, a1, a0].

The camera's mean over the period with a held input equals one delay times the first-order-hold equivalent of the plant,
so every peer gets the pairs u_k, w_{k+1} and either that hold (tools with a continuous-time model) or a discrete-time
model of second order with direct term (all others), whose poles are taken to continuous time by the logarithm and whose
gain is kept at zero frequency. What was tried for each peer is in README.md.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, signal

from benchmarks.task import Recording

Array = NDArray[np.float64]
Identify = Callable[[Recording, Array], Array]

ORDER = 2
# Starting grid of the output error by scipy: natural frequencies as shares of the Nyquist frequency, damping ratios.
GRID_FREQUENCIES, GRID_DAMPINGS = np.geomspace(0.02, 1.0, 16), (0.05, 0.3, 0.8)
BLOCK_ROWS = (
    20  # horizon of the subspace methods: of 5, 10, 15, 20 and 30 the best at T = 0.1 s, on other noise samples
)
LONGEST_STEP = 0.05  # s, of the integrator that jax-sysid uses: errors of 3e-5 without noise


@dataclass(frozen=True)
class Peer:
    """A tool and how it is called.

    Attributes
    ----------
    name : str
        As in the tables.
    package, distribution : str
        What is imported and what is installed.
    start : {"none", "nominal"}
        Whether the tool is given the nominal plant.
    identify : callable
        From a `Recording` and the nominal [b0, a1, a0] to the estimated [b0, a1, a0].
    most_seeds : int
        Noise samples that there is time for.
    """

    name: str
    package: str
    distribution: str
    start: str
    identify: Identify
    most_seeds: int = 10**6

    def missing(self) -> str:
        """Why the peer cannot be run, or an empty text."""
        try:
            importlib.import_module(self.package)
        # Whatever an import raises is the reason wanted.
        except Exception as error:
            return f"{self.distribution} cannot be imported: {type(error).__name__}: {error}"
        return ""

    def version(self) -> str:
        """Installed version, or a dash."""
        try:
            return metadata.version(self.distribution)
        except metadata.PackageNotFoundError:
            return "–"


def from_discrete(poles: ArrayLike, static_gain: float, period: float) -> Array:
    """[b0, a1, a0] of the continuous-time mode with these sampled poles and static gain.

    Raises
    ------
    ValueError
        If the poles are those of no real continuous-time model of second order: one at zero, or on the negative axis.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        coefficients = np.poly(np.log(np.asarray(poles, dtype=complex)) / period)
    if len(coefficients) != ORDER + 1 or not np.all(np.isfinite(coefficients)):
        raise ValueError("a pole at zero has no logarithm")
    if np.max(np.abs(coefficients.imag)) > 1e-6 * np.max(np.abs(coefficients)):
        raise ValueError("a pole on the negative real axis has no real logarithm")
    _, a1, a0 = coefficients.real
    return np.array([static_gain * a0, a1, a0])


def from_state_space(a: Array, b: Array, c: Array, d: Array, period: float) -> Array:
    """[b0, a1, a0] of a discrete-time state-space model."""
    a, b, c, d = (np.atleast_2d(np.asarray(m, dtype=float)) for m in (a, b, c, d))
    gain = d + c @ np.linalg.solve(np.eye(len(a)) - a, b)
    return from_discrete(np.linalg.eigvals(a), float(gain[0, 0]), period)


def scipy_output_error(recording: Recording, start: Array | None) -> Array:
    """Output error by ``scipy.optimize.least_squares`` through ``cont2discrete(…, "foh")``, from a grid or a start."""
    given, measured = recording.pairs()

    def simulate(frequency: float, damping: float) -> Array:
        system = ([frequency**2], [1.0, 2.0 * damping * frequency, frequency**2])
        numerator, denominator, _ = signal.cont2discrete(system, recording.period, "foh")
        return signal.lfilter(numerator.ravel(), denominator, given)

    if start is None:
        candidates = []
        for frequency in GRID_FREQUENCIES * np.pi / recording.period:
            for damping in GRID_DAMPINGS:
                simulated = simulate(frequency, damping)
                gain = (simulated @ measured) / (simulated @ simulated)
                candidates.append((np.sum((measured - gain * simulated) ** 2), gain, frequency, damping))
        _, gain, frequency, damping = min(candidates)
    else:
        gain, frequency, damping = start[0] / start[2], np.sqrt(start[2]), 0.5 * start[1] / np.sqrt(start[2])
    solution = optimize.least_squares(
        lambda p: p[0] * simulate(np.exp(p[1]), p[2]) - measured, [gain, np.log(frequency), damping], method="lm"
    )
    gain, frequency, damping = solution.x[0], np.exp(solution.x[1]), solution.x[2]
    return np.array([gain * frequency**2, 2.0 * damping * frequency, frequency**2])


def pysib_method(method: str) -> Identify:
    """Adapter of pysib's output error or Steiglitz–McBride, three numerator and two denominator coefficients."""

    def identify(recording: Recording, _nominal: Array) -> Array:
        model = getattr(importlib.import_module("pysib"), method)(*recording.pairs(), 3, ORDER, 0)[1]
        numerator, denominator = model["B"], model["F"]
        return from_discrete(np.roots(denominator), numerator.sum() / denominator.sum(), recording.period)

    return identify


def sippy_n4sid(recording: Recording, _nominal: Array) -> Array:
    """N4SID with direct term."""
    given, measured = recording.pairs()
    model = importlib.import_module("sippy_unipi").system_identification(
        measured,
        given,
        "N4SID",
        SS_fixed_order=ORDER,
        SS_D_required=True,
        SS_f=BLOCK_ROWS,
        SS_p=BLOCK_ROWS,
        tsample=recording.period,
    )
    return from_state_space(model.A, model.B, model.C, model.D, recording.period)


def nfoursid_n4sid(recording: Recording, _nominal: Array) -> Array:
    """N4SID as nfoursid has it, with direct term."""
    given, measured = recording.pairs()
    table = pd.DataFrame({"u": given, "w": measured})
    method = importlib.import_module("nfoursid.nfoursid").NFourSID(table, ["w"], ["u"], num_block_rows=BLOCK_ROWS)
    method.subspace_identification()
    model, _ = method.system_identification(rank=ORDER)
    return from_state_space(model.a, model.b, model.c, model.d, recording.period)


def llsi_method(method: str, settings: dict[str, Any]) -> Identify:
    """Adapter of one of llsi's state-space methods; their horizon cannot be chosen."""

    def identify(recording: Recording, _nominal: Array) -> Array:
        llsi = importlib.import_module("llsi")
        given, measured = recording.pairs()
        data = llsi.SysIdData(w=measured, u=given, Ts=recording.period, t_start=0.0)
        model = llsi.sysid(data, "w", "u", (ORDER,), method=method, settings=dict(settings))
        return from_state_space(model.A, model.B, model.C, model.D, recording.period)

    return identify


def jax_sysid_continuous(recording: Recording, nominal: Array) -> Array:
    """Continuous-time model in b0, a1, a0 with linear interpolation of the input, L-BFGS from the nominal plant."""
    diffrax, jnp = importlib.import_module("diffrax"), importlib.import_module("jax.numpy")
    models = importlib.import_module("jax_sysid.models")
    importlib.import_module("jax").config.update("jax_enable_x64", True)
    given, measured = recording.pairs()
    # The input was zero before the record, and the first-order hold rises from there.
    given, measured = np.concatenate([[0.0], given]), np.concatenate([[0.0], measured])
    steps = int(np.ceil(recording.period / LONGEST_STEP - 1e-9))
    unit = np.sqrt(nominal[2])

    def derivative(state: Any, applied: Any, _time: Any, parameters: Any) -> Any:
        b0, a1, a0 = parameters[0] * nominal
        acceleration = (b0 * applied[0] - a0 * state[0]) / unit - a1 * state[1]
        return jnp.array([unit * state[1], acceleration])

    model = models.CTModel(ORDER, 1, 1, derivative, output_fcn=lambda state, _applied, _time, _parameters: state[:1])
    model.integration_options("linear", diffrax.Tsit5(), recording.period / steps, max_steps=2 * steps * len(given))
    model.loss(rho_x0=0.0, rho_th=0.0, train_x0=False)
    model.optimization(lbfgs_epochs=200, iprint=-1, lbfgs_tol=1e-12)
    model.init(params=[jnp.ones(3)])
    model.fit(measured[:, None], given[:, None], recording.period * np.arange(len(given)))
    return np.asarray(model.params[0]) * nominal


def sysidentpy_extended_least_squares(recording: Recording, _nominal: Array) -> Array:
    """Linear NARMAX with extended least squares, which can represent white output noise; lags instead of a shift."""
    selection = importlib.import_module("sysidentpy.model_structure_selection")
    estimators = importlib.import_module("sysidentpy.parameter_estimation")
    basis = importlib.import_module("sysidentpy.basis_function")
    model = selection.FROLS(
        order_selection=False,
        n_terms=6,  # all: a constant, two outputs, three inputs
        ylag=ORDER,
        xlag=[1, 2, 3],
        elag=ORDER,
        estimator=estimators.LeastSquares(unbiased=True, uiter=20),
        basis_function=basis.Polynomial(degree=1),
    )
    model.fit(X=recording.signal[:, None], y=recording.output[:, None])
    # 1000 i + j is the code of the variable i (1 the output, 2 the input) with lag j, 0 that of the constant.
    found = {int(code[0]): float(value) for code, value in zip(model.final_model, np.ravel(model.theta), strict=True)}
    denominator = np.array([1.0, -found[1001], -found[1002]])
    numerator = sum(found[code] for code in (2001, 2002, 2003))
    return from_discrete(np.roots(denominator), numerator / denominator.sum(), recording.period)


PEERS = (
    Peer("scipy output error, grid", "scipy", "scipy", "none", lambda r, _: scipy_output_error(r, None)),
    Peer("scipy output error", "scipy", "scipy", "nominal", scipy_output_error),
    Peer("pysib OE", "pysib", "pysib", "none", pysib_method("oe"), 30),
    Peer("pysib Steiglitz–McBride", "pysib", "pysib", "none", pysib_method("sm")),
    Peer("SIPPY N4SID", "sippy_unipi", "sippy-unipi", "none", sippy_n4sid),
    Peer("nfoursid", "nfoursid.nfoursid", "nfoursid", "none", nfoursid_n4sid),
    Peer("llsi N4SID", "llsi", "llsi", "none", llsi_method("n4sid", {})),
    Peer("llsi PEM", "llsi", "llsi", "none", llsi_method("pem", {"init": "po-moesp"}), 20),
    Peer("jax-sysid CTModel", "jax_sysid.models", "jax-sysid", "nominal", jax_sysid_continuous, 3),
    Peer("sysidentpy ELS", "sysidentpy", "sysidentpy", "none", sysidentpy_extended_least_squares),
)
