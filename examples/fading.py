"""An effect of a user's own; docs/adding_an_effect.md explains it."""

from camid.effects import Effect, Parameter, compiled


class FadingForceConstant(Effect):
    """A coil that leaves its magnet: its force falls with the square of the displacement."""

    identifier = "fading-force-constant"
    place = "plant"
    title = "Force constant that fades with the displacement"
    equation = r"f = c\,y^2\,u"
    reference = "Klippel (2006), J. Audio Eng. Soc. 54, 907-939"
    parameters = (Parameter("coefficient", "1/y^2", "relative loss c of force at the displacement one"),)
    strength = "coefficient"

    @compiled
    def force(time, position, velocity, signal, memory, values):
        return values[0] * position * position * signal

    @classmethod
    def candidates(cls, situation):
        """A small loss: the effect is proportional to it."""
        yield cls(coefficient=0.02 / situation.largest("position") ** 2)
