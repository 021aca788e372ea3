"""The camera as a position sensor: the paper's three models and the discrete-time model that follows from the first.

The camera delivers the mean of the position over the exposure. Model #1 is exact; Model #2 (mean of two instants) and
Model #3 (half a period of delay) are the approximations that the paper compares it with.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.companion_form import companion, derivative_rows, time_scale
from camid.chain.exact import respond, sample
from camid.chain.plant import TransferFunction

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


# -- frequency responses ----------------------------------------------------------------------------------------------


def model_1_response(
    angular_frequency: ArrayLike, period: float, exposure: float | None = None, latency: float = 0.0
) -> ComplexArray:
    """Model #1, second version, paper equation (12): (1 − e^(−τs))/(τs), followed by a latency.

    Parameters
    ----------
    angular_frequency : array_like
        rad/s, any shape; zero is allowed.
    period : float
        T in seconds; the exposure where none is given.
    exposure, latency : float
        τ and ℓ in seconds.

    Returns
    -------
    ndarray, complex, same shape
    """
    duration = period if exposure is None else exposure
    angle = 0.5 * duration * np.asarray(angular_frequency, dtype=float)
    # np.sinc(x) is sin(πx)/(πx), finite at zero.
    delay = np.exp(-1j * angle * (1.0 + 2.0 * latency / duration))
    return np.asarray(np.sinc(angle / np.pi) * delay, dtype=np.complex128)


def model_1_first_version_response(angular_frequency: ArrayLike, period: float) -> ComplexArray:
    """Model #1, first version (Fig. 4): an integrator, a sampler and H(z) of (8), for a tone below or above 1/(2T)."""
    s = 1j * np.asarray(angular_frequency, dtype=float)
    return np.asarray((1.0 - np.exp(-s * period)) / period / s, dtype=np.complex128)


def model_2_response(angular_frequency: ArrayLike, period: float) -> ComplexArray:
    """Model #2: (1 + z^-1)/2 at z = e^(jωT) (Ranftl et al. 2007)."""
    delayed = np.exp(-1j * period * np.asarray(angular_frequency, dtype=float))
    return np.asarray(0.5 * (1.0 + delayed), dtype=np.complex128)


def model_3_response(angular_frequency: ArrayLike, period: float) -> ComplexArray:
    """Model #3: a delay of half a period, e^(−Ts/2)."""
    return np.exp(-0.5j * period * np.asarray(angular_frequency, dtype=float))


# -- python-control systems -------------------------------------------------------------------------------------------


def averaging_filter(period: float) -> control.TransferFunction:
    """H(z) = (1 − z^-1)/T of (8): turns samples of the integrated position into the camera's measurements."""
    import control

    return control.tf([1.0, -1.0], [period, 0.0], period)


def model_1(period: float, angular_frequency: ArrayLike) -> control.FrequencyResponseData:
    """Model #1 as a python-control frequency response (a delay has no rational transfer function)."""
    import control

    frequencies = np.asarray(angular_frequency, dtype=float)
    return control.frd(model_1_response(frequencies, period), frequencies, smooth=True)


def model_1_rational(period: float, order: int = 6) -> control.TransferFunction:
    """Model #1 with a Padé approximation of e^(−Ts), for simulation in continuous time.

    The zero of 1 − e^(−Ts) at s = 0 cancels the integrator exactly, so it is divided out of the polynomials.
    """
    import control

    numerator, denominator = control.pade(period, order)
    difference = np.polysub(denominator, numerator)
    return control.tf(difference[:-1], period * np.asarray(denominator))


def model_2(period: float) -> control.TransferFunction:
    """Model #2 as a discrete-time python-control transfer function."""
    import control

    return control.tf([1.0, 1.0], [2.0, 0.0], period)


def model_3(period: float, angular_frequency: ArrayLike) -> control.FrequencyResponseData:
    """Model #3 as a python-control frequency response."""
    import control

    frequencies = np.asarray(angular_frequency, dtype=float)
    return control.frd(model_3_response(frequencies, period), frequencies, smooth=True)


# -- discrete-time models ---------------------------------------------------------------------------------------------


