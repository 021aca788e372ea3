"""Where each number of an actuator, of the forces and of a friction stands in its array; zero switches it off."""

from enum import IntEnum, auto


class _Counted(IntEnum):
    """Members that are counted from zero."""

    @staticmethod
    def _generate_next_value_(name: str, start: int, count: int, last_values: list[int]) -> int:
        return count


class Actuator(_Counted):
    """What happens to the command before it acts; in units of the command u and in seconds."""

    BIAS = auto()  # u
    DEAD_ZONE = auto()  # u, half width
    DEAD_ZONE_SOFTNESS = auto()  # u, width of the rounded corner
    SATURATION = auto()  # u
    SATURATION_ROUNDED = auto()  # one: a hyperbolic tangent
    NEGATIVE_GAIN_EXCESS = auto()  # ratio of the gains minus one
    BACKLASH = auto()  # u, half width
    BACKLASH_SLOPE = auto()  # gain that is left within the gap
    RATE = auto()  # u/s
    RATE_SOFTNESS = auto()  # u, error within which the rate falls in proportion to it
    LAG = auto()  # s
    SECOND_LAG = auto()  # s
    LEVELS = auto()  # u, distance of the levels of a coarse converter
    POWER_EXCESS = auto()  # exponent minus one
    POWER_SCALE = auto()  # u at which the power law has a gain of one


class Force(_Counted):
    """Forces against the input that depend on the motion, in units of u, of the output y and of seconds."""

    CUBIC = auto()  # u/y^3
    QUINTIC = auto()  # u/y^5
    QUADRATIC = auto()  # u/y^2
    DRAG = auto()  # u (s/y)^exponent
    DRAG_EXPONENT = auto()
    AMPLITUDE_DAMPING = auto()  # u s/y^3
    COGGING = auto()  # u
    COGGING_PERIOD = auto()  # y
    COGGING_PHASE = auto()  # rad
    COGGING_SECOND = auto()  # second harmonic relative to the first
    STOP_POSITION = auto()  # y
    STOP_STIFFNESS = auto()  # u/y^exponent
    STOP_EXPONENT = auto()
    HYSTERESIS = auto()  # u
    SHAPE = auto()  # 1/y
    SHAPE_EXPONENT = auto()
    SINE_AMPLITUDE = auto()  # y
    SINE_STIFFNESS = auto()  # u/y
    OUTFLOW = auto()  # u/y^exponent
    OUTFLOW_EXPONENT = auto()
    STIFFNESS_DRIFT = auto()  # u/y/s
    DAMPING_DRIFT = auto()  # u/y
    GAIN_DRIFT = auto()  # 1/s
    DRIFT_MEMORY = auto()  # s, time after which a drift comes to rest; zero: never
    GAP_STIFFNESS = auto()  # u/y, spring that is missing within a gap
    GAP_WIDTH = auto()  # y, half width
    ONE_SIDED_DAMPING = auto()  # u s/y
    FADING_GAIN = auto()  # 1/y^2
    CENTRIFUGAL = auto()  # u s^2/y^3
    EDDY = auto()  # u s/y
    EDDY_VELOCITY = auto()  # y/s
    HEAT = auto()  # 1/u^2, relative loss of force
    HEAT_TIME = auto()  # s
    RELAXING_STIFFNESS = auto()  # u/y
    RELAXING_TIME = auto()  # s
    PUMP = auto()  # u/y, amplitude of a stiffness that swings
    PUMP_FREQUENCY = auto()  # rad/s
    LUGRE_STIFFNESS = auto()  # u/y
    LUGRE_FORCE = auto()  # u
    LUGRE_DAMPING = auto()  # u s/y
    CEILING = auto()  # y, edge of a storage
    CEILING_ON = auto()
    PENDULUM = auto()  # rad^2/s^2, squared natural frequency of a pendulum


class Friction(_Counted):
    """Size of dry friction, in units of u, of the output y and of seconds."""

    FORWARD = auto()  # u, in the motion to larger y
    BACKWARD = auto()  # u
    BREAKAWAY_EXCESS = auto()  # u
    VELOCITY = auto()  # y/s
    GRADIENT = auto()  # u/y
    LOAD = auto()  # friction for a unit of the transmitted force
    LORENTZIAN = auto()  # one: the excess falls as 1/(1 + (v/v_s)^2)
