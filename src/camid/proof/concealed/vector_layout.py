"""Names of the places in the integrator's parameter vector and state vector.

Every parameter is in physical units (kg, N, m, s, V) and is zero where the machine has no such part.
"""

from __future__ import annotations

# The machine: m x'' + c x' + k x = F (a mass of zero makes it first order), and a second mode or lag in series.
MASS, DAMPING, STIFFNESS, ACTUATOR_CONSTANT = 0, 1, 2, 3
SERIES_FREQUENCY, SERIES_DAMPING, SERIES_LAG = 4, 5, 6
SECOND_SERIES_FREQUENCY, SECOND_SERIES_DAMPING = 7, 8
# Actuator: lags in s, slew in V/s with its softness in s.
LAG, SECOND_LAG, SOFT_SLEW, SOFT_SLEW_TIME = 9, 10, 11, 12
# Actuator constant that depends on position [1/m], on speed [m/s], on position periodically [1, m, rad].
POSITION_GAIN, SPEED_LIMIT, RIPPLE, RIPPLE_PITCH, RIPPLE_PHASE = 13, 14, 15, 16, 17
# Dry friction with true sticking: levels in N, Stribeck velocity in m/s.
DRY_COULOMB, DRY_BREAKAWAY, DRY_VELOCITY = 18, 19, 20
# Bristle friction (LuGre, Dahl): the same levels, bristle stiffness in N/m and bristle damping in N s/m.
BRISTLE_COULOMB, BRISTLE_BREAKAWAY, BRISTLE_VELOCITY, BRISTLE_STIFFNESS, BRISTLE_DAMPING = 21, 22, 23, 24, 25
# Drag in N (s/m)^exponent; damping that depends on position in N s/m³.
DRAG, DRAG_EXPONENT, POSITION_DAMPING = 26, 27, 28
# Springs in N/m², N/m³, N/m⁵; pendulum length in m, and whether its force acts horizontally; gap in m.
QUADRATIC, CUBIC, QUINTIC, PENDULUM, HORIZONTAL_FORCE, GAP = 29, 30, 31, 32, 33, 34
SIDE_STIFFNESS, SIDE_LENGTH = 35, 36
# Stop: position in m and side (+1 or -1; 0 is none), stiffness in N/m^exponent, damping in N s/m.
STOP_SIDE, STOP_POSITION, STOP_STIFFNESS, STOP_EXPONENT, STOP_DAMPING = 37, 38, 39, 40, 41
# Bouc–Wen: force in N, shape in 1/m, exponent.
LOOP_FORCE, LOOP_SHAPE, LOOP_EXPONENT = 42, 43, 44
# Jenkins elements: largest stiffness in N/m and slip force in N of elements that share them evenly.
JENKINS_STIFFNESS, JENKINS_FORCE = 45, 46
# Detent: force in N, pitch in m, phase in rad.
DETENT, DETENT_PITCH, DETENT_PHASE = 47, 48, 49
# Hidden mass on its spring: kg, N/m, N s/m, N/m³.
HIDDEN_MASS, HIDDEN_STIFFNESS, HIDDEN_DAMPING, HIDDEN_CUBIC = 50, 51, 52, 53
# Three Maxwell elements: total stiffness in N/m, slowest relaxation time in s and the ratio of neighbours.
MAXWELL_STIFFNESS, MAXWELL_TIME, MAXWELL_RATIO = 54, 55, 56
# Drift of stiffness (1), damping (2) or actuator constant (3): relative rate in 1/s, time constant in s (0: linear).
DRIFT_KIND, DRIFT_RATE, DRIFT_TIME = 57, 58, 59
# Disturbing forces in V at the actuator: sine, its second harmonic, step, half-sine; times in s.
SINE, SINE_FREQUENCY, SINE_PHASE, HARMONIC, HARMONIC_PHASE = 60, 61, 62, 63, 64
STEP, STEP_TIME, PULSE, PULSE_TIME, PULSE_DURATION = 65, 66, 67, 68, 69
# Speed in m/s that the machine hardly exceeds: for the choice of the step alone.
TOP_SPEED = 70
# Dry friction that depends on the direction [1], on the position [1/m, m] and on the load [N/N]: see dry_level.
DRY_DIRECTION, DRY_SLOPE, DRY_WIDTH, DRY_LOAD = 71, 72, 73, 74
# Second harmonic of the detent, as a share of it, and its phase in rad.
DETENT_HARMONIC, DETENT_HARMONIC_PHASE = 75, 76
# Damping in N s/m² for a unit of the distance from rest.
DISTANCE_DAMPING = 77
# Outflow of a storage in N/m^exponent; height in m of its edge (0: none) and side (+1 or -1).
OUTFLOW, OUTFLOW_EXPONENT, EDGE_SIDE, EDGE_HEIGHT = 78, 79, 80, 81
# A mode beside the machine: static displacement in m/N, rad/s, damping ratio; it swings by itself.
EDGE_WEIR = 82  # N/m^1.5 of what flows over the edge; zero holds the level exactly
BESIDE_COMPLIANCE, BESIDE_FREQUENCY, BESIDE_DAMPING = 83, 84, 85
# Whether the sensor sees the hidden mass.
HIDDEN_IS_SEEN = 86
# A winding that warms up: relative loss of the force at rest temperature for a V² that is kept up [1/V²], and s.
WINDING_HEATING, WINDING_TIME = 87, 88
# Force of the reluctance for a V² and a unit of the distance from the middle of the coil, in N/(V² m).
RELUCTANCE = 89
# Wave that travels along the way: force in N, length in m and frequency in rad/s.
WAVE, WAVE_LENGTH, WAVE_FREQUENCY = 90, 91, 92
# Stiffness that swings in time: share of the mount's, rad/s and rad.
STIFFNESS_SWING, STIFFNESS_SWING_FREQUENCY, STIFFNESS_SWING_PHASE = 93, 94, 95
# Supply that sags under the actuator's current: relative loss of the reading for a V [1/V], and s.
SUPPLY_SAG, SUPPLY_TIME = 96, 97
PARAMETERS = 98

# State: position, velocity, the series element's two, a second one's two, the hidden mass's two, bristle deflection or
# Bouc–Wen variable, Maxwell forces, the actuator's two, the time integral of the measured position, the two of the
# mode beside the machine, the relative rise of a winding's resistance, and the voltage in V whose current a supply has
# followed.
POSITION, VELOCITY, SERIES, SERIES_RATE, SECOND_SERIES, SECOND_SERIES_RATE = 0, 1, 2, 3, 4, 5
HIDDEN, HIDDEN_RATE, BRISTLE, LOOP, MAXWELL, ACTUATOR, SECOND_ACTUATOR, INTEGRAL = 6, 7, 8, 9, 10, 13, 14, 15
BESIDE, BESIDE_RATE = 16, 17
WARMTH, DRAWN = 18, 19
STATES = 20
# Memory: forces of the Jenkins elements, the position they belong to, whether the stop is touched, and a time in s
# within the step, which says what acts during all of it.
JENKINS_ELEMENTS = 6
LAST_POSITION, TOUCHING, WITHIN = 6, 7, 8
MEMORY = 9