def sampled_model(plant: TransferFunction, acquisition: Acquisition) -> control.TransferFunction:
    """Exact discrete-time transfer function from u_k to w_k, equation (14) for a held input and the full exposure.

    Any hold, exposure and latency: the impulse response of the exact chain gives the numerator, whose length is known
    because the plant's poles are.

    Parameters
    ----------
    plant : TransferFunction
    acquisition : Acquisition

    Returns
    -------
    control.TransferFunction
        With the sampling period; numerator and denominator in powers of z, equal lengths.
    """
    import control

    denominator = np.real(np.poly(np.exp(plant.poles() * acquisition.period)))
    delay, _, _, straddles = acquisition.window()
    length = plant.order + delay + 2 + int(straddles)
    # A first-order hold rises before its corner, so its impulse needs a sample in front.
    lead = 1 if acquisition.hold == "foh" else 0
    impulse = np.zeros(length + lead)
    impulse[lead] = 1.0
    response = sample(plant, impulse, acquisition)[lead:]
    numerator = np.convolve(denominator, response)[:length]
    numerator[np.abs(numerator) < 1e-14 * np.max(np.abs(numerator))] = 0.0
    numerator = np.trim_zeros(numerator, "b")
    size = max(len(numerator), len(denominator))
    return control.tf(
        np.pad(numerator, (0, size - len(numerator))),
        np.pad(denominator, (0, size - len(denominator))),
        acquisition.period,
    )


@dataclass(frozen=True)
class ClosedForm:
    """Coefficients of the paper's (16): z^-1 (β0 + β1 z^-1 + β2 z^-2)/(1 − α1 z^-1 + α2 z^-2)."""

    beta: tuple[float, float, float]
    alpha: tuple[float, float]


def closed_form(static_gain: float, natural_frequency: float, damping: float, period: float) -> ClosedForm:
    """The paper's closed form (16)–(23) for a second-order mode driven by a held input and seen by a camera.

    Parameters
    ----------
    static_gain : float
        K.
    natural_frequency : float
        ω0 in rad/s.
    damping : float
        ξ < 1.
    period : float
        T in seconds, which is the exposure, too.
    """
    gain, omega, xi, T = static_gain, natural_frequency, damping, period  # noqa: N806 - the paper's symbol
    w = omega * np.sqrt(1.0 - xi**2)
    alpha_1 = 2.0 * np.exp(-xi * omega * T) * np.cos(w * T)
    alpha_2 = np.exp(-2.0 * xi * omega * T)
    ratio = 2.0 * xi / (omega * T)
    g = (ratio * np.cos(w * T) + (1.0 - 2.0 * xi**2) / (w * T) * np.sin(w * T)) * np.exp(-xi * omega * T)
    beta_0 = gain * (ratio * (alpha_1 - 1.0) + 1.0 - g)
    beta_1 = gain * (ratio * (1.0 - alpha_1 - alpha_2) - alpha_1 + 2.0 * g)
    beta_2 = gain * (alpha_2 * (ratio + 1.0) - g)
    return ClosedForm((float(beta_0), float(beta_1), float(beta_2)), (float(alpha_1), float(alpha_2)))


def first_order_hold_equivalent(plant: TransferFunction, period: float) -> control.TransferFunction:
    """Triangle-hold equivalent of a plant by python-control, the reference for the remark after (14)."""
    import control

    return control.sample_system(plant.to_control(), period, method="foh")


def measurement_from_integral(plant: TransferFunction, signal: Array, period: float) -> Array:
    """Model #1, first version, run literally: integrate the position, sample the integral, difference it (Fig. 4).

    Parameters
    ----------
    plant : TransferFunction
    signal : ndarray, shape (N,)
        Input samples, held.
    period : float
        Seconds.

    Returns
    -------
    ndarray, shape (N,)
        w_k = (v_k − v_{k−1})/T with v_{-1} = 0.
    """
    monic = plant.monic
    integrated = TransferFunction(monic.numerator, (*monic.denominator, 0.0))
    unit = time_scale(monic.denominator)
    order, degree = integrated.order, len(monic.numerator) - 1
    denominator = np.asarray(integrated.denominator) * unit ** np.arange(order + 1)
    numerator = np.asarray(monic.numerator) * unit ** (order - degree + np.arange(degree + 1.0))
    selection = numerator @ derivative_rows(denominator, range(degree, -1, -1))
    integral = respond(
        companion(denominator),
        np.eye(order)[0],
        np.zeros(order),
        selection[None, :],
        np.asarray(signal, dtype=float),
        Acquisition(period, "zoh", "instant"),
        unit,
    )[:, 0]
    return np.diff(integral, prepend=0.0) / period
