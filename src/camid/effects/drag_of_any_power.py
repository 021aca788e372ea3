"""Drag that grows with any power of the speed: between viscous and turbulent, or steeper, as a damper's may be."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.damping import QuadraticDrag
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.plant_force import motion_sign
from camid.effects.situation import Situation

LEAST, LARGEST = 0.3, 5.0
FIRST = (1.5, 2.7)
# Distance of a power from one below which the drag is viscous, and the plant's own.
VISCOUS = 0.1


class DragOfAnyPower(QuadraticDrag):
    """Resistance that grows with a power of the speed.

    Its coefficient is that of the quadratic drag which is as large at a speed that is stated: one of the power itself
    would have another unit with each power.
    """

    title = "Drag of any power"
    equation = r"f = c\,v_0^2\,|\dot y/v_0|^p\,\mathrm{sgn}(\dot y)"
    reference = "Symans & Constantinou (1998), J. Struct. Eng. 124, 1113-1122"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        *QuadraticDrag.parameters,
        Parameter("power", "", "power p of the speed", LEAST, LARGEST, scale="one"),
        Parameter("speed", "y/s", "speed v_0, as stated, at which the power does not matter", 1e-300, stated=True),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        share = abs(velocity) / values[2]
        if share == 0.0:
            return 0.0
        size = values[0] * values[2] * values[2] * share ** values[1]
        return size if velocity > 0.0 else -size

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Coefficient with the sign of the plant's gain, power and speed."""
        return [motion_sign(plant) * self.values["coefficient"], self.values["power"], self.values["speed"]]

    def is_plausible(self, extent: Extent) -> bool:
        """Whether it is no viscous drag, which the plant's damping is."""
        return bool(abs(self.values["power"] - 1.0) > VISCOUS) and super().is_plausible(extent)

    def simplified(self) -> QuadraticDrag:
        """Quadratic drag that is as large at the stated speed."""
        return QuadraticDrag(coefficient=self.values["coefficient"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Of a lower and of a higher power, as large as the quadratic drag at the usual speed."""
        usual = float(f"{float(np.std(situation.velocity)) or 1.0:.2g}")
        yield from (cls(**values, power=power, speed=usual) for power in FIRST)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from quadratic drag that was found."""
        yield from ()
