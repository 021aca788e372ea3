"""The machine of a concealed recording: a mass on a spring, driven by an actuator and seen by a camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction, second_order
from camid.proof.concealed import vector_layout as s

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rig:
    """Linear part of the machine, in physical units.

    Attributes
    ----------
    mass : float
        kg; zero makes a machine of first order.
    damping, stiffness : float
        N s/m and N/m.
    actuator_constant : float
        N/V.
    output_scale : float
        Units of the recorded output in a metre: 1 for metres, 1e3 for millimetres, any number for pixels.
    series_frequency, series_damping : float
        Natural frequency in rad/s and damping ratio of a declared second mode in series (paper equation (26)); zero is
        none.
    series_lag : float
        Time constant in s of a declared lag in series; zero is none.
    """

    mass: float
    damping: float
    stiffness: float
    actuator_constant: float
    output_scale: float
    series_frequency: float = 0.0
    series_damping: float = 0.0
    series_lag: float = 0.0

    @property
    def order(self) -> int:
        """Number of poles."""
        return (2 if self.mass else 1) + (2 if self.series_frequency else 0) + (1 if self.series_lag else 0)

    @property
    def rate(self) -> float:
        """Natural frequency, or rate of decay of a machine of first order, in rad/s."""
        return float(np.sqrt(self.stiffness / self.mass)) if self.mass else self.stiffness / self.damping

    def transfer_function(self) -> TransferFunction:
        """From V to the units of the output, monic denominator."""
        denominator = (self.mass, self.damping, self.stiffness) if self.mass else (self.damping, self.stiffness)
        plant = TransferFunction((self.actuator_constant * self.output_scale,), denominator)
        if self.series_frequency:
            plant = plant * second_order(1.0, self.series_frequency, self.series_damping)
        if self.series_lag:
            plant = plant * TransferFunction((1.0,), (self.series_lag, 1.0))
        return plant.monic

    def parameters(self) -> Array:
        """For the integrator: only this machine."""
        p = np.zeros(s.PARAMETERS)
        p[[s.MASS, s.DAMPING, s.STIFFNESS, s.ACTUATOR_CONSTANT]] = (
            self.mass,
            self.damping,
            self.stiffness,
            self.actuator_constant,
        )
        p[[s.SERIES_FREQUENCY, s.SERIES_DAMPING, s.SERIES_LAG]] = (
            self.series_frequency,
            self.series_damping,
            self.series_lag,
        )
        return p

    def believed(self, generator: np.random.Generator) -> TransferFunction:
        """The plant as the user believes it: coefficients wrong by 2 to 10 %.

        Above second order it is the coefficients of each element that are wrong, as independent errors of the product's
        would make a lightly damped plant unstable.
        """

        def wrong(value: float) -> float:
            return value * (1.0 + generator.choice([-1.0, 1.0]) * generator.uniform(0.02, 0.1))

        return Rig(
            self.mass,
            wrong(self.damping),
            wrong(self.stiffness),
            wrong(self.actuator_constant),
            self.output_scale,
            wrong(self.series_frequency),
            wrong(self.series_damping),
            wrong(self.series_lag),
        ).transfer_function()


def draw_rig(generator: np.random.Generator, order: int, output_size: float, input_size: float) -> Rig:
    """A machine with a natural frequency of 1 to 60 rad/s and a damping ratio of 0.02 to 0.7.

    Parameters
    ----------
    generator : numpy.random.Generator
    order : {1, 2, 3, 4}
    output_size, input_size : float
        Sizes of the output and of the input that belong together within a factor of two, in their units.
    """
    rate = float(np.exp(generator.uniform(np.log(1.0), np.log(60.0))))
    ratio = float(np.exp(generator.uniform(np.log(0.02), np.log(0.7))))
    mass = float(np.exp(generator.uniform(np.log(0.1), np.log(10.0))))
    stroke = float(np.exp(generator.uniform(np.log(1e-3), np.log(0.2))))
    stiffness = mass * rate**2
    constant = stiffness * stroke / input_size * generator.uniform(0.5, 2.0)
    scale = output_size / stroke
    if order == 1:
        return Rig(0.0, stiffness / rate, stiffness, constant, scale)
    damping = 2.0 * ratio * mass * rate
    if order == 2:
        return Rig(mass, damping, stiffness, constant, scale)
    above = generator.uniform(1.8, 4.0)
    if order == 3:
        return Rig(mass, damping, stiffness, constant, scale, series_lag=1.0 / (above * rate))
    return Rig(
        mass,
        damping,
        stiffness,
        constant,
        scale,
        series_frequency=above * rate,
        series_damping=float(np.exp(generator.uniform(np.log(0.02), np.log(0.3)))),
    )
